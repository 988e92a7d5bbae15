"""Finds cut-off, covered and overlapping text on a page."""

from pathlib import Path
from typing import Final

from playwright.sync_api import Page

_FIND: Final = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")


def flaws(page: Page) -> list[str]:
    """Faults of the page's present texts."""
    return page.evaluate(_FIND)
