"""What is said, as an approved text: a line for each case."""

import re
from collections.abc import Mapping

from app.i18n.catalogue import words_of
from app.settings import Language


def lines_of(said: Mapping[str, str], language: Language = "en") -> str:
    """`case: what is said`, in a language."""
    words = words_of(language)
    return "".join(f"{case}: {words(text)}\n" for case, text in said.items())


def without_numbers(text: str) -> str:
    """For texts whose numbers come from a simulation: each number as #."""
    return re.sub(r"\d+(?:[.,]\d+)*(?:e[+-]?\d+)?", "#", text)
