"""Names of measured numbers and of compared runs, as a person reads them."""

from typing import Final

from app.i18n.catalogue import words_of
from app.i18n.speaking import N_
from app.lessons.lesson import Compared, Measurement
from app.lessons.measures.quantity import QUANTITIES, shown_parameter
from app.lessons.room_places import Anchor
from app.lessons.runs import settings_text
from app.settings import Language, Settings
from scenes.settings import specs

_BALL: Final[dict[Anchor, str]] = {
    "goal": N_("the ball {gap} off the goal"),
    "hand": N_("the ball {gap} off the hand"),
    "middle": N_("the ball {gap} off the middle of the way"),
    "elbow": N_("the ball {gap} off the elbow"),
}


def label_of(m: Measurement, language: Language = "en") -> str:
    """Return the name of a measurement, as the beginning of a sentence; {angle} and the like in it are its parameters."""
    parameters = dict(m.parameters)
    if m.name == "setting":
        return specs(Settings)[str(parameters["key"])].label
    text = words_of(language)(
        QUANTITIES[m.name].label, **{name: shown_parameter(name, value) for name, value in parameters.items()}
    )
    # A word gets a capital, a symbol such as d, λ or u does not.
    return text[0].upper() + text[1:] if text[:2].isalpha() and text[:2].islower() else text


def compared_text(compared: Compared, language: Language = "en") -> str:
    """Return in what a further run differs: "n = 2", "the ball 100 mm off the goal"."""
    words, parts = words_of(language), [settings_text(compared.changes)] if compared.changes else []
    ball = compared.start.ball if compared.start is not None else None
    if ball is not None:
        parts.append(words(_BALL[ball.origin], gap=shown_parameter("gap", ball.gap)))
        if ball.toward == "upper_arm":
            parts.append(words(N_("{angle} beside the upper arm"), angle=shown_parameter("angle", ball.tilt)))
    elif compared.start is not None:
        parts.append(words(N_("another posture at the start")))
    return ", ".join(parts)
