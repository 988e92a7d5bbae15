"""Duet inside Jupyter: a tile in the launcher, and the page in a notebook."""
