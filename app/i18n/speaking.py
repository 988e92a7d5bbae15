"""The current language. A frame draws one visitor's page in one thread and sets it first, so that functions
need no argument.
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
    """Current catalogue; English if none is set."""
    return _WORDS.get() or words_of("en")


def tr(text: str, /, **parts: object) -> str:
    """Translation into the current language, with {names} filled in."""
    return spoken()(text, **parts)


def decimal(number: str) -> str:
    return tr(NumberText(number))


def N_(english: str) -> str:
    """Mark a text for the catalogues, as in gettext; `tr` translates it later."""
    return english
