"""The contact card in a real browser: it shows the run's values, and no label overlaps another."""

import re
from functools import cache
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page

from app.i18n.speaking import set_language
from app.page import STATIC
from app.page.panels.contact_card import (
    contact_note,
    contact_numbers,
    contact_words,
    part_text,
    solo_note,
    solo_numbers,
    solo_words,
)
from app.page.panels.distance_rate import budget_terms, trend
from app.session.clock import Pace
from app.session.frame import Frame
from app.session.session import Session
from app.settings import Language
from app.text.formula import formula
from app.web.pages import PageAssets
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import LATE_UPDATE, visit
from tests.app.page.shared_page import Shared, SharedPage
from tests.app.page.test_readout import played, settings
from tests.browser import PageAt, lasting, screenshot, until
from tests.fonts import FONTS, Font

# The page is rebuilt in another language.
SHARED = SharedPage(1000, 700, "speed=2", expect=(LATE_UPDATE,))
PAUSED = Pace(True, 1.0, False)

NUMBERS = """() => [...document.querySelectorAll('.duet-eq')].map((one) => [...one.querySelectorAll('.live')].map((number) => {
  const box = number.getBBox(), kind = number.classList[0], middle = box.x + box.width / 2;
  const symbols = [...one.querySelectorAll(`path.${kind}`)].map((path) => path.getBBox());
  const near = symbols.find((symbol) => middle > symbol.x - 0.4 * box.width && middle < symbol.x + symbol.width + 0.4 * box.width);
  return [number.textContent, !near ? 'elsewhere' : box.y < near.y ? 'over' : 'under'];
}))"""

TEXTS = """() => {
  const card = document.getElementById("duet-contact"), lines = 2.6 * parseFloat(getComputedStyle(card).fontSize) / 13;
  const box = (e) => {
    const range = document.createRange();
    range.selectNodeContents(e);
    const whole = e instanceof SVGElement || e.matches(".note");
    const { left, top, right, bottom } = (whole ? e : range).getBoundingClientRect();
    return { text: e.textContent, left, top, right, bottom };
  };
  const seen = (e) => e.textContent.trim() && e.getClientRects().length && getComputedStyle(e).visibility !== "hidden";
  const parts = card.querySelectorAll(".gap b,.gap span,.trend,svg text,.term>*,.note");
  const texts = [...parts].filter(seen).map(box), outer = card.getBoundingClientRect(), faults = [];
  for (const button of card.querySelectorAll(":scope > button")) {
    const { left, top, right, bottom, width } = button.getBoundingClientRect();
    if (width) texts.push({ text: button.className || "the button", left: left - 2 * !!button.matches(".tone"), top, right, bottom });
  }
  texts.forEach((a, i) => {
    if (a.left < outer.left || a.right > outer.right || a.top < outer.top - 0.5 || a.bottom > outer.bottom + 0.5)
      faults.push(`${a.text} leaves the card`);
    for (const b of texts.slice(i + 1))
      if (Math.min(a.right, b.right) - Math.max(a.left, b.left) > 0.5 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > lines)
        faults.push(`${a.text} over ${b.text}`);
  });
  // The block of what is kept clear of leaves its name's letters free, hooks and all.
  const block = card.querySelector("svg rect.body")?.getBBox(), ink = document.createElement("canvas").getContext("2d");
  for (const text of card.querySelectorAll("svg text")) {
    if (!block || !seen(text)) continue;
    ink.font = getComputedStyle(text).font;
    const { x, width } = text.getBBox(), top = text.getAttribute("y") - ink.measureText(text.textContent).actualBoundingBoxAscent;
    if (x < block.x + block.width && x + width > block.x && top < block.y + block.height && +text.getAttribute("y") > block.y)
      faults.push(`${text.textContent} over its block`);
  }
  const note = card.querySelector(".note");
  if (getComputedStyle(note).overflow !== "visible" && note.scrollHeight > note.clientHeight + 1) faults.push(`${note.textContent} is cut`);
  for (const term of card.querySelectorAll(".term:not([hidden])"))
    if (![...term.querySelectorAll("b:not(.value),small")].some(seen)) faults.push(`${term.textContent} has no name`);
  return faults;
}"""
"""Texts that overlap (lines may touch), leave the card or are cut, and numbers without a name."""

HIGHEST = """() => Math.max(...[...document.querySelectorAll("#duet-contact .e.stem")].map(
    (stem) => Math.abs(stem.getAttribute("y2") - stem.getAttribute("y1"))))"""
