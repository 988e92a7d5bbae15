"""Data of the contact card, which `contact_card.js` draws."""

import json
import math
from collections.abc import Callable
from functools import lru_cache
from typing import Final

import numpy as np
import viser

from app.i18n.speaking import N_, decimal, tr
from app.page.panels.distance_rate import (
    BOLTED,
    Term,
    allowed_rate,
    budget_terms,
    consequence,
    error_step,
    least_lever,
    missed,
    nearest_is_bolted,
    promise_words,
    trend,
)
from app.plots.time_series import resting_now
from app.session.frame import Contact, Frame
from app.text.first_task_texts import FIRST_TASK_TEXTS, in_symbols, wording
from app.text.law_texts import LAW_TEXTS
from app.text.lever_texts import lever_text
from app.text.templates import element
from app.theme import SYMBOLS
from controllers.laws.situation import Law
from scenes.history import Sample
from scenes.law_answers import LawOfFile
from scenes.quantities import part_of_pair, quantity_of_pair
from scenes.settings import RunSettings
from scenes.simulation import Simulation

PERIOD: Final = 0.1
"""Time between two sets of numbers [s]; the page interpolates."""

WIDEST: Final = 0.36
"""Least length of the axis of d [m]."""

_json: Final = json.JSONEncoder(ensure_ascii=False, separators=(",", ":")).encode

CardNumbers = list[int | None]
CardWords = dict[str, object]
Note = tuple[str, str]


class ContactCard:
    """Sends the card's data, also to `tab`, because a folded panel is not on the page."""

    def __init__(self, gui: viser.GuiApi, tab: viser.GuiTabHandle) -> None:
        self._parts = {name: [gui.add_html("", order=-1.0)] for name in ("words", "note", "symbols", "now")}
        with tab:
            for handles in self._parts.values():
                handles.append(gui.add_html("", order=-1.0))
        self._sent: dict[str, object] = {}
        self._next = 0.0
        self._shown: tuple[object, ...] = ()
        self._trend = 0

    def show(self, frame: Frame, further: Callable[[], CardWords], asking: bool) -> None:
        """Send changes every `PERIOD`, or at once while the run is paused. `asking`: True hides the law's
        values."""
        if frame.now < self._next and not frame.pace.paused:
            return
        more = further()
        state = frame.state, more, asking
        if state == self._shown:
            return
        self._shown, self._next = state, frame.after(PERIOD)
        if frame.sample.pair < 0:
            words, note, numbers = (
                solo_words(frame.settings.run),
                solo_note(frame.settings.run),
                solo_numbers(frame.sample),
            )
        else:
            now = frame.contact
            terms = budget_terms(frame.simulation, frame.sample, now)
            # Of the shown d, which may change unlike the law distance.
            self._trend = trend(now.true_change, self._trend)
            words = {**contact_words(frame, terms), **more}
            note = contact_note(frame.simulation, frame.sample, now, terms)
            numbers = contact_numbers(frame, now, terms, self._trend)
        if asking:
            words, note, numbers = without_law(words, numbers)
        if frame.replayed:
            words["past"] = tr("a moment\x04then") if frame.of_live else tr("replay")
        parts: dict[str, object] = {
            "words": words,
            "note": note,
            "symbols": symbol_sentences(frame),
            "now": numbers,
        }
        changed = [name for name, part in parts.items() if part != self._sent.get(name)]
        self._sent = parts
        for name in changed:
            content = element("i", class_=f"duet-contact-{name}", data_text=part_text(parts[name]))
            for handle in self._parts[name]:
                handle.content = content


def part_text(part: object) -> str:
    """Words or note as JSON; numbers without keys."""
    return (
        ",".join("" if number is None else str(number) for number in part)
        if isinstance(part, list)
        else _json(part)
    )


def _legend() -> list[tuple[str, str]]:
    return [("lam", tr("violet: gives way")), ("dm", tr("bubble: distance to keep"))]


def _first_task_legend(wall: bool) -> list[tuple[str, str]]:
    return [_legend()[0], *([("dm", tr("violet plane: distance to keep"))] if wall else [])]


