"""Catalogues: English text → translation, of the core here and of features. A missing text stays English; a
broken catalogue is logged.
"""

import logging
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache, lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Final

from app.settings import Language
from controllers.errors import LazyText, NumberText

log = logging.getLogger("duet.languages")

FOLDER: Final = Path(__file__).parent
"""Folder with one TOML file per language: English text = translation."""

_FOLDERS: Final = [FOLDER]

CONTEXT: Final = "\x04"
"""Between a context and a text, as in gettext, if one English word means two things: "lesson" + CONTEXT +
"Run".
"""

DECIMAL_SIGN: Final = f"decimal sign{CONTEXT}."


class Count(int):
    """A whole number that chooses its word: {pairs:pair|pairs}, in Slovene for one, two, three or four, and
    more.
    """

    def __format__(self, spec: str) -> str:
        forms = spec.split("|")
        if len(forms) == 1:
            return super().__format__(spec)
        number = self % 100 if len(forms) > 2 else self
        return forms[min({1: 0, 2: 1, 3: 2, 4: 2}.get(number, 3), len(forms) - 1)]


class _Number(float):
    sign: str

    def __new__(cls, value: float, sign: str) -> "_Number":
        made = super().__new__(cls, value)
        made.sign = sign
        return made

    def __format__(self, spec: str) -> str:
        return super().__format__(spec).replace(".", self.sign)


@dataclass(frozen=True)
class Words:
    """One language's texts.

    Attributes:
        texts: English text → translation.
        otherwise: translates missing texts.
    """

    language: Language
    texts: Mapping[str, str] = field(default_factory=dict)
    otherwise: Callable[[str], str] = str

    def __call__(self, text: str, /, **parts: object) -> str:
        """Translation with {names} filled in; a `LazyText` has its own parts."""
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
        return (
            self(part)
            if isinstance(part, LazyText | NumberText)
            else Count(part)
            if type(part) is int
            else part
        )


def add_catalogues(folders: Iterable[Path]) -> None:
    """Add folders with catalogues; texts without one stay English."""
    _FOLDERS.extend(folder for folder in folders if folder not in _FOLDERS)
    words_of.cache_clear()


def catalogues(language: Language) -> tuple[Path, ...]:
    paths = (folder / f"{language}.toml" for folder in _FOLDERS)
    return tuple(path for path in paths if path.parent == FOLDER or path.exists())


@cache
def words_of(language: Language) -> Words:
    if language == "pseudo":
        return Words("pseudo", otherwise=pseudo)
    if language in ("auto", "en"):
        return Words("en")
    texts: dict[str, str] = {}
    for path in catalogues(language):
        try:
            texts |= read_texts(path)
        except (OSError, ValueError) as error:
            log.warning("the texts in %s cannot be read (%s); they stay English", path, error)
    return Words(language, MappingProxyType(texts))


def read_texts(path: Path) -> dict[str, str]:
    """Texts of one catalogue.

    Raises:
        OSError: unreadable file.
        ValueError: not TOML, a key twice, or a value that is not a text.
    """
    with path.open("rb") as file:
        texts = tomllib.load(file)
    for key, text in texts.items():
        if not isinstance(text, str):
            raise ValueError(f"the value of {key!r} must be a text")
    return texts


# ---- pseudo-language of the tests: longer, with accents and brackets, to show clipped or untranslated texts

GROWTH: Final = 0.4
"""Relative growth of a text, as of short German words."""

FIRST: Final = "⟦"
LAST: Final = "⟧"
FILL: Final = "·"

_ACCENTS: Final = str.maketrans("aceinostuyzACEINOSTUYZ", "áčéíñöšţüýžÁČÉÍÑÖŠŢÜÝŽ")
_UNCHANGED: Final = re.compile(r"(<[^>]*>|\{[^{}]*\}|&#?\w+;|https?://\S+|--\w[\w-]*)")


@lru_cache(maxsize=4096)
def pseudo(text: str) -> str:
    """Pseudo-translation; tags, entities, {names} and command-line options stay unchanged."""
    if not re.search(r"[A-Za-z]", text) or text.startswith(FIRST):
        return text
    pieces = _UNCHANGED.split(text)
    letters = sum(len(piece) for piece in pieces[::2])
    for i in range(0, len(pieces), 2):
        pieces[i] = pieces[i].translate(_ACCENTS)
    return f"{FIRST}{''.join(pieces)}{_fill(letters)}{LAST}"


def _fill(letters: int) -> str:
    """Words of up to five letters, so that lines can break."""
    count = max(round(GROWTH * letters) - 2, 0)
    words = [FILL * min(5, count - begin) for begin in range(0, count, 6)]
    return "".join(f" {word}" if letters > 12 else word for word in words if word)
