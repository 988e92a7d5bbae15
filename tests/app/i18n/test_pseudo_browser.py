"""In a real browser no text of the longest language is cut, and the browser's language is used."""

import pytest
from playwright.sync_api import Page

from app.i18n.catalogue import pseudo
from app.page.panels.controls import TABS
from tests.app.conftest import OpenHouse
from tests.browser import PageAt, close_software_note, lasting, until
from tests.fonts import FONTS, Font
from tests.tools.page_flaws import flaws

ENGLISH = """() => {
  const found = new Set();
  const look = (text, what) => { if (text && /[A-Za-z]{3}/.test(text.replace(/⟦.*⟧/s, ''))) found.add(`${what}: ${text.trim()}`); };
  const all = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (all.nextNode()) {
    const parent = all.currentNode.parentElement;
    // Names of robots, of keys, of what stands in the scene, and formulas; what is hidden.
    if (parent.closest('svg, sub, style, script, noscript, kbd, pre, [class*=tableRow], [class*=Spotlight-actionDescr]')) continue;
    look(all.currentNode.data, parent.tagName);
  }
  for (const e of document.querySelectorAll('[aria-label], [placeholder], [title]'))
    for (const name of ['aria-label', 'placeholder', 'title']) look(e.getAttribute(name), name);
  return [...found];
}"""
"""English texts of the page, visible or for screen readers."""

OBJECTS = {
    "WorldAxes",
    "light",
    "floor",
    "room",
    "arms",
    "closest",
    "contact",
    "tint",
    "place",
    "touch",
    "trace",
    "gizmo",
    "grip",
    "other_grip",
}


def english(page: Page) -> list[str]:
    return [
        text for text in page.evaluate(ENGLISH) if text.partition(": ")[2].rpartition("/")[2] not in OBJECTS
    ]


def open_page(page: Page, url: str) -> None:
    page.set_default_timeout(60_000)
    page.goto(url)
    page.get_by_role("tab").nth(len(TABS)).wait_for(state="attached")
    close_software_note(page)


@pytest.mark.thorough
@pytest.mark.parametrize("font", FONTS)
@pytest.mark.parametrize(("width", "height"), [(1024, 768), (390, 844)])
def test_nothing_is_cut_off(house: OpenHouse, page_at: PageAt, width: int, height: int, font: Font) -> None:
    page = page_at(width, height, font=font)
    open_page(page, f"{house().url}/?lang=pseudo&ghost=frozen&autopilot=0")
    for name, seen in {
        "Law": "law",
        "Arms": "task",
        "Compare": "ghost",
        "View": "language",
        "Keys": "restart the run",
    }.items():
        page.get_by_role("tab", name=pseudo(name)).click()
        page.get_by_text(pseudo(seen), exact=True).first.wait_for()
        assert lasting(page, lambda: flaws(page)) == [], name
        # The page's script translates viser's texts slightly later.
        until(page, lambda: english(page) == [], f"the last English word of {name}")
    page.get_by_role("button", name=pseudo("Lessons")).evaluate("e => e.click()")
    page.locator("button.lesson").nth(10).wait_for()
    assert lasting(page, lambda: flaws(page)) == []
    page.locator("button.lesson").first.evaluate("e => e.click()")
    page.locator(".duet-l-head").wait_for()
    until(
        page,
        lambda: page.get_by_role("button", name=pseudo("Reset step")).count() > 0,
        "the lesson's buttons",
    )
    assert lasting(page, lambda: flaws(page)) == []


@pytest.mark.thorough
def test_a_page_opens_in_the_browsers_language(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1024, 768, locale="sl-SI")
    opened = house()
    open_page(page, opened.url)
    page.get_by_role("tab", name="Pogled").wait_for()
    until(page, lambda: page.evaluate("document.documentElement.lang") == "sl", "the page's own language")
    page.keyboard.press("Control+k")
    page.get_by_placeholder("Poiščite ukaz …").wait_for()
    opened.close()
    page.locator("#duet-connection").get_by_text("Povezava prekinjena – poskušam znova …").wait_for()
