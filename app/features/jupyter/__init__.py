"""Duet inside Jupyter: a tile in the launcher of a notebook server, and the page in a notebook's cell."""

from pathlib import Path
from typing import Final

from app.feature import Feature

JUPYTER: Final = Feature("jupyter", texts=Path(__file__).parent)
