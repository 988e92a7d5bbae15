"""What a person calls the numbers that are measured, in each language."""

from typing import Final

from app.lessons.lesson import Compared, Measurement, settings_text
from app.lessons.measures import QUANTITIES, shown_parameter
from app.lessons.words import say
from app.settings import Settings
from scenes.settings import specs

LABELS: Final[dict[str, dict[str, str]]] = {"de": {}, "sl": {}}
"""Language → name of the measurement → label; English labels stand with the measurements themselves."""


def label_of(m: Measurement, language: str = "en") -> str:
    """Return what a person calls a measurement, as the beginning of a sentence; {angle} and the like in a label are its parameters."""
    parameters = dict(m.parameters)
    if m.name == "setting":
        return specs(Settings)[str(parameters["key"])].label
    label = LABELS.get(language, {}).get(m.name, QUANTITIES[m.name].label)
    text = label.format(**{name: shown_parameter(name, value) for name, value in parameters.items()})
    # A word gets a capital, a symbol such as d, λ or u does not.
    return text[0].upper() + text[1:] if text[:2].isalpha() and text[:2].islower() else text


def compared_text(compared: Compared, language: str = "en") -> str:
    """Return in what a further run differs: "n = 2", "the ball 100 mm off the goal"."""
    parts = [settings_text(compared.changes)] if compared.changes else []
    ball = compared.start.ball if compared.start is not None else None
    if ball is not None:
        off = say(language, "ball_off", gap=shown_parameter("gap", ball.gap), origin=say(language, f"at_{ball.origin}"))
        beside = say(language, "ball_beside", angle=shown_parameter("angle", ball.tilt)) if ball.toward == "upper_arm" else ""
        parts.append(off + beside)
    elif compared.start is not None:
        parts.append(say(language, "elsewhere"))
    return ", ".join(parts)
