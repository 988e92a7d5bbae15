"""Places for breakout sessions: one a student if possible, otherwise one a group."""

from collections import Counter
from collections.abc import Iterable
from typing import Final

HOLD: Final = 60.0
"""Time for which a disconnected student's place is kept, as in a reload [s]."""


def group_size(students: int, places: int) -> int:
    """Number of students per breakout session, at least one."""
    return max(-(-students // max(places, 1)), 1)


class BreakoutPlaces:
    """Breakout sessions of a class, by tab id. `most`: their largest number.

    A group has the id of its first student. Its members return to it, also the next time.

    Attributes:
        groups: group of every student who has had a place; with places for all, each student is a group.
    """

    def __init__(self, most: int) -> None:
        self.most = most
        self.groups: dict[str, str] = {}
        self._holders: dict[str, float] = {}

    @property
    def sizes(self) -> Counter[str]:
        """Number of students with a place in each group; every group has a session."""
        return Counter(self.groups[student] for student in self._holders)

    def holds(self, student: str) -> bool:
        """True if a student has a place; from any thread."""
        return student in self._holders

    def members(self, group: str) -> tuple[str, ...]:
        """Students of a group, including absent ones."""
        return tuple(student for student, own in self.groups.items() if own == group)

    def give(self, here: Iterable[str], now: float) -> None:
        """Give places in this order, after freeing those of students absent for `HOLD`.

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
        wanted = -(-len(here) // group_size(len(here), self.most))
        for student in here:
            if student not in self._holders:
                self.groups[student] = self._group_for(student, wanted)
                self._holders[student] = now

    def _group_for(self, student: str, wanted: int) -> str:
        """A newcomer's group: the previous one, a new one while there are fewer than `wanted`, or the
        smallest.
        """
        sizes, before = self.sizes, self.groups.get(student, "")
        if before in sizes or (before and len(sizes) < self.most):
            return before
        if student in sizes or len(sizes) < wanted:
            return student
        return min(sizes, key=sizes.__getitem__)

    def take_all(self) -> None:
        self._holders.clear()
