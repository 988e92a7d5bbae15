"""Duet inside Jupyter: a tile in the launcher of a notebook server, and the page in a notebook's cell."""

from typing import Final

from app.feature import Feature

JUPYTER: Final = Feature("jupyter")
