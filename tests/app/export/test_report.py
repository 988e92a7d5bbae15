"""The lab report: everything that was done is in it, nothing in it runs, and it fits on paper."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.export.plot_pictures import inline_svg
from app.export.report_html import LOCKED, ReportEntry, report_html
from app.i18n.speaking import set_language
from app.settings import Settings
from tests.app.export.runs import piece
from tests.browser import PageAt, screenshot
from tests.scenes.helpers import given_settings

NASTY = "<script>alert(1)</script><img src=x onerror=alert(2)>\"'&"
SVG = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1"><path d="M0 0h1"/></svg>'


class Reader(HTMLParser):
    """Collects tags, attributes and text."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[str] = []
        self.text = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [name for name, _ in attrs]

    def handle_data(self, data: str) -> None:
        self.text += data


def full(text: str) -> str:
    """A report in which a text stands everywhere."""
    entry = ReportEntry(text, text, text, False, text, (text,), ((text, True), (text, False)), 2, False, text, text, text, SVG)
    return report_html(text, [entry, ReportEntry(text)], Settings(), about=text)


@given(st.text(min_size=1, max_size=60).filter(str.strip))
def test_no_text_becomes_a_tag(text: str) -> None:
    allowed = set(Reader(full("a")).tags)
    assert set(Reader(full(text)).tags) <= allowed
    assert len(Reader(full(text)).tags) == len(Reader(full("a")).tags)


def test_a_nasty_text_is_shown_as_it_was_written() -> None:
    read = Reader(full(NASTY))
    assert "script" not in read.tags and "img" not in read.tags and not any(name.startswith("on") for name in read.attributes)
    assert read.text.count(NASTY) == 14
    assert LOCKED in full(NASTY)


def test_everything_that_was_done_is_in_it() -> None:
    judgements = (("d ≥ 150 mm", True),)
    entry = ReportEntry(
        "1.2 Rest",
        "How near?",
        "Nearer than d_m",
        True,
        "Right.",
        ("d = 167.2 mm",),
        judgements,
        3,
        True,
        "I thought so.",
        plot=SVG,
    )
    page = report_html("My report", [entry], Settings(run=given_settings(dm=0.2)))
    text = Reader(page).text
    for part in (
        entry.title,
        entry.question,
        entry.prediction,
        "✓ right",
        entry.verdict,
        *entry.outcome,
        "✓ d ≥ 150 mm",
        "attempts: 3",
    ):
        assert part in text
    for part in ("✓ passed", entry.words, "200 mm", "Hold (Fig. 5)", "Made by Duet"):
        assert part in text


def test_what_is_empty_is_left_out() -> None:
    entry = report_html("r", [ReportEntry("only a title")], None)
    assert "<dt>" not in entry and "<table" not in entry and "<figure" not in entry


def test_settings_that_have_no_effect_are_left_out() -> None:
    text = report_html("r", [], Settings(run=given_settings(law="potential_field")))
    assert "<td>η</td>" in text and "<td>d<sub>m</sub></td>" not in text
    assert "<td>d<sub>m</sub></td><td>150 mm</td>" in report_html("r", [], Settings())


def test_formulas_of_the_lesson_may_be_drawn_but_never_those_of_a_student() -> None:
    entry = ReportEntry("t $x$", question="why $x$", words="me $x$")
    page = report_html("r $x$", [entry], None, rich=lambda text: text.replace("$x$", SVG))
    assert page.count(SVG) == 1 and "me $x$" in page


def test_other_languages() -> None:
    set_language("de")
    try:
        page = report_html("Bericht", [], Settings())
    finally:
        set_language("en")
    assert '<html lang="de">' in page and "<h2>Einstellungen des letzten Laufs</h2>" in page


@pytest.mark.parametrize(
    "svg",
    [
        "no picture",
        "<p>x</p>",
        '<svg xmlns="http://www.w3.org/2000/svg"><script>1</script></svg>',
        '<svg xmlns="http://www.w3.org/2000/svg" onload="1"/>',
        '<svg xmlns="http://www.w3.org/2000/svg"><foreignObject/></svg>',
        f"{SVG}<b>x</b>",
    ],
)
def test_only_plain_pictures_are_put_in(svg: str) -> None:
    with pytest.raises(ValueError, match="a plot is no"):
        report_html("r", [ReportEntry("1", plot=svg)], None)


def test_it_prints_on_paper(page_at: PageAt, tmp_path: Path) -> None:
    recorded, _ = piece("hold", 3.0)
    plots = [inline_svg(recorded, 3.0, "lambda", "p1"), inline_svg(recorded, 3.0, "speeds", "p2"), *[""] * 4]
    entries = [
        ReportEntry(f"Step {i}", "How near?", "Nearer", i % 2 == 0, "So.", ("d = 167.2 mm",), words="word " * 40, plot=plots[i])
        for i in range(6)
    ]
    path = tmp_path / "report.html"
    path.write_text(report_html("Lab report", entries, Settings(), about=NASTY), encoding="utf-8")
    page = page_at(820, 1000)
    page.goto(path.as_uri())
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.locator("figure svg").count() == 2 and page.locator("article").count() == 6
    screenshot(page, "report")
    printed = page.pdf(prefer_css_page_size=True)
    assert 2 <= len(re.findall(rb"/Type /Page\b", printed)) <= 7
