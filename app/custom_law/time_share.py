"""How much of a frame the server waits for custom laws."""

from time import monotonic
from typing import Final

SHARE: Final = 0.4
"""Part of the wall time that the frame thread waits for all custom laws together."""

_LATELY: Final = 0.5
"""Time after which a law that was not called does not count any more [s]."""


class LawTimeShare:
    """`SHARE` in equal parts, one for every session that calls a custom law."""

    def __init__(self) -> None:
        self._called: dict[int, float] = {}

    def part(self, session: int) -> float:
        """Return the part of the wall time that one session's law has. `session`: any number of its own; its law is called now."""
        now = monotonic()
        self._called[session] = now
        self._called = {one: when for one, when in self._called.items() if now - when < _LATELY}
        return SHARE / len(self._called)
