"""The current language. All of one visitor's page is drawn within one frame of one thread, which sets it
first, so that no function needs it as an argument.
"""

from contextvars import ContextVar
from typing import Final

from app.i18n.catalogue import Words, words_of
from app.settings import Language
from controllers.errors import NumberText

_WORDS: Final[ContextVar[Words | None]] = ContextVar("duet_words", default=None)


def set_language(language: Language) -> None:
    _WORDS.set(words_of(language))


def spoken() -> Words:
    """Catalogue of the current language; English if none is set."""
    return _WORDS.get() or words_of("en")


def tr(text: str, /, **parts: object) -> str:
    """An English text in the current language, with its {names} filled in."""
    return spoken()(text, **parts)


def decimal(number: str) -> str:
    return tr(NumberText(number))


def N_(english: str) -> str:
    """Marks a text for the catalogues that `tr` translates later, as in gettext; returns it unchanged."""
    return english
