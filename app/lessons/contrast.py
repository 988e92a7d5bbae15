"""What a run that shows why an answer is wrong does otherwise than the step's own run, in words."""

import math
from dataclasses import dataclass
from typing import Final

from app.i18n.catalogue import words_of
from app.i18n.speaking import N_
from app.lessons.labels import compared_text
from app.lessons.lesson import Choice, Compared
from app.lessons.outcomes import unlike
from app.lessons.runs import Input, Pairs, Setup, page_value, settings_text
from app.settings import Language
from scenes.settings import values

_SCRIPTS: Final = {
    "elbow_to": N_("the elbow swings by {angle} to either side"),
    "hand_to": N_("the hand is led to another place"),
    "push": N_("you push at {speed}"),
}
"""Script → what is done in it, where it is all that differs."""


@dataclass(frozen=True)
class Contrast:
    """The run that shows why an answer is wrong, beside the step's own.

    Attributes:
        headline: whether the answer is right here, and what differs.
        keys: settings that differ.
        here: what differs, as it is in this run.
        asked: as it is in the step's own run.
        names: short names of the two runs, for a legend.
    """

    headline: str
    keys: tuple[str, ...]
    here: str
    asked: str
    names: tuple[str, str]


def contrast_of(asked: Setup, choice: Choice, language: Language) -> Contrast | None:
    """Return in what the run of a wrong answer differs from the step's own; None where the answer has no run."""
    if choice.why is None:
        return None
    words, run = words_of(language), asked.run
    changes = unlike(run, choice.why.run)
    start = choice.why.start if choice.why.start != asked.start else None
    here = compared_text(Compared(changes, start), language)
    if not here:
        here = _done(choice.why.input, language)
    before = values(run)
    unchanged = tuple((key, before[key]) for key, _ in changes)
    asked_text = settings_text(unchanged, language) if changes else words(N_("as in the question"))
    return Contrast(
        words(N_("Here you would be right: {what}") if choice.otherwise else N_("Here, too, you are wrong: {what}"), what=here),
        tuple(key for key, _ in changes),
        here,
        asked_text,
        (_chosen(changes, language) or here, _chosen(unchanged, language) or asked_text),
    )


def _chosen(changes: Pairs, language: Language) -> str:
    """Return a choice without the name of its setting; "" where more than one choice differs."""
    return page_value(*changes[0], language) if len(changes) == 1 and isinstance(changes[0][1], str) else ""


def _done(given: Input, language: Language) -> str:
    parameters = {key: value for key, value in given.parameters if isinstance(value, float)}
    text = _SCRIPTS.get(given.name, N_("another movement"))
    angle, speed = math.degrees(parameters.get("angle", 0.0)), parameters.get("speed", 0.0)
    return words_of(language)(text, angle=f"{angle:.0f}°", speed=f"{speed:g} m/s")
