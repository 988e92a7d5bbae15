"""Which students have a breakout session: one each while the machine can run them, and otherwise one for every group."""

from collections import Counter
from collections.abc import Iterable
from typing import Final

HOLD: Final = 60.0
"""How long a place is held for a student who has disconnected, as in a reload [s]."""


def group_size(students: int, places: int) -> int:
    """Number of students who share a breakout session, at least one."""
    return max(-(-students // max(places, 1)), 1)


class BreakoutPlaces:
    """The breakout sessions that a class may have, by the id of each student's tab. `most`: how many at once.

    A group has the id of the student who was the first in it. Who was in a group comes back to it, also the next time.

    Attributes:
        groups: the group of every student who has had a place; with a place for everybody each is a group.
    """

    def __init__(self, most: int) -> None:
        self.most = most
        self.groups: dict[str, str] = {}
        self._holders: dict[str, float] = {}

    @property
    def sizes(self) -> Counter[str]:
        """How many students of each group have a place; every group has a session."""
        return Counter(self.groups[student] for student in self._holders)

    def holds(self, student: str) -> bool:
        """True if a student has a place; from any thread."""
        return student in self._holders

    def members(self, group: str) -> tuple[str, ...]:
        """Return the students of a group, also those who are away."""
        return tuple(student for student, own in self.groups.items() if own == group)

    def give(self, here: Iterable[str], now: float) -> None:
        """Give places to the present students in this order, after taking those of students who are gone for `HOLD`.

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
        """Return a newcomer's group: the one before, a new one while fewer are there than wanted, or the smallest."""
        sizes, before = self.sizes, self.groups.get(student, "")
        if before in sizes or (before and len(sizes) < self.most):
            return before
        if student in sizes or len(sizes) < wanted:
            return student
        return min(sizes, key=sizes.__getitem__)

    def take_all(self) -> None:
        self._holders.clear()
