"""The teacher's key: a page opened with `?key=KEY` is the teacher's."""

import secrets
from collections.abc import Callable, Mapping
from time import monotonic
from typing import Final

from app.web.traffic_limits import Allowance, remember
from controllers.errors import BadSetting

AUTO: Final = "auto"

SHORTEST: Final = 12
"""Shortest key [characters]: an attacker who does not wait for answers may guess as fast as the network
allows."""

PERIOD: Final = 1.0
"""Time between the answers to two wrong keys from one address [s]."""

LONGEST: Final = 5.0
"""Longest wait for an answer to a wrong key [s]; the library gives a request 10 s."""

MOST_ADDRESSES: Final = 1000


def chosen_key(asked: str | None) -> str | None:
    """Key of a server; a random one for "auto".

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
    """Delays answers to wrong keys, one `PERIOD` after the other from one address, each on its own
    connection. The right key never waits: behind a proxy a guessing student has the teacher's address.
    Belongs to the network's thread.

    Args:
        clock: time [s].
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
