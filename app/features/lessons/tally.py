"""Counts of a class's answers."""

from collections import Counter
from collections.abc import Mapping
from typing import NamedTuple

from app.plots.curve_chart import Curve

QuestionId = tuple[str, str]


class Ballot(NamedTuple):
    choice: int | None = None
    curve: Curve = ()
    reason: str = ""


class Tally(NamedTuple):
    """Counts of a class. `waiting`: present students without an answer or a curve."""

    counts: tuple[int, ...]
    waiting: int
    handed_in: int
    curves: tuple[Curve, ...] = ()

    @property
    def answered(self) -> int:
        return sum(self.counts)

    @property
    def favourites(self) -> tuple[int, ...]:
        """Most frequent choices; () without an answer."""
        most = max(self.counts, default=0)
        return tuple(i for i, count in enumerate(self.counts) if count == most) if most else ()

    @property
    def favourite(self) -> int | None:
        """First of `favourites`."""
        return next(iter(self.favourites), None)

    def share(self, choice: int) -> int | None:
        """Share of the answers [%]; None without an answer."""
        return round(100.0 * self.counts[choice] / self.answered) if self.answered else None


class Switch(NamedTuple):
    """`students` answered `before`, and `after` in a later round."""

    before: int
    after: int
    students: int


def tally_of(ballots: Mapping[str, Ballot], choices: int) -> Tally:
    """Count one round, `ballots` by student; `waiting` becomes 0."""
    counts = [0] * choices
    for choice, *_ in ballots.values():
        if choice is not None and choice < choices:
            counts[choice] += 1
    curves = tuple(ballot.curve for ballot in ballots.values() if ballot.curve)
    return Tally(tuple(counts), 0, len(ballots), curves)


def switches_between(before: Mapping[str, Ballot], after: Mapping[str, Ballot]) -> tuple[Switch, ...]:
    pairs = Counter[tuple[int, int]]()
    for student in before.keys() & after.keys():
        old, new = before[student].choice, after[student].choice
        if old is not None and new is not None:
            pairs[old, new] += 1
    return tuple(Switch(*pair, count) for pair, count in sorted(pairs.items()))
