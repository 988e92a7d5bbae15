"""Handles of the things that an operator moves."""