"""Height of the highest error bar [px]."""

Drawing = tuple[str, str, str]
"""Words, note and numbers as the page receives them."""


def drawing(
    query: str, language: Language, seconds: float = 1.0, changed: dict[str, float | None] | None = None
) -> Drawing:
    """Card data of an experiment as the page receives it. `changed`: new numbers by name."""
    set_language(language)
    simulation, whole = played(query, seconds), settings(query)
    sample = simulation.sample()
    frame = Frame(0.0, live := Session(whole), live, simulation, None, sample, whole, PAUSED)
    if sample.pair < 0:
        words, note, numbers = solo_words(whole.run), solo_note(whole.run), solo_numbers(sample)
        return part_text(words), part_text(note), part_text(numbers)
    terms = budget_terms(simulation, sample, frame.contact)
    note = contact_note(simulation, sample, frame.contact, terms)
    numbers = contact_numbers(frame, frame.contact, terms, 0)
    names = ("d", "law", "rest", "ghost", "lam", "u", "w", "allowed", "way", *(term.kind for term in terms))
    for name, number in (changed or {}).items():
        if name == "note":
            note = (
                "alarm",
                "d ≥ d<sub>m</sub> may fail: w &gt; v, the joints hardly move this point (s = 0.42), between two pairs",
            )
        else:
            numbers[names.index(name)] = None if number is None else round(number)
    return part_text(contact_words(frame, terms)), part_text(note), part_text(numbers)


@cache
def states(language: Language) -> list[Drawing]:
    def at(
        d: float, lam: float, rest: float | None = None, query: str = "scene=hold", **more: float | None
    ) -> Drawing:
        return drawing(query, language, changed={"d": d, "law": d, "lam": lam, "rest": rest, **more})

    made = [
        at(d, lam, rest)
        for d, lam, rest in ((340, 8, 190), (200, 178, 153), (166, 530, 164), (152, 923, 151))
    ]
    made += [
        at(163, 608, None, ghost=40),
        at(120, 1000, None, way=-1),
        at(-35, 1000, None),
        at(8, 1000, 250, ghost=-20),
    ]
    made += [
        at(900, 0, 359),
        at(35, 600, 38, "scene=hold&dm=0.03&n=2"),
        at(300, 990, 310, "scene=hold&dm=0.3&n=20"),
    ]
    made += [at(170, 480, 160, note=1.0, way=-1), at(170, 480, 160, "scene=hold&ff=1", way=1)]
    made += [
        at(170, 480, 160, query, lost=-123, way=-1) for query in ("scene=hold", "scene=imitation&avoid=both")
    ]
    made += [drawing(f"scene={scene}", language) for scene in ("ball", "master_slave", "imitation", "solo")]
    made += [
        drawing(f"scene=solo&path=circle&{k}", language)
        for k in ("k=0", "k=20&kx=10&dt=0.005", "k=20&kx=10&dt=0.02")
    ]
    made += [drawing("scene=master_slave&law=barrier_qp&dm=0.2&v=0.2", language)]
    made += [
        drawing(f"scene=hold&law={law}&dm=0.2&v=0.2", language, 4.0)
        for law in (
            "strict_priority",
            "strict_switched",
            "null_space_avoidance",
            "potential_field",
            "barrier_qp",
            "set_based_task",
        )
    ]
    return [
        *made,
        drawing("scene=hold&law=unprotected&v=0.1&dm=0.16", language, 4.5),
        at(-20, 0, None, "scene=hold&law=unprotected"),
    ]


def draw(page: Page, one: Drawing) -> None:
    """Draw a state in place of the paused run's, which the server may resend at any time."""
    page.wait_for_function(
        """texts => { ["words", "note", "now"].forEach((name, i) => {
          for (const e of document.querySelectorAll(`.duet-contact-${name}`)) e.dataset.text = texts[i]; });
          return document.getElementById("duet-contact").dataset.drawn === texts[2]; }""",
        arg=one,
    )


POINTS = """() => {
  const card = document.getElementById("duet-contact"), at = (selector, name) => +card.querySelector(selector).getAttribute(name);
  return { bead: at(".body:not(rect)", "cx"), tip: at(".tip", "cy"), axis: at(".axis", "y1"), left: at(".axis", "x1"),
    right: at(".axis", "x2"), curve: card.querySelector(".curve").getAttribute("points"), top: at(".limit", "y1") + 6,
    number: card.querySelector(".gap b").textContent, label: card.querySelector("#duet-contact-picture").getAttribute("aria-label"),
    net: card.querySelector(".sum").getAttribute("d"), values: [...card.querySelectorAll(".value")].map((e) => e.textContent) }; }"""