def contact_words(frame: Frame, terms: list[Term]) -> CardWords:
    """Text of the card and the curve λ(d) [mm, ‰]."""
    simulation, run = frame.simulation, frame.settings.run
    law, two = run.law, run.both_avoid
    yours, other = ("orange", tr("orange arm")), ("silver", tr("silver arm"))
    if simulation.room.ball is not None:
        yours = "orange", tr("ball")
    elif run.avoid == "guided":
        yours, other = other, yours
    # Of several first tasks the least gives words and unit.
    quantity = quantity_of_pair(run.quantity, frame.sample.pair)
    kept = FIRST_TASK_TEXTS.get(part_of_pair(run.quantity, frame.sample.pair).name)
    if kept is not None:
        yours, other = ("silver", tr(kept.other)), ("orange", tr("orange arm"))
    custom = isinstance(simulation.law, LawOfFile)
    return {
        "span": round(1e3 * _span(run)),
        "dm": round(1e3 * law.critical_distance),
        "v": round(1e3 * law.nominal_velocity),
        "curve": [] if custom else _curve(simulation.law, _span(run), law.critical_distance),
        "share": "λ" if custom else tr(LAW_TEXTS[law.law].share),
        "obstacle": yours,
        "arm": other,
        "two": two,
        "terms": [[term.kind, term.symbol, term.word] for term in terms],
        "apart": tr("mm apart") if kept is None else f"{quantity.page_unit} {tr(kept.apart)}",
        "overlap": tr("mm of overlap") if kept is None else f"{quantity.page_unit} {tr(kept.beyond)}",
        **({} if kept is None else {"mm": quantity.page_unit, "symbol": quantity.symbol}),
        "trends": [tr("the gap closes"), tr("the gap holds"), tr("the gap opens")]
        if kept is None
        else [
            # In one line, also beside a long name of the value.
            tr(text, symbol=quantity.symbol).replace(" ", "\u00a0")
            for text in (N_("{symbol} falls"), N_("{symbol} holds"), N_("{symbol} rises"))
        ],
        "ways": [tr(wording(text, run.quantity)) for text in ("closes", "opens")],
        "bodies": _bodies(simulation, run),
        "legend": _legend() if kept is None else _first_task_legend(simulation.room.wall is not None),
        "ghost": tr("ghost"),
        "gives": tr("gives way"),
        **_common_words(),
    }


def symbol_sentences(frame: Frame) -> dict[str, str]:
    """Symbol → its meaning in this run."""
    run = frame.settings.run
    if run.both_avoid:
        arm = other = tr("each arm")
    elif (first := FIRST_TASK_TEXTS.get(run.quantity.name)) is not None:
        arm, other = tr("the arm"), tr(first.other)
    elif frame.simulation.room.ball is not None:
        # The arm that meets the ball is the visitor's.
        arm, other = tr("the arm"), tr("the ball")
    elif frame.sample.pair < 0:
        arm, other = tr("the arm"), tr("the obstacle")
    else:
        arm, other = tr("the silver arm"), tr("the orange arm")
        if run.avoid == "guided":
            arm, other = other, arm
    quantity = run.quantity
    sentences = {
        name: in_symbols(tr(wording(symbol.sentence, quantity), arm=arm, other=other), quantity)
        for name, symbol in SYMBOLS.items()
    }
    if (kept := FIRST_TASK_TEXTS.get(quantity.name)) is not None:
        symbol = quantity.symbol
        sentences |= {"d": f"{symbol}: {tr(kept.meaning)}", "dm": f"{symbol}_m: {tr(kept.kept)}"}
    return sentences


def contact_numbers(frame: Frame, now: Contact, terms: list[Term], trend: int) -> CardNumbers:
    """d, law distance, d at rest and the ghost's d [mm], λ [‰], u, w and allowed approach [mm/s], trend,
    and the parts of ḋ [mm/s]; None if unknown."""
    sample, run, ghost = frame.sample, frame.settings.run, frame.ghost
    rest = math.nan if isinstance(frame.simulation.law, LawOfFile) else resting_now(frame.simulation, sample)
    return [
        _thousandths(sample.distance),
        _thousandths(now.distance),
        _thousandths(rest) if rest <= _span(run) else None,
        None if ghost is None else _thousandths(ghost.sample().distance),
        _thousandths(sample.activation),
        _thousandths(now.pull),
        _thousandths(now.approach),
        _thousandths(allowed_rate(run, sample)),
        trend,
        *(_thousandths(term.value) for term in terms),
    ]


