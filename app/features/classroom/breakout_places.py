"""Places for breakout sessions."""

from collections import Counter
from collections.abc import Iterable
from typing import Final

HOLD: Final = 60.0
"""Time for which a disconnected student's place is kept [s]."""


def group_size(students: int, places: int) -> int:
    return max(-(-students // max(places, 1)), 1)


class BreakoutPlaces:
    """Places by tab id. `most`: largest number of breakout sessions.

    A group has the id of its first student, and its members always return to it. With places for all, each
    student is a group.
    """

    def __init__(self, most: int) -> None:
        self.most = most
        self.groups: dict[str, str] = {}
        self._holders: dict[str, float] = {}

    @property
    def sizes(self) -> Counter[str]:
        return Counter(self.groups[student] for student in self._holders)

    def holds(self, student: str) -> bool:
        """Thread-safe."""
        return student in self._holders

    def members(self, group: str) -> tuple[str, ...]:
        """Includes absent students."""
        return tuple(student for student, own in self.groups.items() if own == group)

    def give(self, here: Iterable[str], now: float) -> None:
        """Free places after `HOLD`, then give places in this order. `now`: time [s]."""
        here = list(dict.fromkeys(here))
        for student in here:
            if student in self._holders:
                self._holders[student] = now
        for student, seen in list(self._holders.items()):
            if now - seen > HOLD:
                del self._holders[student]
        wanted = -(-len(here) // group_size(len(here), self.most))
        for student in here:
            if student not in self._holders:
                self.groups[student] = self._group_for(student, wanted)
                self._holders[student] = now

    def _group_for(self, student: str, wanted: int) -> str:
        sizes, before = self.sizes, self.groups.get(student, "")
        if before in sizes or (before and len(sizes) < self.most):
            return before
        if student in sizes or len(sizes) < wanted:
            return student
        return min(sizes, key=sizes.__getitem__)

    def take_all(self) -> None:
        self._holders.clear()