CURVES = """() => Object.fromEntries(Object.values(__viserTestpoints.uplots).flatMap(({ chart }) =>
    chart.series.slice(1, 4).map(({ label, alpha }) => [label, alpha ?? 1])))"""
"""Opacity of the first curves of every plot, by name."""


@pytest.fixture
def near(shared: Shared) -> Shared:
    """The shared page, paused with the arms so close that λ is visibly above 0."""
    page, session = shared.page, shared.session
    ask(session, lambda s: s.control.hurry(4.0))
    until(page, lambda: session.simulation.sample().activation > 0.3, "λ")
    ask(session, lambda s: s.control.halt.set("visitor"))
    page.get_by_text("paused", exact=True).first.wait_for()
    return shared


@pytest.fixture
def drawable(shared: Shared) -> Shared:
    """The shared page, paused and in Slovene: its words are sent again after a test has drawn others."""
    page, session = shared.page, shared.session
    ask(session, lambda s: [s.control.halt.set("visitor"), s.change("lang", "sl")])
    page.get_by_text("razdalja d_m [mm]").first.wait_for()
    return shared


def budget_values(session: Session) -> list[float]:
    """Values of the last step's terms as on the card [m/s]: u and w are subtracted."""

    def read(s: Session) -> list[float]:
        sample = s.simulation.sample()
        frame = Frame(0.0, s, s, s.simulation, None, sample, s.settings, PAUSED)
        terms = budget_terms(s.simulation, sample, frame.contact)
        return [-term.value if term.kind in ("u", "w") else term.value for term in terms]

    return ask(session, read)


def test_the_card_shows_the_last_step_of_the_run(near: Shared) -> None:
    page = near.page
    sample, values = ask(near.session, lambda s: s.simulation.sample()), budget_values(near.session)
    page.wait_for_function(
        "d => document.querySelector('#duet-contact .gap b').textContent === d",
        arg=f"{1e3 * sample.distance:.0f}",
    )
    seen: dict[str, Any] = {}

    def of_the_last_step() -> bool:
        seen.update(page.evaluate(POINTS))
        shown = [float(text.replace("−", "-")) for text in seen["values"]]
        # Sent in thousandths, shown in hundredths: rounded twice.
        said = abs(float(seen["label"].split("λ ")[1][:4]) - sample.activation) < 0.0056
        return said and len(shown) == len(values) and np.allclose(shown, values, atol=0.0056)

    until(page, of_the_last_step, "λ and the budget of the last step")
    span = 360.0
    place = seen["left"] + (seen["right"] - seen["left"]) * 1e3 * sample.distance / span
    assert sample.distance - sample.law_distance > 1e-3, "the law's distance must differ from the shown one"
    assert abs(seen["bead"] - place) < 0.6
    assert abs(seen["axis"] - seen["tip"] - (seen["axis"] - seen["top"]) * sample.activation) < 0.3
    xs, ys = np.array([point.split(",") for point in seen["curve"].split()], float).T
    assert abs(np.interp(seen["bead"], xs, ys) - seen["tip"]) < 1.5, "the bead is not on the curve"
    assert "orange arm" in page.locator("#duet-contact").inner_text()
    assert re.search(r"^\d+ mm apart, the gap (opens|holds|closes); λ 0\.\d\d\. ", seen["label"])


def test_the_equation_has_the_same_number_as_the_card(near: Shared) -> None:
    page = near.page
    number = page.locator(".duet-eq .live.lam").first
    number.wait_for()
    card = page.locator("#duet-contact .large.lam")
    # The equation is drawn a few times a second, the card in every frame.
    until(
        page,
        lambda: number.text_content() == (card.text_content() or " ").split()[-1],
        "the number of the card in the equation, too",
    )


LIT = "parts => parts.map((part) => document.querySelector(part).classList.contains('duet-lit'))"
PARTS = ("#duet-contact .curve", "#duet-contact [data-symbol=v].bar", ".duet-caption .d")
"""One place each of λ, v and d."""


