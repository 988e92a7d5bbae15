"""Labels of measurements, and differences between runs in words."""

import math
import re
from dataclasses import dataclass
from typing import Final

from app.features.lessons.lesson import Choice, Compared, Measurement
from app.features.lessons.runs import Pairs, Setup, deviations, settings_text
from app.features.measures.quantities.quantity import QUANTITIES, shown_parameter
from app.features.measures.room_places import Anchor
from app.i18n.catalogue import words_of
from app.i18n.speaking import N_
from app.settings import Language, Settings
from app.text.setting_values import page_value
from controllers.errors import LazyText, NumberText
from scenes.quantities import DISTANCE, KeptQuantity
from scenes.settings import specs, values

_BALL: Final[dict[Anchor, str]] = {
    "goal": N_("the ball {gap} off the goal"),
    "hand": N_("the ball {gap} off the hand"),
    "middle": N_("the ball {gap} off the middle of the way"),
    "elbow": N_("the ball {gap} off the elbow"),
}


_WORD: Final = re.compile(r"[^\W\d_]{2} ?[^\W\d_]")


def label_text(m: Measurement) -> LazyText:
    parameters = dict(m.parameters)
    if m.name == "setting":
        return LazyText(specs(Settings)[str(parameters["key"])].label.replace("d_m", "dₘ"))
    return LazyText(
        QUANTITIES[m.name].label, **{name: shown_parameter(name, value) for name, value in parameters.items()}
    )


def label_of(m: Measurement, language: Language = "en") -> str:
    return sentence(words_of(language)(label_text(m)))


def sentence(text: str) -> str:
    """Capitalize a text, except a symbol such as d, λ or dt."""
    return text[0].upper() + text[1:] if _WORD.match(text) else text


def compared_text(compared: Compared, language: Language = "en", quantity: KeptQuantity = DISTANCE) -> str:
    """Difference of a further run, such as "n = 2"."""
    words = words_of(language)
    parts = [settings_text(compared.changes, language, quantity)] if compared.changes else []
    ball = compared.start.ball if compared.start is not None else None
    if ball is not None:
        parts.append(words(_BALL[ball.origin], gap=shown_parameter("gap", ball.gap)))
        if ball.toward == "upper_arm":
            parts.append(words(N_("{angle} beside the upper arm"), angle=shown_parameter("angle", ball.tilt)))
    elif compared.start is not None:
        parts.append(words(N_("another posture at the start")))
    return ", ".join(parts)


_SCRIPTS: Final = {
    "elbow_to": N_("the elbow is asked to swing by {angle} to either side"),
    "hand_to": N_("the hand is led to another place"),
    "push": N_("you push at {speed}"),
}


@dataclass(frozen=True)
class Contrast:
    """Difference between two runs, in words.

    Attributes:
        headline: the difference, and if the answer is right in this run.
        here, asked: the difference in this run, and in the step's.
    """

    headline: str
    keys: tuple[str, ...]
    here: str
    asked: str
    names: tuple[str, str]


def contrast_of(asked: Setup, beside: Setup, answer: Choice | None, language: Language) -> Contrast:
    """Compare a run with the step's. `answer`: the wrong one; None for the student's curve."""
    words, run = words_of(language), asked.run
    # The drawing board shows the points of a curve.
    changes = tuple(change for change in deviations(run, beside.run) if change[0] != "curve")
    start = beside.start if beside.start != asked.start else None
    kept = run.quantity
    here = compared_text(Compared(changes, start), language, kept) or _done(asked, beside, language)
    before = values(run)
    unchanged = tuple((key, before[key]) for key, _ in changes)
    asked_text = settings_text(unchanged, language, kept) if changes else words(N_("as in the question"))
    return Contrast(
        words(_headline(answer), what=here),
        tuple(key for key, _ in changes),
        here,
        asked_text,
        (_chosen(changes, language) or here, _chosen(unchanged, language) or asked_text),
    )


def _headline(answer: Choice | None) -> str:
    if answer is None:
        return N_("Your curve at work: {what}")
    if answer.otherwise:
        return N_("Here you would be right: {what}")
    return N_("Here it is the same: {what}") if answer.same else N_("See for yourself: {what}")


def _chosen(changes: Pairs, language: Language) -> str:
    return page_value(*changes[0], language) if len(changes) == 1 and isinstance(changes[0][1], str) else ""


def _done(asked: Setup, beside: Setup, language: Language) -> str:
    given, words = beside.input, words_of(language)
    if given == asked.input:
        seconds, before = (NumberText(f"{setup.seconds:g}") for setup in (beside, asked))
        return words(N_("for {seconds} s instead of {before} s"), seconds=seconds, before=before)
    if given.kind == "none":
        return words(N_("nothing pulls the arm"))
    parameters = {key: value for key, value in given.parameters if isinstance(value, float)}
    text = _SCRIPTS.get(given.name, N_("another movement"))
    angle, speed = math.degrees(parameters.get("angle", 0.0)), parameters.get("speed", 0.0)
    return words(text, angle=f"{angle:.0f}°", speed=NumberText(f"{speed:g} m/s"))
