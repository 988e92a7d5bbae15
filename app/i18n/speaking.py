"""Whose language is spoken: everything that is drawn for one visitor, or for one stage, is drawn within one frame of one thread,
so that the language is known there without being handed to every part."""

from collections.abc import Iterable
from contextvars import ContextVar
from typing import Final

from app.i18n.catalogue import Words, words_of
from app.settings import Language

_WORDS: Final[ContextVar[Words | None]] = ContextVar("duet_words", default=None)


def set_language(language: Language) -> None:
    """From now on everything in this thread, or in this task, is said in a language."""
    _WORDS.set(words_of(language))


def spoken() -> Words:
    """Return the words of the language that is spoken here; English where nobody has chosen."""
    return _WORDS.get() or words_of("en")


def tr(text: str, /, **parts: object) -> str:
    """Return an English text in the language that is spoken here, with its {names} filled in."""
    return spoken()(text, **parts)


def tr_all(texts: Iterable[str]) -> tuple[str, ...]:
    """Return several texts in the language that is spoken here."""
    return tuple(tr(text) for text in texts)


def N_(english: str) -> str:
    """Return the text as it is. It marks a text that is said later, so that it gets into the list of what is to be translated."""
    return english
