"""How a class has answered a question, without names: the counts of a round, and who changed the answer from one round to another."""

from collections import Counter
from collections.abc import Mapping
from typing import NamedTuple

from app.plots.curve_chart import Curve

QuestionId = tuple[str, str]
"""Names of the lesson and the step of a question."""


class Ballot(NamedTuple):
    """What a student has handed in: an answer, a curve that was drawn, or both; and the student's reason."""

    choice: int | None = None
    curve: Curve = ()
    reason: str = ""


class Tally(NamedTuple):
    """How a class has answered.

    Attributes:
        counts: of every choice.
        waiting: how many of the present students have handed in nothing.
        handed_in: how many have handed in an answer or a curve.
        curves: that were drawn, without names.
    """

    counts: tuple[int, ...]
    waiting: int
    handed_in: int
    curves: tuple[Curve, ...] = ()

    @property
    def answered(self) -> int:
        """How many have chosen an answer."""
        return sum(self.counts)

    @property
    def favourites(self) -> tuple[int, ...]:
        """The most frequent choice, or all of a tie; () without an answer."""
        most = max(self.counts, default=0)
        return tuple(i for i, count in enumerate(self.counts) if count == most) if most else ()

    @property
    def favourite(self) -> int | None:
        """The most frequent choice, the first of a tie; None without an answer."""
        return next(iter(self.favourites), None)

    def share(self, choice: int) -> int | None:
        """Return the share of a choice among the answers [%]; None without an answer."""
        return round(100.0 * self.counts[choice] / self.answered) if self.answered else None


class Switch(NamedTuple):
    """`students` answered `before` in one round and `after` in a later one."""

    before: int
    after: int
    students: int


def tally_of(ballots: Mapping[str, Ballot], choices: int) -> Tally:
    """Return the counts of one round, with none who waits. `ballots`: by student; `choices`: how many there are."""
    counts = [0] * choices
    for choice, *_ in ballots.values():
        if choice is not None and choice < choices:
            counts[choice] += 1
    curves = tuple(ballot.curve for ballot in ballots.values() if ballot.curve)
    return Tally(tuple(counts), 0, len(ballots), curves)


def switches_between(before: Mapping[str, Ballot], after: Mapping[str, Ballot]) -> tuple[Switch, ...]:
    """Count of each pair of answers that one student gave in two rounds."""
    pairs = Counter[tuple[int, int]]()
    for student in before.keys() & after.keys():
        old, new = before[student].choice, after[student].choice
        if old is not None and new is not None:
            pairs[old, new] += 1
    return tuple(Switch(*pair, count) for pair, count in sorted(pairs.items()))
