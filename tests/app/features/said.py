"""Messages as an approved text, one line for each case."""

from collections.abc import Mapping

from app.i18n.catalogue import words_of
from app.settings import Language
from tests.approved import case_lines, without_numbers

__all__ = ["lines_of", "without_numbers"]


def lines_of(said: Mapping[str, str], language: Language = "en") -> str:
    """`case: message` lines in a language."""
    words = words_of(language)
    return case_lines({case: words(text) for case, text in said.items()})
