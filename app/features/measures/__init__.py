"""Measurements of a run."""

from pathlib import Path
from typing import Final

from app.feature import Feature

MEASURES: Final = Feature("measures", texts=Path(__file__).parent)
