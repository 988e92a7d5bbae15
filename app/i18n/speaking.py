"""The current language: everything that one visitor sees is drawn within one frame of one thread, which sets the language first, so that
no part takes it as an argument."""

from contextvars import ContextVar
from typing import Final

from app.i18n.catalogue import Words, words_of
from app.settings import Language
from controllers.errors import NumberText

_WORDS: Final[ContextVar[Words | None]] = ContextVar("duet_words", default=None)


def set_language(language: Language) -> None:
    """Set the language of this thread, or of this task."""
    _WORDS.set(words_of(language))


def spoken() -> Words:
    """Return the catalogue of the current language; English where none is set."""
    return _WORDS.get() or words_of("en")


def tr(text: str, /, **parts: object) -> str:
    """Return an English text in the current language, with its {names} filled in."""
    return spoken()(text, **parts)


def decimal(number: str) -> str:
    """Return a number with the decimal sign of the current language."""
    return tr(NumberText(number))


def N_(english: str) -> str:
    """Return the text unchanged: marks a text for the catalogues that `tr` translates later, as in gettext."""
    return english
