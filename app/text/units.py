"""A number and its unit stay on one line."""

import re
from typing import Final

NO_BREAK: Final = "\u00a0"

_UNIT: Final = re.compile(
    r"(?<=[\d∞–]) (?=(?:mm²|mm/s|mm|cm|m/rad|m/s|m²|m|ms|s|min|rad²|rad/s|rad|°/s|Hz|1/s|%)(?![\w/]))",
)
"""The blank between a number and a unit, of those that texts have."""


def unbroken(text: str) -> str:
    """Return a text, or HTML, with a no-break space between every number and its unit."""
    return _UNIT.sub(NO_BREAK, text)
