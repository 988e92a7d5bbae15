"""A pseudo-language for tests: every text is longer and has accents and brackets, which shows texts that are cut off or not translated."""

import re
from functools import lru_cache
from typing import Final

GROWTH: Final = 0.4
"""Growth of a text's length, as of a short word in German."""

FIRST: Final = "⟦"
LAST: Final = "⟧"
FILL: Final = "·"

_ACCENTS: Final = str.maketrans("aceinostuyzACEINOSTUYZ", "áčéíñöšţüýžÁČÉÍÑÖŠŢÜÝŽ")
_UNCHANGED: Final = re.compile(r"(<[^>]*>|\{[^{}]*\}|&#?\w+;|https?://\S+|--\w[\w-]*)")


@lru_cache(maxsize=4096)
def pseudo(text: str) -> str:
    """Return a text in pseudo-language; tags, entities, {names} and options of the command line stay unchanged."""
    if not re.search(r"[A-Za-z]", text) or text.startswith(FIRST):
        return text
    pieces = _UNCHANGED.split(text)
    letters = sum(len(piece) for piece in pieces[::2])
    for i in range(0, len(pieces), 2):
        pieces[i] = pieces[i].translate(_ACCENTS)
    return f"{FIRST}{''.join(pieces)}{_fill(letters)}{LAST}"


def _fill(letters: int) -> str:
    """Return the filling for a text of some letters, in words of up to five so that lines can break."""
    count = max(round(GROWTH * letters) - 2, 0)
    words = [FILL * min(5, count - begin) for begin in range(0, count, 6)]
    return "".join(f" {word}" if letters > 12 else word for word in words if word)
