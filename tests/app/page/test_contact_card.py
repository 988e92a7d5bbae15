"""The card of the line of contact in a real browser: what it shows is what the run does, and no label lies over another."""

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
from tests.app.page.by_hand import visit
from tests.app.page.test_readout import played, settings
from tests.browser import PageAt, lasting, screenshot, until
from tests.fonts import FONTS, Font

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
"""Which texts lie over each other (lines may touch), leave the card or are cut, and which numbers have no name."""

HIGHEST = """() => Math.max(...[...document.querySelectorAll("#duet-contact .e.stem")].map(
    (stem) => Math.abs(stem.getAttribute("y2") - stem.getAttribute("y1"))))"""
"""How high the bars of an error are [px]."""

Drawing = tuple[str, str, str]
"""Words, note and numbers as the page gets them."""


def drawing(
    query: str, language: Language, seconds: float = 1.0, changed: dict[str, float | None] | None = None
) -> Drawing:
    """What the page gets of an experiment, its numbers changed by name."""
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
    """Show a state in place of the waiting run's, and return when it is drawn; the server may just have sent the run's own again."""
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
"""How opaque the first curves of every plot are, by name."""


def test_what_it_shows_is_the_runs_and_a_symbol_lights_up_everywhere(
    house: OpenHouse, page_at: PageAt
) -> None:
    page = page_at(1000, 700)
    session = visit(page, house(), "speed=2")
    # Near enough that λ has a height to look at.
    until(page, lambda: session.simulation.sample().activation > 0.3, "λ")
    ask(session, lambda s: s.control.halt.set("visitor"))
    page.get_by_text("paused", exact=True).first.wait_for()
    sample = ask(session, lambda s: s.simulation.sample())
    terms = ask(
        session,
        lambda s: budget_terms(
            s.simulation, sample, Frame(0.0, s, s, s.simulation, None, sample, s.settings, PAUSED).contact
        ),
    )
    values = [-t.value if t.kind in ("u", "w") else t.value for t in terms]
    page.wait_for_function(
        "d => document.querySelector('#duet-contact .gap b').textContent === d",
        arg=f"{1e3 * sample.distance:.0f}",
    )
    seen: dict[str, Any] = {}

    def of_the_last_step() -> bool:
        seen.update(page.evaluate(POINTS))
        shown = [float(text.replace("−", "-")) for text in seen["values"]]
        # Sent in thousandths, said in hundredths: rounded twice.
        said = abs(float(seen["label"].split("λ ")[1][:4]) - sample.activation) < 0.0056
        return said and len(shown) == len(values) and np.allclose(shown, values, atol=0.0056)

    until(page, of_the_last_step, "λ and the budget of the last step")
    span = 360.0
    place = seen["left"] + (seen["right"] - seen["left"]) * 1e3 * sample.distance / span
    assert sample.distance - sample.law_distance > 1e-3, "the law sees another distance than the card shows"
    assert abs(seen["bead"] - place) < 0.6
    assert abs(seen["axis"] - seen["tip"] - (seen["axis"] - seen["top"]) * sample.activation) < 0.3
    xs, ys = np.array([point.split(",") for point in seen["curve"].split()], float).T
    assert abs(np.interp(seen["bead"], xs, ys) - seen["tip"]) < 1.5, "the bead stands on the curve"
    assert "orange arm" in page.locator("#duet-contact").inner_text()
    assert re.search(r"^\d+ mm apart, the gap (opens|holds|closes); λ 0\.\d\d\. ", seen["label"])

    # A symbol lights up everywhere.
    number = page.locator(".duet-eq .live.lam").first
    number.wait_for()
    lam = page.locator("#duet-contact .large.lam").text_content() or ""
    # Words and numbers are drawn a few times a second, the card with every frame.
    until(page, lambda: number.text_content() == lam.split()[-1], f"{lam} in the equation, too")
    parts = ("#duet-contact .curve", "#duet-contact [data-symbol=v].bar", ".duet-caption .d")
    lit = "parts => parts.map((part) => document.querySelector(part).classList.contains('duet-lit'))"

    def lights(place: str, *expected: bool) -> None:
        def lit_up() -> bool:
            page.locator(place).first.hover(force=True)
            return page.evaluate(lit, parts) == list(expected)

        until(page, lit_up, f"{place} lights up")

    lights(".duet-eq .hit[data-symbol=lam]", True, False, False)
    lights("#duet-contact .term[data-symbol=v]", False, True, False)
    assert page.locator(".duet-eq .hit[data-symbol=v].duet-lit").count() == 1
    lights("#duet-contact circle.body", False, False, True)
    # The curve of d stands out from its plot, and the other plot stays as it is.

    def d_stands_out() -> bool:
        curves = page.evaluate(CURVES)
        return curves["d"] == 1.0 and curves["d_m"] < 0.5 and curves["e2"] == 1.0

    until(page, d_stands_out, "the curve of d")
    page.locator(".duet-eq .hit[data-symbol=lam]").first.focus()
    until(page, lambda: page.evaluate(lit, parts) == [True, False, False], "the focus")
    page.mouse.move(500, 600)
    until(page, lambda: page.locator(".duet-lit").count() == 0, "darkness")
    until(page, lambda: set(page.evaluate(CURVES).values()) == {1.0}, "all curves as before")

    see_decimal_signs(page, session)
    ask(session, lambda s: s.change("lang", "en"))

    # Folded it stays so in this browser.
    page.get_by_role("button", name="Fold this drawing").click()
    page.reload()
    page.get_by_role("button", name="Show the drawing").wait_for()
    page.locator("#duet-contact .gap").wait_for()
    assert not page.locator("#duet-contact .chart").is_visible()


