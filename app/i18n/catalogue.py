"""The catalogue of a language: English text → translation. A missing text stays English; a broken catalogue is logged."""

import logging
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Final

from app.i18n.pseudo import pseudo
from app.settings import Language
from controllers.errors import LazyText, NumberText

log = logging.getLogger("duet.languages")

FOLDER: Final = Path(__file__).parent
"""Holds one TOML file a language: English text = translation."""

CONTEXT: Final = "\x04"
"""Separates a context from the text, where English has one word for two things: "lesson" + CONTEXT + "Run", as in gettext."""

DECIMAL_SIGN: Final = f"decimal sign{CONTEXT}."

_NOTHING: Final[Mapping[str, str]] = MappingProxyType({})


class Count(int):
    """A whole number that chooses its word in a text: {pairs:pair|pairs}, or in Slovene for one, two, three or four, and more."""

    def __format__(self, spec: str) -> str:
        forms = spec.split("|")
        if len(forms) == 1:
            return super().__format__(spec)
        number = self % 100 if len(forms) > 2 else self
        return forms[min({1: 0, 2: 1, 3: 2, 4: 2}.get(number, 3), len(forms) - 1)]


class _Number(float):
    """A number that is written with a decimal sign."""

    sign: str

    def __new__(cls, value: float, sign: str) -> "_Number":
        made = super().__new__(cls, value)
        made.sign = sign
        return made

    def __format__(self, spec: str) -> str:
        return super().__format__(spec).replace(".", self.sign)


@dataclass(frozen=True)
class Words:
    """The texts of one language.

    Attributes:
        language: its code, as in a link.
        texts: English text → translation.
        otherwise: translates a text that is not among them.
    """

    language: Language
    texts: Mapping[str, str]
    otherwise: Callable[[str], str] = str

    def __call__(self, text: str, /, **parts: object) -> str:
        """Return an English text in this language, with its {names} filled in; a `LazyText` brings its own parts."""
        if isinstance(text, NumberText):
            return text.replace(".", self(DECIMAL_SIGN))
        if isinstance(text, LazyText):
            return self(text.template, **text.parts, **parts)
        found = self.texts.get(text)
        text = text.rpartition(CONTEXT)[2]
        translated = self.otherwise(text) if found is None else found
        if not parts:
            return translated
        parts = {name: self._part(part) for name, part in parts.items()}
        try:
            return translated.format(**parts)
        except (KeyError, IndexError, ValueError):
            # A mistake in a translation must not break the page.
            return text.format(**parts)

    def _part(self, part: object) -> object:
        if isinstance(part, float):
            return _Number(part, self(DECIMAL_SIGN))
        return self(part) if isinstance(part, LazyText | NumberText) else Count(part) if type(part) is int else part


@cache
def words_of(language: Language) -> Words:
    """Return the texts of a language; English for "auto", and if its catalogue cannot be read."""
    if language == "pseudo":
        return Words("pseudo", _NOTHING, pseudo)
    if language in ("auto", "en"):
        return Words("en", _NOTHING)
    try:
        return Words(language, MappingProxyType(read_texts(FOLDER / f"{language}.toml")))
    except (OSError, ValueError) as error:
        log.warning("the texts in %s.toml cannot be read (%s); the page stays English", language, error)
        return Words(language, _NOTHING)


def read_texts(path: Path) -> dict[str, str]:
    """Return English text → translation of one catalogue.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is not TOML, has a key twice, or a value that is not a text.
    """
    with path.open("rb") as file:
        texts = tomllib.load(file)
    for key, text in texts.items():
        if not isinstance(text, str):
            raise ValueError(f"the value of {key!r} must be a text")
    return texts
