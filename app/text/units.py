"""Keeps number and unit on one line."""

import re
from typing import Final

NO_BREAK: Final = "\u00a0"

_UNIT: Final = re.compile(
    r"(?<=[\d∞–]) (?=(?:mm²|mm/s|mm|cm|m/rad|m/s|m²|m|ms|s|min|rad²|rad/s|rad|°/s|Hz|1/s|%)(?![\w/]))",
)


def unbroken(text: str) -> str:
    return _UNIT.sub(NO_BREAK, text)
