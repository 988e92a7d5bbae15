"""The teacher's key: a page opened with `?key=KEY` is the teacher's."""

import secrets
from collections.abc import Callable, Mapping
from time import monotonic
from typing import Final

from app.web.index_page import KEY_LATER
from controllers.errors import BadSetting

AUTO: Final = "auto"
"""In place of a key: a random one is made."""

SHORTEST: Final = 8
"""Shortest key [characters]."""

PERIOD: Final = 1.0
"""Least time between a wrong key and the next key that is checked, from one address [s]."""

MOST_ADDRESSES: Final = 1000
"""Addresses of wrong keys that are remembered."""


def chosen_key(asked: str | None) -> str | None:
    """Return the key of a server; a random one for "auto".

    Raises:
        BadSetting: the key is too short.
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
    """Lets every address try one wrong key a second; until then no key from there is checked. Behind a proxy all share one address.

    Belongs to the network's thread.

    Args:
        key: the teacher's; None if there is none.
        clock: returns the time [s].
    """

    def __init__(self, key: str | None, clock: Callable[[], float] = monotonic) -> None:
        self._key, self._clock = key, clock
        self._wrong: dict[str, float] = {}

    def turn_away(self, address: str, query: Mapping[str, str]) -> str:
        """Return why a browser is turned away for now; "" if it may come in, with a right or a wrong key."""
        if self._key is None or not query.get("key"):
            return ""
        now = self._clock()
        if now - self._wrong.get(address, -PERIOD) < PERIOD:
            return KEY_LATER
        if is_mistaken(self._key, query):
            self._wrong.pop(address, None)
            self._wrong[address] = now
            if len(self._wrong) > MOST_ADDRESSES:
                del self._wrong[next(iter(self._wrong))]
        return ""


def is_teacher(key: str | None, query: Mapping[str, str]) -> bool:
    """Return whether a link carries the key; none does where there is no key."""
    return key is not None and secrets.compare_digest(query.get("key", "").encode(), key.encode())


def is_mistaken(key: str | None, query: Mapping[str, str]) -> bool:
    """Return whether a link carries a wrong key."""
    return key is not None and bool(query.get("key")) and not is_teacher(key, query)
