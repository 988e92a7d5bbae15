"""In a real browser the longest language is cut off nowhere, and a browser's own language is understood."""

from __future__ import annotations

import pytest
from playwright.sync_api import Page

from app.languages.pseudo import pseudo
from app.page.controls import TABS
from tests.app.conftest import OpenHouse
from tests.browser import PageAt, close_software_note, until

CUT = """() => {
  const cut = [];
  for (const e of document.querySelectorAll('label, button, [role=tab], .mantine-Button-label, .duet *, .duet-caption, .duet-caption *')) {
    const box = e.getBoundingClientRect(), style = getComputedStyle(e);
    if (!box.width || !box.height || style.visibility === 'hidden' || style.overflowX === 'visible') continue;
    // A formula may be wider than its place, and is then moved by hand.
    if (e.closest('svg, pre, .duet-formula') || !e.textContent.trim()) continue;
    if (e.scrollWidth > e.clientWidth + 1) cut.push(`${e.textContent.trim().slice(0, 60)}: ${e.scrollWidth} in ${e.clientWidth}`);
  }
  if (document.documentElement.scrollWidth > innerWidth) cut.push(`the page: ${document.documentElement.scrollWidth} in ${innerWidth}`);
  return cut;
}"""
"""The texts that are cut off, with the width that they need and the one that they have [px]."""

LABELS = (
    "() => [...document.querySelectorAll('label')].filter(e => e.checkVisibility() && e.getBoundingClientRect().width)"
    ".map(e => e.textContent.trim())"
    ".filter(t => /[A-Za-z]{4}/.test(t) && !t.includes('⟦'))"
)
"""Labels that are English."""


def open_page(page: Page, url: str) -> None:
    """Open a page, and wait until its controls are there."""
    page.set_default_timeout(60_000)
    page.goto(url)
    page.get_by_role("tab").nth(len(TABS)).wait_for(state="attached")
    close_software_note(page)


@pytest.mark.parametrize(("width", "height"), [(1024, 768), (390, 844)])
def test_nothing_is_cut_off(house: OpenHouse, page_at: PageAt, width: int, height: int) -> None:
    page = page_at(width, height)
    open_page(page, f"{house().url}/?lang=pseudo&ghost=frozen&autopilot=0")
    for name, seen in {"Law": "law", "Arms": "task", "Compare": "ghost", "View": "language", "Keys": "start anew"}.items():
        page.get_by_role("tab", name=pseudo(name)).click()
        page.get_by_text(pseudo(seen), exact=True).first.wait_for()
        assert page.evaluate(CUT) == [], name
        assert page.evaluate(LABELS) == [], name
    # A lesson's panel, too.
    page.get_by_role("button", name=pseudo("Lessons")).evaluate("e => e.click()")
    page.locator(".duet-l-head").wait_for()
    until(page, lambda: page.get_by_role("button", name=pseudo("Reset step")).count() > 0, "the lesson's buttons")
    assert page.evaluate(CUT) == []


def test_a_browser_says_what_its_person_reads(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1024, 768, locale="sl-SI")
    open_page(page, house().url)
    page.get_by_role("tab", name="Pogled").wait_for()
    until(page, lambda: page.evaluate("document.documentElement.lang") == "sl", "the page's own language")
