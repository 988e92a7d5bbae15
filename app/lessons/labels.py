"""Names of measured numbers and of compared runs, as a person reads them."""

import re
from typing import Final

from app.i18n.catalogue import words_of
from app.i18n.speaking import N_
from app.lessons.lesson import Compared, Measurement
from app.lessons.measures.quantity import QUANTITIES, shown_parameter
from app.lessons.room_places import Anchor
from app.lessons.runs import settings_text
from app.settings import Language, Settings
from controllers.errors import LazyText
from scenes.settings import specs

_BALL: Final[dict[Anchor, str]] = {
    "goal": N_("the ball {gap} off the goal"),
    "hand": N_("the ball {gap} off the hand"),
    "middle": N_("the ball {gap} off the middle of the way"),
    "elbow": N_("the ball {gap} off the elbow"),
}


_WORD: Final = re.compile(r"[^\W\d_]{2} ?[^\W\d_]")
"""Begins with a word, and not with a symbol."""


def label_text(m: Measurement) -> LazyText:
    """Return the name of a measurement; {angle} and the like in it are its parameters."""
    parameters = dict(m.parameters)
    if m.name == "setting":
        return LazyText(specs(Settings)[str(parameters["key"])].label)
    return LazyText(QUANTITIES[m.name].label, **{name: shown_parameter(name, value) for name, value in parameters.items()})


def label_of(m: Measurement, language: Language = "en") -> str:
    """Return the name of a measurement in a language, as the beginning of a sentence."""
    return sentence(words_of(language)(label_text(m)))


def sentence(text: str) -> str:
    """Return a text as a sentence: its first word gets a capital, a symbol such as d, λ or dt does not."""
    return text[0].upper() + text[1:] if _WORD.match(text) else text


def compared_text(compared: Compared, language: Language = "en") -> str:
    """Return in what a further run differs: "n = 2", "the ball 100 mm off the goal"."""
    words, parts = words_of(language), [settings_text(compared.changes, language)] if compared.changes else []
    ball = compared.start.ball if compared.start is not None else None
    if ball is not None:
        parts.append(words(_BALL[ball.origin], gap=shown_parameter("gap", ball.gap)))
        if ball.toward == "upper_arm":
            parts.append(words(N_("{angle} beside the upper arm"), angle=shown_parameter("angle", ball.tilt)))
    elif compared.start is not None:
        parts.append(words(N_("another posture at the start")))
    return ", ".join(parts)