def test_a_symbol_and_its_curve_are_highlighted_everywhere(near: Shared) -> None:
    page = near.page

    def lights(place: str, *expected: bool) -> None:
        def lit_up() -> bool:
            page.locator(place).first.hover(force=True)
            return page.evaluate(LIT, PARTS) == list(expected)

        until(page, lit_up, f"{place} lights up")

    lights(".duet-eq .hit[data-symbol=lam]", True, False, False)
    lights("#duet-contact .term[data-symbol=v]", False, True, False)
    assert page.locator(".duet-eq .hit[data-symbol=v].duet-lit").count() == 1
    lights("#duet-contact circle.body", False, False, True)
    # The curve of d is highlighted in its plot; the other plot does not change.

    def d_stands_out() -> bool:
        curves = page.evaluate(CURVES)
        return curves["d"] == 1.0 and curves["d_m"] < 0.5 and curves["e2"] == 1.0

    until(page, d_stands_out, "the curve of d")
    page.locator(".duet-eq .hit[data-symbol=lam]").first.focus()
    until(page, lambda: page.evaluate(LIT, PARTS) == [True, False, False], "the focus")
    page.mouse.move(500, 600)
    until(page, lambda: page.locator(".duet-lit").count() == 0, "darkness")
    until(page, lambda: set(page.evaluate(CURVES).values()) == {1.0}, "all curves as before")


POINT = re.compile(r"\d\.\d")


def test_a_paused_page_has_the_decimal_sign_of_its_language(near: Shared) -> None:
    page = near.page
    parts = ("#duet-contact-picture", ".duet-eq", ".duet-status >> nth=0")
    picture, lam = page.locator("#duet-contact-picture"), page.locator("#duet-contact text.lam")

    def with_points() -> list[str]:
        return [part for part in parts if POINT.search(page.locator(part).first.text_content() or "")]

    for language, word in (("de", "Abstand"), ("sl", "razdalja")):
        ask(near.session, lambda s, language=language: s.change("lang", language))
        page.get_by_text(f"{word} d_m [mm]").first.wait_for()
        until(page, lambda: re.search(r"λ \d,\d\d", picture.get_attribute("aria-label") or ""), "a comma")
        until(page, lambda: "," in (lam.text_content() or ""), "a comma in the drawing")
        page.locator(".duet-eq .live.lam").first.wait_for()
        assert lasting(page, with_points) == []


def test_sent_card_data_has_the_decimal_sign_of_its_language() -> None:
    languages: tuple[Language, ...] = ("de", "sl")
    for language in languages:
        for query in ("scene=solo&path=circle&k=1", "scene=ball&dead=0.05"):
            assert not POINT.search(drawing(query, language)[1]), query
        assert '"point":","' in drawing("scene=solo", language)[0]
    assert '"point":"."' in drawing("scene=hold", "en")[0]


def see_drawn(page: Page, one: Drawing, question: str, answer: object) -> None:
    """Draw a state until `question` gives `answer`; redraw it if the server has sent the run's own."""

    def is_so() -> bool:
        draw(page, one)
        return page.evaluate(question) == answer

    until(page, is_so, f"{answer} of {question}")


def test_an_overlap_in_the_equation_has_a_true_minus_sign(drawable: Shared) -> None:
    overlap = drawing("scene=hold", "sl", changed={"d": -33.0})
    see_drawn(drawable.page, overlap, "duet.symbols.d", "−33 mm")


def test_an_error_shown_as_zero_has_no_bars(drawable: Shared) -> None:
    words, note, _ = drawing("scene=solo&path=circle", "sl")
    number = "document.querySelector('#duet-contact .gap b').innerText"
    for micrometres, said, high in (("40", "0,0", False), ("60", "0,1", True), ("0", "0,0", False)):
        question = f"[{number}, ({HIGHEST})() {'> 20' if high else '=== 0'}]"
        see_drawn(drawable.page, (words, note, micrometres), question, [said, True])


def test_a_folded_card_stays_folded_in_this_browser(shared: Shared) -> None:
    page = shared.page
    page.get_by_role("button", name="Fold this drawing").click()
    page.reload()
    unfold = page.get_by_role("button", name="Show the drawing")
    unfold.wait_for()
    page.locator("#duet-contact .gap").wait_for()
    assert not page.locator("#duet-contact .chart").is_visible()
    unfold.click()
    page.locator("#duet-contact .chart").wait_for()


