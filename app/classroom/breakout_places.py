"""Which students have a breakout session: as many at once as the machine carries, first come, first served."""

from collections.abc import Iterable
from typing import Final

HOLD: Final = 60.0
"""How long a place is held for a student who has disconnected, as in a reload [s]."""


class BreakoutPlaces:
    """The breakout sessions that a class may have, by the id of each student's tab. `most`: how many at once."""

    def __init__(self, most: int) -> None:
        self.most = most
        self._holders: dict[str, float] = {}

    @property
    def taken(self) -> int:
        return len(self._holders)

    def holds(self, student: str) -> bool:
        """Return whether a student has a place; from any thread."""
        return student in self._holders

    def give(self, here: Iterable[str], now: float) -> None:
        """Give the free places to the present students in this order, after taking those of students who are gone for `HOLD`.

        Args:
            now: the clock [s].
        """
        here = list(dict.fromkeys(here))
        for student in here:
            if student in self._holders:
                self._holders[student] = now
        for student, seen in list(self._holders.items()):
            if now - seen > HOLD:
                del self._holders[student]
        for student in here:
            if len(self._holders) >= self.most:
                return
            self._holders.setdefault(student, now)

    def take_all(self) -> None:
        self._holders.clear()
