"""What a person calls the numbers that are measured, in each language."""

from typing import Final

from app.lessons.lesson import Measurement
from app.lessons.measures import QUANTITIES, shown_parameter
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
