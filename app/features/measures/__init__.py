"""Measurements of a run: distances, hand errors, joint speeds, the line of contact, stability."""

from pathlib import Path
from typing import Final

from app.feature import Feature

MEASURES: Final = Feature("measures", texts=Path(__file__).parent)