@pytest.mark.thorough
@pytest.mark.parametrize("font", FONTS)
def test_no_label_lies_over_another(font: Font, house: OpenHouse, page_at: PageAt) -> None:
    """In no state of a run, with wide and with narrow letters."""
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


def see_decimal_signs(page: Page, session: Session) -> None:
    """A number has the decimal sign of the language, also on a page that stands still."""
    point, parts = re.compile(r"\d\.\d"), ("#duet-contact-picture", ".duet-eq", ".duet-status >> nth=0")
    languages: dict[Language, str] = {"de": "Abstand", "sl": "razdalja"}
    for language, word in languages.items():
        ask(session, lambda s, language=language: s.change("lang", language))
        page.get_by_text(f"{word} d_m [mm]").first.wait_for()
        until(
            page,
            lambda: re.search(
                r"λ \d,\d\d", page.locator("#duet-contact-picture").get_attribute("aria-label") or ""
            ),
            "a comma",
        )
        until(
            page,
            lambda: "," in (page.locator("#duet-contact text.lam").text_content() or ""),
            "a comma in the drawing",
        )
        page.locator(".duet-eq .live.lam").first.wait_for()
        assert (
            lasting(
                page, lambda: [p for p in parts if point.search(page.locator(p).first.text_content() or "")]
            )
            == []
        )
        for query in ("scene=solo&path=circle&k=1", "scene=ball&dead=0.05"):
            assert not point.search(drawing(query, language)[1]), query
        assert (
            '"point":","' in drawing("scene=solo", language)[0]
            and '"point":"."' in drawing("scene=hold", "en")[0]
        )
    # In the equation d has the sign of minus.
    draw(page, drawing("scene=hold", "sl", changed={"d": -33.0}))
    assert page.evaluate("duet.symbols.d") == "−33 mm"
    # An error that is said to be 0,0 mm has no bars.
    words, note, _ = drawing("scene=solo&path=circle", "sl")
    for micrometres, number, high in (("40", "0,0", False), ("60", "0,1", True), ("0", "0,0", False)):
        draw(page, (words, note, micrometres))
        assert page.locator("#duet-contact .gap b").inner_text() == number
        assert page.evaluate(HIGHEST) > 20.0 if high else page.evaluate(HIGHEST) == 0.0


def test_numbers_of_formulas_stand_by_their_own_symbols(page_at: PageAt) -> None:
    page = page_at(600, 400)
    values = {"v": "0.30", "u": "0.00", "d": "235 mm", "lam": "0.50"}
    files = tuple(STATIC / f"{name}.js" for name in ("label_placement", "live_equations"))
    script = PageAssets(files, constants={"symbols": values}).script_html()
    drawn = {
        # Beside ‖J_d‖ a number of the numerator would be that one's.
        r"\|\Delta\dot q\| = \frac{v + u}{\|J_d\|}": [("0.30", "over"), ("0.00", "over")],
        # The second one would stand by d₀.
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
"""Note every number of the label in the scene, and where the card says an older one two pictures after."""


def test_the_card_says_the_same_distance_as_the_label(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1000, 700)
    page.add_init_script(LABELS)
    visit(page, house(), "speed=2")
    until(page, lambda: len(set(page.evaluate("duetLabels.labels"))) > 60, "a distance that changes")
    labels, late = page.evaluate("[duetLabels.labels.length, duetLabels.late]")
    # Until the card is there it says nothing, and the numbers that it begins with may be of another moment.
    assert len(late) <= 2, (labels, late)
