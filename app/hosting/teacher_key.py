"""The teacher's key, from a link with `?key=KEY`."""

import secrets
from collections.abc import Callable, Mapping
from time import monotonic
from typing import Final

from app.web.traffic_limits import Allowance, remember
from controllers.errors import BadSetting

AUTO: Final = "auto"

SHORTEST: Final = 12
"""Shortest key [characters]: guesses can be as fast as the network."""

PERIOD: Final = 1.0
"""Time between answers to wrong keys from one address [s]."""

LONGEST: Final = 5.0
"""Longest delay [s]; the library gives a request 10 s."""

MOST_ADDRESSES: Final = 1000


def chosen_key(asked: str | None) -> str | None:
    """Key of a server; random for "auto".

    Raises:
        BadSetting: too short.
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
    """Delays answers to wrong keys, one `PERIOD` after the other from one address; the right key never waits,
    as a guessing student behind a proxy has the teacher's address. Network thread only.
    """

    def __init__(self, key: str | None, clock: Callable[[], float] = monotonic) -> None:
        self._key, self._clock = key, clock
        self._wrong: dict[str, Allowance] = {}

    def delay(self, address: str, query: Mapping[str, str]) -> float:
        """Delay of an answer [s]."""
        if not is_mistaken(self._key, query):
            return 0.0
        answers = self._wrong.get(address) or Allowance(1.0 / PERIOD, 0.0)
        remember(self._wrong, address, answers, MOST_ADDRESSES)
        return min(answers.spend(1.0, self._clock()), LONGEST)


def is_teacher(key: str | None, query: Mapping[str, str]) -> bool:
    return key is not None and secrets.compare_digest(query.get("key", "").encode(), key.encode())


def is_mistaken(key: str | None, query: Mapping[str, str]) -> bool:
    return key is not None and bool(query.get("key")) and not is_teacher(key, query)
