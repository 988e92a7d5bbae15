"""What the card of the line of contact is drawn from: words and a curve when they change, a few numbers ten times a second.

The page's `contact_card.js` draws the card.
"""

import json
import math
from collections.abc import Callable
from functools import lru_cache
from typing import Final

import numpy as np
import viser

from app.custom_law.custom_law import CustomLaw
from app.i18n.speaking import N_, tr
from app.page.panels.promise_pills import promise_words
from app.page.panels.rate_budget import (
    Term,
    allowed_rate,
    budget_terms,
    consequence,
    error_step,
    missed,
    trend,
)
from app.plots.time_series import resting
from app.session.contact import Contact
from app.session.frame import Frame
from app.session.relevant_settings import both_avoid
from app.text.html_element import element
from controllers.laws.situation import Law
from scenes.history import Sample
from scenes.promise import makes_promise
from scenes.settings import LawName, RunSettings
from scenes.simulation import Simulation

PERIOD: Final = 0.1
"""Wall time between two sets of numbers [s]; the page eases from one to the next."""

WIDEST: Final = 0.36
"""Length of the axis of d [m], or more where d_m is large."""

SHARES: Final[dict[LawName, str]] = {
    "smooth_priority": "λ",
    "strict_priority": "priority",
    "strict_switched": "priority",
    "null_space_avoidance": "λ",
    "potential_field": "push, of 1",
    "barrier_qp": "1 − allowed",
    "intermediate_value": "λ",
    "task_activation": "a²",
    "continuous_inverse": "λ",
    "set_based_task": "active",
    "unprotected": "λ",
}
"""What the law's activation is called."""

TRENDS: Final = (N_("the gap closes"), N_("the gap holds"), N_("the gap opens"))

_json: Final = json.JSONEncoder(ensure_ascii=False, separators=(",", ":")).encode

Numbers = list[int | None]
Words = dict[str, object]
Note = tuple[str, str]


class ContactCard:
    """Sends what the card is drawn from; there is nothing to see of it in the panels.

    Args:
        gui: of those who see the card.
        tab: of the plots; a folded panel is not on the page, one of several is.
    """

    def __init__(self, gui: viser.GuiApi, tab: viser.GuiTabHandle) -> None:
        self._parts = {name: [gui.add_html("", order=-1.0)] for name in ("words", "note", "now")}
        with tab:
            for handles in self._parts.values():
                handles.append(gui.add_html("", order=-1.0))
        self._sent: dict[str, object] = {}
        self._next = 0.0
        self._shown: tuple[object, ...] = ()
        self._trend = 0

    def show(self, frame: Frame, further: Callable[[], Words]) -> None:
        """Send what has changed: every `PERIOD` while the run goes on, and at once while it rests. `further`: gives more words."""
        if frame.now < self._next and not frame.pace.paused:
            return
        more = further()
        state = frame.state, more
        if state == self._shown:
            return
        self._shown, self._next = state, frame.now + PERIOD
        if frame.sample.pair < 0:
            words, note, numbers = solo_words(frame.settings.run), solo_note(frame.settings.run), solo_numbers(frame.sample)
        else:
            now = frame.contact
            terms = budget_terms(frame.simulation, frame.sample, now)
            self._trend = trend(sum(term.value for term in terms), self._trend)
            words = {**contact_words(frame, terms), **more}
            note = contact_note(frame.simulation, frame.sample, now, terms)
            numbers = contact_numbers(frame, now, terms, self._trend)
        if frame.replayed:
            words["past"] = tr("replay")
        parts: dict[str, object] = {"words": words, "note": note, "now": numbers}
        changed = [name for name, part in parts.items() if part != self._sent.get(name)]
        self._sent = parts
        for name in changed:
            content = element("i", class_=f"duet-contact-{name}", data_text=part_text(parts[name]))
            for handle in self._parts[name]:
                handle.content = content


def part_text(part: object) -> str:
    """Return words, note or numbers as the page reads them: JSON, but for the numbers, which are sent at every moment."""
    return ",".join("" if number is None else str(number) for number in part) if isinstance(part, list) else _json(part)


def contact_words(frame: Frame, terms: list[Term]) -> Words:
    """Return what the card says, and the curve λ(d) [mm, ‰], in the visitor's language."""
    simulation, run = frame.simulation, frame.settings.run
    law, two = run.law, both_avoid(run)
    yours, other = ("orange", tr("orange arm")), ("silver", tr("silver arm"))
    if run.scene == "ball":
        yours = "orange", tr("ball")
    elif run.avoid == "guided":
        yours, other = other, yours
    custom = isinstance(simulation.law, CustomLaw)
    return {
        "span": round(1e3 * _span(run)),
        "dm": round(1e3 * law.critical_distance),
        "v": round(1e3 * law.nominal_velocity),
        "curve": [] if custom else _curve(simulation.law, _span(run), law.critical_distance),
        "share": "λ" if custom else tr(SHARES[law.law]),
        "obstacle": yours,
        "arm": other,
        "two": two,
        "terms": [[term.kind, term.symbol, term.word] for term in terms],
        "apart": tr("mm apart"),
        "overlap": tr("mm of overlap"),
        "trends": [tr(text) for text in TRENDS],
        "ways": [tr("closes"), tr("opens")],
        "bodies": _bodies(simulation, run),
        "rests": tr("rests"),
        "ghost": tr("ghost"),
        **_button_words(),
    }


