"""Finds text on a page that is cut off, covered, or written over another text."""

from pathlib import Path
from typing import Final

from playwright.sync_api import Page

_FIND: Final = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")


def flaws(page: Page) -> list[str]:
    """Faults of the texts that a page shows now."""
    return page.evaluate(_FIND)
