"""The teacher's key: whoever opens the page with `?key=KEY` is a teacher."""

import secrets
from collections.abc import Mapping
from time import monotonic
from typing import Final

from app.web.index_page import KEY_LATER
from controllers.errors import BadSetting

AUTO: Final = "auto"
"""Instead of a key: one is made."""

SHORTEST: Final = 8
"""Shortest key [characters]."""

PERIOD: Final = 1.0
"""Time between a wrong key and the next one that is looked at, from one address [s]."""

MOST: Final = 1000
"""Addresses that are remembered."""


def chosen_key(asked: str | None) -> str | None:
    """Return the key that a server is started with, which is made here where "auto" is asked for.

    Raises:
        BadSetting: it is easily guessed.
    """
    if asked == AUTO:
        return secrets.token_urlsafe(9)
    if asked is not None and len(asked.strip()) < SHORTEST:
        raise BadSetting(
            f"key has fewer than {SHORTEST} characters and is soon guessed; give a longer one, "
            "or --key auto, which makes one and prints the link."
        )
    return asked


class Guesses:
    """Lets every address try one wrong key a second; until then no key from there is looked at. Behind a proxy all share one address.

    Belongs to the network's thread.

    Args:
        key: the teacher's; None if there is none.
    """

    def __init__(self, key: str | None) -> None:
        self._key = key
        self._wrong: dict[str, float] = {}

    def turn_away(self, address: str, query: Mapping[str, str], now: float | None = None) -> str:
        """Return why a browser is turned away for now; "" if it may come in, be its key right or wrong.

        Args:
            address: where it comes from.
            query: of its link.
            now: the clock [s].
        """
        if self._key is None or not query.get("key"):
            return ""
        now = monotonic() if now is None else now
        if now - self._wrong.get(address, -PERIOD) < PERIOD:
            return KEY_LATER
        if is_mistaken(self._key, query):
            self._wrong.pop(address, None)
            self._wrong[address] = now
            if len(self._wrong) > MOST:
                del self._wrong[next(iter(self._wrong))]
        return ""


def is_teacher(key: str | None, query: Mapping[str, str]) -> bool:
    """Return whether a link carries the key; nobody's does where there is none."""
    return key is not None and secrets.compare_digest(query.get("key", "").encode(), key.encode())


def is_mistaken(key: str | None, query: Mapping[str, str]) -> bool:
    """Return whether a link carries a key, but another one."""
    return key is not None and bool(query.get("key")) and not is_teacher(key, query)
