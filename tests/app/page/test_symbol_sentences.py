"""Every symbol of the page has one sentence, in every language, shown by pointer, finger and key."""

import re

import pytest
from playwright.sync_api import Locator, Page

from app.i18n.catalogue import words_of
from app.i18n.speaking import set_language
from app.page.panels.contact_card import contact_words, symbol_sentences
from app.page.panels.distance_rate import budget_terms
from app.plots.time_plots import TIME_PLOTS, time_plot_of
from app.session.clock import Pace
from app.session.frame import Frame
from app.session.session import Session
from app.settings import LANGUAGES, Language
from app.text.formula import formula
from app.theme import SYMBOLS
from scenes.laws import LAWS
from tests.accessibility import accessible
from tests.app.conftest import OpenHouse
from tests.app.page.by_hand import visit
from tests.app.page.test_readout import played, settings
from tests.browser import PageAt, until
from tests.test_imports import ROOT

LONGEST = 20
"""Longest sentence [words]."""

COVERED = """([tooltip, symbol]) => {
  const box = tooltip.getBoundingClientRect();
  return [...document.querySelectorAll("[data-symbol], .duet-caption b, button, input")].filter((other) => {
    const { left, top, right, bottom, width } = other.getBoundingClientRect();
    const apart = right <= box.left || left >= box.right || bottom <= box.top || top >= box.bottom;
    return width && other.checkVisibility() && !apart;
  }).map((other) => other.outerHTML.slice(0, 80));
}"""
"""Symbols and controls under a tooltip."""


def frame_of(query: str) -> Frame:
    chosen = settings(query or "scene=hold")
    session, simulation = Session(chosen), played(query or "scene=hold")
    sample = simulation.sample()
    return Frame(0.0, session, session, simulation, None, sample, chosen, Pace(True, 1.0, False))


def test_every_drawn_symbol_has_a_sentence() -> None:
    sources = [path.read_text(encoding="utf-8") for path in (ROOT / "app").rglob("static/*.js")]
    drawn = {name for source in sources for name in re.findall(r'"data-symbol": "(\w+)"', source)}
    lists = [
        re.findall(r'"(\w+)"', found)
        for source in sources
        for found in re.findall(r"const SYMBOLS = \[(.*?)\]", source)
    ]
    assert len(lists) == 2, "not two lists: highlighted symbols, and symbols of formulas"
    drawn |= {name for names in lists for name in names}
    lines = [line for plot in TIME_PLOTS.values() for line in plot.lines]
    lines += [
        line for name in ("distance", "error") for line in time_plot_of(name, played("scene=hold")).lines
    ]
    drawn |= {line.colour for line in lines if not re.fullmatch(r"j\d", line.colour)}
    drawn |= set(re.findall(r'class="(\w+)"', formula(r"\lambda d d_m u v w", False)))
    assert {"lam", "d", "dm", "rest", "e", "u", "v", "w"} <= drawn <= set(SYMBOLS)


@pytest.mark.parametrize("law", sorted(LAWS))
def test_every_term_and_every_entry_of_the_cards_legend_has_a_sentence(law: str) -> None:
    set_language("en")
    frame = frame_of(f"law={law}")
    terms = budget_terms(frame.simulation, frame.sample, frame.contact)
    words = contact_words(frame, terms)
    legend = words["legend"]
    assert isinstance(legend, list)
    kinds = {term.kind for term in terms} | {kind for kind, _ in legend}
    assert kinds <= set(symbol_sentences(frame))


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("query", ["", "avoid=guided", "avoid=both", "scene=ball", "scene=solo"])
def test_a_sentence_is_short_and_names_the_avoiding_arm(language: Language, query: str) -> None:
    set_language(language)
    sentences = symbol_sentences(frame_of(query))
    set_language("en")
    assert set(sentences) == set(SYMBOLS)
    for name, sentence in sentences.items():
        assert len(sentence.split()) <= LONGEST, sentence
        assert "{" not in sentence, sentence
        if language != "en":
            assert words_of(language)(SYMBOLS[name].sentence) != SYMBOLS[name].sentence
    silver = words_of(language)("the silver arm")
    assert (silver in sentences["lam"]) == (query == "")
    assert (silver in sentences["w"]) == (query == "avoid=guided")


def said(page: Page) -> list[str]:
    return page.locator("[role=tooltip]:not([hidden])").all_text_contents()


def says(page: Page, symbol: Locator, beginning: str) -> None:
    """Check that a symbol's sentence is shown next to it and covers no other symbol or control."""
    until(
        page,
        lambda: [text[: len(beginning)] for text in said(page)] == [beginning],
        f"the sentence of {beginning}",
    )
    tooltip = page.locator("[role=tooltip]:not([hidden])")
    element = symbol.element_handle()
    assert element is not None
    assert page.evaluate(COVERED, [tooltip.element_handle(), element]) == []


def test_pointer_finger_and_focus_show_the_sentence(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1280, 800)
    visit(page, house(), "lang=en")
    lam = page.locator(".duet-eq .hit[data-symbol=lam]").first
    violet = page.locator("#duet-contact .legend [data-symbol=lam]")
    d_m = page.locator(".duet-caption span.dm[aria-describedby]").first
    for place in (lam, violet, d_m, page.locator("#duet-contact .term[data-symbol=v]")):
        place.wait_for()

    # By pointer, which may move on to the sentence; Escape closes it.
    for symbol, beginning in (
        (lam, "λ: how much the silver arm gives way."),
        (violet, "λ: how much the silver arm gives way."),
        (d_m, "d_m: the distance to keep."),
        (page.locator("#duet-contact .term[data-symbol=v]"), "v: how fast the silver arm retreats"),
        (page.locator("#duet-contact .gap"), "d: the shortest distance"),
    ):
        until(page, lambda symbol=symbol: symbol.hover(force=True) or said(page), "a sentence")
        says(page, symbol, beginning)
        tooltip = page.locator("[role=tooltip]:not([hidden])")
        tooltip.hover()
        assert said(page), "the sentence closed under the pointer"
        page.keyboard.press("Escape")
        until(page, lambda: said(page) == [], "Escape takes it away")
        page.mouse.move(640, 420)

    # By keys, on symbols that Tab can focus.
    for symbol, beginning in ((lam, "λ:"), (violet, "λ:"), (d_m, "d_m:")):
        assert symbol.evaluate("(one) => one.tabIndex") == 0
        symbol.focus()
        says(page, symbol, beginning)
        described = symbol.get_attribute("aria-describedby")
        assert page.locator(f"#{described}").text_content() == said(page)[0]
        page.keyboard.press("Escape")
        until(page, lambda: said(page) == [], "Escape takes it away")
        assert symbol.evaluate("(one) => one === document.activeElement"), "the focus is lost"
        symbol.blur()
    violet.focus()
    says(page, violet, "λ:")
    accessible(page)


def test_a_tap_shows_the_sentence_on_a_phone(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(390, 844, has_touch=True)
    visit(page, house(), "lang=de&autopilot=0")
    violet = page.locator("#duet-contact .legend [data-symbol=lam]")
    violet.wait_for()
    until(page, lambda: violet.get_attribute("aria-describedby"), "its sentence")
    violet.tap()
    says(page, violet, "λ: wie sehr der silberne Arm nachgibt.")
    page.locator("#duet-contact .term[data-symbol=w]").tap()
    says(
        page, page.locator("#duet-contact .term[data-symbol=w]"), "w: wie schnell der orange Arm näher kommt."
    )