@pytest.mark.thorough
@pytest.mark.parametrize("font", FONTS)
def test_no_label_overlaps_another(font: Font, house: OpenHouse, page_at: PageAt) -> None:
    """In any state of a run, with wide and with narrow letters."""
    page = page_at(1000, 700, font=font)
    session = visit(page, house())
    ask(session, lambda s: s.control.halt.set("visitor"))
    page.get_by_text("paused", exact=True).first.wait_for()
    faults: list[str] = []
    layouts: tuple[tuple[int, str, tuple[Language, ...]], ...] = (
        (900, "desk", ("en", "de", "sl")),
        (900, "projector", ("en",)),
        (390, "desk", ("de", "sl")),
    )
    for width, profile, languages in layouts:
        page.set_viewport_size({"width": width, "height": 700})
        ask(session, lambda s, profile=profile: s.change("profile", profile))
        k = "1.3" if profile == "projector" else "1"
        page.wait_for_function(
            "k => getComputedStyle(document.documentElement).getPropertyValue('--duet-k') === k", arg=k
        )
        for language in languages:
            for number, one in enumerate(states(language)):

                def overlaps(one: Drawing = one) -> list[str]:
                    draw(page, one)
                    return page.evaluate(TEXTS)

                found = lasting(page, overlaps)
                faults += [f"{width} {profile} {language} {number}: {fault}" for fault in found]
                if found:
                    screenshot(page, f"contact-{font}-{width}-{profile}-{language}-{number}")
    assert not faults, "\n".join(faults)


def test_numbers_in_formulas_are_next_to_their_own_symbols(page_at: PageAt) -> None:
    page = page_at(600, 400)
    values = {"v": "0.30", "u": "0.00", "d": "235 mm", "lam": "0.50"}
    files = tuple(STATIC / f"{name}.js" for name in ("label_placement", "live_equations"))
    script = PageAssets(files, constants={"symbols": values}).script_html()
    drawn = {
        # Next to ‖J_d‖, a number of the numerator would seem to belong to it.
        r"\|\Delta\dot q\| = \frac{v + u}{\|J_d\|}": [("0.30", "over"), ("0.00", "over")],
        # A second number would be next to d₀.
        r"\frac{\eta}{d^2}\left(\frac{1}{d} - \frac{1}{d_0}\right)": [("235 mm", "under")],
        r"\frac{1}{\frac{v}{2}}": [],
        r"(1 - \lambda)u + \lambda v": [("0.50", "under"), ("0.00", "over"), ("0.30", "under")],
    }
    formulas = "".join(f'<div class="duet-eq">{formula(tex, False)}</div>' for tex in drawn)
    page.set_content(f"{script}{formulas}")
    page.locator(".live", has_text="0.50").first.wait_for()
    found = [sorted(tuple(number) for number in numbers) for numbers in page.evaluate(NUMBERS)]
    assert found == [sorted(numbers) for numbers in drawn.values()]


def test_the_word_for_the_gap_does_not_flicker() -> None:
    rates = [0.0, 0.009, 0.006, 0.004, 0.009, 0.002, 0.006, -0.006, -0.009, -0.004, -0.002]
    ways = [0]
    for rate in rates:
        ways.append(trend(rate, ways[-1]))
    assert ways[1:] == [0, 1, 1, 1, 1, 0, 0, 0, -1, -1, 0]


LABELS = r"""(() => {
  const seen = window.duetLabels = { labels: [], late: [] }, Native = window.Worker;
  window.Worker = class extends Native {
    constructor(...given) {
      super(...given);
      this.addEventListener("message", ({ data }) => {
        for (const { name, updates } of data?.messages ?? []) if (name === "/closest/distance" && updates?.text) {
          const place = seen.labels.push(updates.text.match(/\d+/)[0]) - 1;
          // Two pictures later.
          requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(() => {
            const card = document.querySelector("#duet-contact .gap b").textContent;
            if (card && !seen.labels.slice(place).includes(card)) seen.late.push([seen.labels[place], card]);
          })));
        }
      });
    }
  };
})()"""
"""Records the 3-D label's numbers, and the cases where the card shows an older one two pictures later."""


def test_the_card_shows_the_same_distance_as_the_label(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1000, 700)
    page.add_init_script(LABELS)
    visit(page, house(), "speed=2")
    until(page, lambda: len(set(page.evaluate("duetLabels.labels"))) > 60, "a distance that changes")
    labels, late = page.evaluate("[duetLabels.labels.length, duetLabels.late]")
    # The card is empty at first, and its first numbers may be from another moment.
    assert len(late) <= 2, (labels, late)
