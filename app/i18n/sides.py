"""The two sides of a person or of a robot."""

from typing import Final

from app.i18n.speaking import N_, tr

SIDES: Final = {"left": N_("left side"), "right": N_("right side")}
"""Name of an arm → text of the catalogue: “right” alone is also the verdict on a prediction."""


def side(name: str) -> str:
    """Return "left" or "right" in the current language; any other name unchanged."""
    if name not in SIDES:
        return name
    translated = tr(SIDES[name])
    return name if translated == SIDES[name] else translated
