"""Translations of the page's texts; see README.md."""
