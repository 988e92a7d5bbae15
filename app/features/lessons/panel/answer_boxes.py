"""Input boxes of a step."""

import math
import re
from collections.abc import Callable
from itertools import chain, repeat
from typing import Final

import viser

from app.features.lessons.bookmark import Phase
from app.features.lessons.lesson import Challenge, Step
from app.features.lessons.outcomes import asks_for_distance
from app.features.lessons.panel.lesson_html import rules_html
from app.features.lessons.panel.lesson_panel import ORDER
from app.features.lessons.progress import LONGEST_REASON, kept_reason
from app.features.lessons.session.lesson_actions import GiveReason, Guess, SayNumber
from app.features.lessons.session.lesson_session import LessonSession
from app.features.lessons.step_view import StepView
from app.features.measures.quantities.quantity import UNITS
from app.i18n.speaking import decimal, tr
from app.session.session import Session
from app.text.templates import element
from app.web.control_events import on_entry
from app.web.viser_internals import uuid_of

_NUMBER: Final = re.compile(
    r"\s*([+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:e[+-]?\d+)?)\s*(?:[^\s\d.,].*)?", re.DOTALL | re.IGNORECASE
)
"""A number and its unit; 1.000,5 is not a number."""

_GUESS: Final = ORDER["choices"] + 0.5
_REASON: Final = ORDER["choices"] + 7.5


class Forecasts:
    """Boxes for forecasts. Each step has its own, since the last text may arrive after a change of step."""

    def __init__(
        self, gui: viser.GuiApi, session: Session, run: LessonSession, tab: viser.GuiTabHandle
    ) -> None:
        self._gui, self._session, self._run, self._tab = gui, session, run, tab
        self._boxes: dict[tuple[str, str], list[viser.GuiTextHandle]] = {}
        self._shown: tuple[str, str] | None = None

    def _make(self, view: StepView, challenge: Challenge, index: int) -> viser.GuiTextHandle:
        lesson, step = view.lesson.id, view.step.id
        unit = UNITS[challenge.forecasts[index].measurement.unit].sign
        hint = tr("Your number, in {unit}.", unit=unit) if unit else tr("Your number.")
        with self._tab:
            box = self._gui.add_text(view.forecasts[index], "", hint=hint, order=ORDER["after"] + 1.0 + index)
        return on_entry(
            box, lambda text: self._session.post(SayNumber(lesson, step, index, read_number(text)))
        )

    def show(self, view: StepView, challenge: Challenge | None) -> None:
        here = (view.lesson.id, view.step.id) if challenge is not None else None
        if self._shown == here:
            return
        self._shown = here
        if challenge is not None and here is not None:
            if here not in self._boxes:
                self._boxes[here] = [self._make(view, challenge, i) for i in range(len(challenge.forecasts))]
            for box, number in zip(self._boxes[here], chain(self._run.said, repeat(None)), strict=False):
                box.value = "" if number is None else decimal(f"{number:g}")
        for place, boxes in self._boxes.items():
            for box in boxes:
                box.visible = place == here


def read_number(text: object) -> float | None:
    """Number with a decimal point or comma, and perhaps a unit; or None."""
    found = _NUMBER.fullmatch(text[:40].replace("−", "-")) if isinstance(text, str) else None
    number = float(found[1].replace(",", ".")) if found is not None else math.inf
    return number if abs(number) < 1e9 else None


def add_guess_box(gui: viser.GuiApi, post: Callable[[Guess], None]) -> str:
    """Add a hidden box for a guess [mm], set by `contact_guess.js`; return its id."""

    def take(text: str) -> None:
        try:
            place, mm = text[:200].split(" ")
            lesson, step = place.split("/")
            guess = Guess(lesson, step, float(mm) / 1000.0)
        except ValueError:
            return
        post(guess)

    box = uuid_of(on_entry(gui.add_text("guess", "", order=_GUESS), take))
    hidden = f'div:has(> div > div > p > label[for="{box}"])'
    gui.add_html(rules_html(f"{hidden}{{display:none}}"), order=_GUESS)
    return box


def guess_words(lessons: LessonSession, box: str) -> dict[str, object]:
    """Data of the card's guess; {} if the step asks for no distance, or for an onlooker."""
    if not box or not lessons.open or lessons.listing or not asks_for_distance(lessons.walk.step):
        return {}
    walk = lessons.walk
    mm = None if walk.done.guess is None else round(1000.0 * walk.done.guess)
    return {
        "guess": {
            "name": tr("my guess"),
            "hint": tr("Drag ▼ along the axis to your guess."),
            "mm": mm,
            "at": f"{walk.lesson.id}/{walk.step.id}",
            "box": box if walk.guessing else "",
        }
    }


class ReasonBox:
    """Boxes for reasons. Each step has its own, see `Forecasts`."""

    def __init__(
        self, gui: viser.GuiApi, post: Callable[[GiveReason], None], tab: viser.GuiTabHandle
    ) -> None:
        self._gui, self._post, self._tab = gui, post, tab
        self._boxes: dict[tuple[str, str], viser.GuiTextHandle] = {}
        self._readers: viser.GuiHtmlHandle | None = None

    def _make(self, lesson: str, step: str) -> viser.GuiTextHandle:
        hint = tr("Optional: one line of at most {count} characters.", count=LONGEST_REASON)
        with self._tab:
            box = self._gui.add_text(tr("Because …"), "", visible=False, hint=hint, order=_REASON)

        return on_entry(box, lambda words: self._post(GiveReason(lesson, step, words)))

    def show(self, view: StepView | None) -> None:
        here: tuple[str, str] | None = None
        if view is not None and takes_reason(view.step, view.phase):
            here = view.lesson.id, view.step.id
            if here not in self._boxes:
                self._boxes[here] = self._make(*here)
            if kept_reason(self._boxes[here].value) != view.done.because:
                # Changed by a reload or a reset, not by typing.
                self._boxes[here].value = view.done.because
        for place, box in self._boxes.items():
            box.visible = place == here
        if here is not None and self._readers is None:
            self._readers = add_readers(self._gui, self._tab, _REASON + 0.1)
        if self._readers is not None:
            self._readers.visible = here is not None


def takes_reason(step: Step, phase: Phase) -> bool:
    return (step.question is not None or step.drawing is not None) and phase in (Phase.PREDICT, Phase.DO)


def add_readers(gui: viser.GuiApi, tab: viser.GuiTabHandle, order: float) -> viser.GuiHtmlHandle:
    words = element("p", tr("Only your lab report shows it; you decide who gets that."), class_="crumb")
    with tab:
        return gui.add_html(element("div", "", words, class_="duet duet-lesson"), order=order, visible=False)
