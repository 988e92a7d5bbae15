"""Where our own lessons are."""

from pathlib import Path
from typing import Final

FOLDER: Final = Path(__file__).parent / "files"
"""Folder of our own twelve lessons, as Markdown."""
