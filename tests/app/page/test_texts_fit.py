"""Cut, covered and overlapping texts are found, test fonts apply, and a row of tabs fits."""

import sys

import pytest

from app.page import STATIC
from tests.browser import PageAt, until
from tests.fonts import FONTS, Font
from tests.tools.page_flaws import flaws


def test_flaws_are_found(page_at: PageAt) -> None:
    page = page_at(300, 200)
    for body, kinds in {
        "<p>one line</p><p>another</p>": [],
        '<p style="width:30px;overflow:hidden;white-space:nowrap">much too long for that</p>': [
            "cut at a side"
        ],
        '<p style="height:9px;overflow:hidden">one<br>two</p>': ["cut above or below"],
        '<div style="height:30px;overflow:auto">one<br>two<br>three<br>four</div>': [],
        '<p>under</p><div style="position:fixed;inset:0;background:#fff"></div>': ["covered by"],
        '<p style="position:absolute;top:5px">first</p><p style="position:absolute;top:8px">second</p>': [
            "over each other"
        ],
        '<p style="position:absolute;left:-20px">half outside</p>': ["cut at a side"],
        '<p class="duet" style="width:30px;overflow-x:auto;white-space:nowrap">to be moved by hand</p>': [
            "too wide"
        ],
        '<div style="width:500px;height:9px"></div>': ["too wide"],
        '<p data-floating-window style="position:fixed;top:190px">half below</p>': ["beyond the window"],
    }.items():
        page.set_content(body)
        found = flaws(page)
        assert {text.split(":")[0].split(" p.")[0].split(" div.")[0] for text in found} >= set(kinds), body
        assert bool(found) == bool(kinds), found


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no fontconfig")
@pytest.mark.parametrize(("font", "regular", "bold"), [("wide", 0.613, 0.675), ("narrow", 0.556, 0.556)])
def test_every_font_list_resolves_to_the_test_font(
    font: Font, regular: float, bold: float, page_at: PageAt
) -> None:
    """Parameters: advance widths of the letter a [font sizes], of DejaVu Sans and of Helvetica."""
    page = page_at(300, 200, font=font)
    page.set_content("<span>aaaaaaaaaa</span>")
    measure = "(span, font) => { span.style.font = font; return span.getBoundingClientRect().width / 1000; }"
    for family in (
        "sans-serif",
        "system-ui",
        "Arial",
        "Roboto, sans-serif",
        '-apple-system, "Segoe UI", "Liberation Sans", sans-serif',
    ):
        for weight, width in ((400, regular), (600, bold)):
            found = page.locator("span").evaluate(measure, f"{weight} 100px {family}")
            assert found == pytest.approx(width, rel=0.03), (family, weight)


BROKEN_ROWS = """() => [...document.querySelectorAll('[role=tablist]')].filter(row => row.clientWidth).flatMap(row => {
  const box = row.getBoundingClientRect(), tabs = [...row.querySelectorAll('[role=tab]')];
  const places = tabs.map(tab => tab.getBoundingClientRect());
  const whole = tabs.every((tab, i) => places[i].top === places[0].top && places[i].right <= box.right + 0.5 && tab.title
    && [...tab.querySelectorAll('svg, span')].some(part => part.clientWidth > 1 || part.getBoundingClientRect().width > 1));
  return whole ? [] : [tabs.map((tab, i) => [tab.textContent.trim(), tab.title, places[i].top, places[i].right - box.right])];
})"""
"""Faulty rows of tabs: several lines, wider than the panel, or a tab without icon and name or without tip."""


ROW = (
    """<div role="tablist" style="display:flex;flex-wrap:wrap;overflow:hidden;font:13px sans-serif"></div>"""
)
FILL = """names => { const row = document.querySelector('[role=tablist]');
  row.innerHTML = names.map(name => `<div role="tab" data-dock-tab style="display:flex;overflow:hidden">
    <div><svg width="13" height="13"></svg></div><span>${name}</span></div>`).join(''); }"""


@pytest.mark.parametrize("font", FONTS)
def test_a_row_of_tabs_drops_icons_then_names_until_it_fits(font: Font, page_at: PageAt) -> None:
    page, names = page_at(600, 200, font=font), ["Law", "Arms", "Robot", "Compare", "View", "Keys"]
    style, script = ((STATIC / name).read_text(encoding="utf-8") for name in ("style.css", "tab_row.js"))
    page.set_content(f"<!doctype html><style>{style}</style><script>{script}</script><body>{ROW}")
    row = page.get_by_role("tablist")

    def becomes(level: str) -> None:
        until(page, lambda: row.get_attribute("data-duet-tabs") == level, f"a row of {level}")
        assert page.evaluate(BROKEN_ROWS) == []
        # A hidden name is still the tip and the accessible name.
        assert [tab.get_attribute("title") for tab in row.get_by_role("tab").all()] == names
        assert all(row.get_by_role("tab", name=name, exact=True).count() == 1 for name in names)
        seen = {"both": (True, True), "names": (False, True), "icons": (True, False)}[level]
        sizes = row.evaluate(
            "row => ['svg', 'span'].map(part => row.querySelector(part).getBoundingClientRect().width > 1)"
        )
        assert tuple(sizes) == seen

    page.evaluate(FILL, names)
    becomes("both")
    page.set_viewport_size({"width": 300, "height": 200})
    becomes("names")
    page.set_viewport_size({"width": 210, "height": 200})
    becomes("icons")
    page.set_viewport_size({"width": 600, "height": 200})
    becomes("both")
    # Larger text, a longer name, one more tab: the row is measured again after each change and its undoing.
    for size, level in (("60px", "icons"), ("13px", "both")):
        row.evaluate("(row, size) => { row.style.fontSize = size; }", size)
        becomes(level)
    for name, level in (
        ("A name that leaves no room beside it for any other, " * 2, "icons"),
        ("Law", "both"),
    ):
        names[0] = name.strip()
        row.locator("span").first.evaluate("(span, name) => { span.firstChild.data = name; }", name)
        becomes(level)
    names.append("One more tab, whose name leaves no room beside it for any other name")
    page.evaluate(FILL, names)
    becomes("icons")
    names.pop()
    row.evaluate("row => { row.lastElementChild.remove(); }")
    becomes("both")