def contact_numbers(frame: Frame, now: Contact, terms: list[Term], trend: int) -> Numbers:
    """Return d, the law's d, d* and the ghost's d [mm], λ [‰], u, w and the allowed approach [mm/s], the trend, and every part of ḋ
    [mm/s]; None for what there is not."""
    sample, run, ghost = frame.sample, frame.settings.run, frame.ghost
    second = sample.second
    rest = resting(run, now.pull, now.approach, None if second is None else second.pull)
    if isinstance(frame.simulation.law, CustomLaw):
        rest = math.nan
    return [
        _thousandths(sample.distance),
        _thousandths(now.distance),
        _thousandths(rest) if rest <= _span(run) else None,
        None if ghost is None else _thousandths(ghost.sample().distance),
        _thousandths(sample.activation),
        _thousandths(now.pull),
        _thousandths(now.approach),
        _thousandths(allowed_rate(run, now.distance)),
        trend,
        *(_thousandths(term.value) for term in terms),
    ]


def solo_words(run: RunSettings) -> Words:
    """Return what the card says of an arm that stands alone: how its error goes on, step by step."""
    k = run.gain * run.overdrive * run.dt
    return {
        "step": round(1.0 - k, 4),
        "off": tr("mm off its place"),
        "title": "e ← (1 − K dt) e",
        "axis": tr("steps of {dt} ms", dt=f"{1e3 * run.dt:.3g}"),
        **_button_words(),
    }


def solo_note(run: RunSettings) -> Note:
    """Return class and words of the line below the drawing of an arm that stands alone."""
    k = run.gain * run.overdrive * run.dt
    return "alarm" if k >= 2.0 else "halt" if k == 0.0 else "", f"K dt = {k:.3g}: {error_step(run)}"


def solo_numbers(sample: Sample) -> Numbers:
    """Return |e| [µm]."""
    return [round(1e6 * sample.error)]


def _button_words() -> Words:
    return {"name": tr("The line of contact"), "fold": tr("Fold this drawing"), "unfold": tr("Show the drawing")}


def contact_note(simulation: Simulation, sample: Sample, now: Contact, terms: list[Term]) -> Note:
    """Return class and words of the line below the drawing."""
    run, custom = simulation.settings, isinstance(simulation.law, CustomLaw)
    words = "" if custom else consequence(run, sample, now)
    if any(term.kind == "lost" and term.value for term in terms):
        words = missed(simulation, now)
    if custom or not makes_promise(run.law):
        return "", words
    kind, promise = promise_words(simulation, sample, "d ≥ d<sub>m</sub>")
    return kind, ", ".join(text for text in (promise, words) if text) if kind != "alarm" else promise


def _bodies(simulation: Simulation, run: RunSettings) -> dict[str, list[str]]:
    """Return symbol → nodes of the scene that it is about, by name, or by a part of it that begins without a slash."""
    line = [f"/closest/{part}" for part in ("line", "end0", "end1")]
    guided, avoiding = (f"/arms/{arm.name}" for arm in (simulation.guided, simulation.avoiding))
    own, other = (guided, avoiding) if run.avoid == "guided" else (avoiding, guided)
    if run.scene == "ball":
        own, other = guided, "/ball"
    giving = [own, other] if both_avoid(run) else [own]
    return {"d": line, "dm": ["skin_of_"], "lam": line, "v": giving, "u": giving, "w": [other]}


def _span(run: RunSettings) -> float:
    return max(WIDEST, 2.4 * run.law.critical_distance)


@lru_cache(maxsize=64)
def _curve(law: Law, span: float, critical: float) -> list[int]:
    """Return places on the axis and λ there, in turn [mm, ‰]; closer together beyond d_m, where a large n bends the curve."""
    bend = critical + critical * np.linspace(0.0, 1.0, 21) ** 1.5
    jump = critical + np.array([-1e-6, 1e-6])
    places = np.unique(np.concatenate([np.linspace(0.0, span, 25), bend, jump]))
    return [n for d in places.tolist() if d <= span for n in (round(1e3 * d), round(1e3 * law.activation(d)))]


def _thousandths(value: float) -> int | None:
    return round(1e3 * value) if math.isfinite(value) else None
