"""The two sides of a person or of a robot."""

from typing import Final

from app.i18n.speaking import N_, tr

SIDES: Final = {"left": N_("left side"), "right": N_("right side")}
"""The names of the arms → what is translated: “right” alone is also what a prediction may be."""


def side(name: str) -> str:
    """Return "left" or "right" in the language that is spoken here; another name as it is."""
    if name not in SIDES:
        return name
    said = tr(SIDES[name])
    return name if said == SIDES[name] else said