def without_law(words: CardWords, numbers: CardNumbers) -> tuple[CardWords, Note, CardNumbers]:
    """Card without the law's values, while a question waits."""
    if "step" in words:
        return {**words, "asks": True, "step": 0.0, "title": "", "axis": ""}, ("", ""), numbers
    distance, law_distance, _, ghost = numbers[:4]
    words = {**words, "asks": True, "curve": [], "share": "", "terms": []}
    return words, ("", ""), [distance, law_distance, None, ghost, *[None] * 5]


def solo_words(run: RunSettings) -> CardWords:
    """Words for a single arm's error."""
    k = run.gain * run.overdrive * run.dt
    return {
        "step": round(1.0 - k, 4),
        "off": tr("mm off its place"),
        "title": "e ← (1 − K dt) e",
        "axis": tr("steps of {dt} ms", dt=decimal(f"{1e3 * run.dt:.3g}")),
        **_common_words(),
    }


def solo_note(run: RunSettings) -> Note:
    """CSS class and words below a single arm."""
    k = run.gain * run.overdrive * run.dt
    return (
        "alarm" if k >= 2.0 else "halt" if k == 0.0 else "",
        f"K dt = {decimal(f'{k:.3g}')}: {error_step(run)}",
    )


def solo_numbers(sample: Sample) -> CardNumbers:
    """|e| [µm]."""
    return [round(1e6 * sample.error)]


def _common_words() -> CardWords:
    return {
        "point": decimal("."),
        "name": tr("The line of contact"),
        "fold": tr("Fold this drawing"),
        "unfold": tr("Show the drawing"),
        "tone": tr("λ as a tone"),
    }


def contact_note(simulation: Simulation, sample: Sample, now: Contact, terms: list[Term]) -> Note:
    """CSS class and words below the drawing."""
    run, custom = simulation.settings, isinstance(simulation.law, LawOfFile)
    words = "" if custom else consequence(simulation, sample, now)
    if any(term.kind == "lost" and term.value for term in terms):
        words = missed(simulation, sample)
    if not custom and (promised := LAW_TEXTS[run.law.law].promise) is not None:
        return "", words or in_symbols(promised(run.law), run.quantity)
    if custom or not run.law.entry.promises:
        return "", words
    kind, promise = promise_words(simulation, sample)
    # For small λ the promise holds, but nothing is good news while no arm can give way.
    if kind == "go" and nearest_is_bolted(simulation, sample):
        return "halt", tr(BOLTED)
    if kind == "go" and words and words == lever_text(least_lever(sample), run.quantity):
        return "", words
    return kind, ", ".join(text for text in (promise, words) if text) if kind != "alarm" else promise


def _bodies(simulation: Simulation, run: RunSettings) -> dict[str, list[str]]:
    """Symbol → names of scene nodes, or parts of names without a leading slash."""
    line = [f"/closest/{part}" for part in ("line", "end0", "end1")]
    guided, avoiding = (f"/arms/{arm.name}" for arm in (simulation.guided, simulation.avoiding))
    own, other = (guided, avoiding) if run.avoid == "guided" else (avoiding, guided)
    if simulation.room.ball is not None:
        own, other = guided, "/ball"
    elif simulation.room.wall is not None:
        own, other = guided, "/wall"
    giving = [own, other] if run.both_avoid else [own]
    return {"d": line, "dm": ["skin_of_"], "lam": line, "v": giving, "u": giving, "w": [other]}


def _span(run: RunSettings) -> float:
    return max(WIDEST, 2.4 * run.law.critical_distance)


@lru_cache(maxsize=64)
def _curve(law: Law, span: float, critical: float) -> list[int]:
    """Positions [mm] and λ [‰] in turn; denser beyond d_m, where a large n bends the curve."""
    bend = critical + critical * np.linspace(0.0, 1.0, 21) ** 1.5
    jump = critical + np.array([-1e-6, 1e-6])
    places = np.unique(np.concatenate([np.linspace(0.0, span, 25), bend, jump]))
    return [n for d in places.tolist() if d <= span for n in (round(1e3 * d), round(1e3 * law.activation(d)))]


def _thousandths(value: float) -> int | None:
    return round(1e3 * value) if math.isfinite(value) else None
