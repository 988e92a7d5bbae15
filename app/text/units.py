"""A number and its unit stay on one line."""

import re
from typing import Final

NO_BREAK: Final = "\u00a0"

_UNIT: Final = re.compile(
    r"(?<=[\d∞–]) (?=(?:mm²|mm/s|mm|cm|m/rad|m/s|m²|m|ms|s|min|rad²|rad/s|rad|°/s|Hz|1/s|%)(?![\w/]))",
)
"""Space between a number and one of the units in the texts."""


def unbroken(text: str) -> str:
    """Text or HTML with a no-break space between every number and its unit."""
    return _UNIT.sub(NO_BREAK, text)
