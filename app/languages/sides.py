"""The two sides of a person or of a robot."""

from typing import Final

from app.languages.speaking import say, text

SIDES: Final = {"left": text("left side"), "right": text("right side")}
"""The names of the arms → what is translated: “right” alone is also what a prediction may be."""


def side(name: str) -> str:
    """Return "left" or "right" in the language that is spoken here; another name as it is."""
    if name not in SIDES:
        return name
    said = say(SIDES[name])
    return name if said == SIDES[name] else said
