"""The answers and drawings of a class for the questions of the lessons: one of every student, counted without names."""

from collections.abc import Collection, Mapping
from typing import NamedTuple

from app.plots.curve_chart import Curve

QuestionId = tuple[str, str]
"""Names of the lesson and the step of a question."""


class Ballot(NamedTuple):
    """What a student has handed in: an answer, a curve that was drawn, or both."""

    choice: int | None = None
    curve: Curve = ()


class Tally(NamedTuple):
    """How a class has answered.

    Attributes:
        counts: of every choice.
        waiting: how many of the present students have handed in nothing.
        answered: how many have handed in an answer or a curve.
        curves: that were drawn, without names.
    """

    counts: tuple[int, ...]
    waiting: int
    answered: int
    curves: tuple[Curve, ...] = ()

    @property
    def favourite(self) -> int | None:
        """The most frequent choice, the first of several; None without an answer."""
        return self.counts.index(max(self.counts)) if any(self.counts) else None


class Ballots:
    """The answers of a class to every question so far, by the id of each student's tab; an answer outlives its student's connection."""

    def __init__(self) -> None:
        self._ballots: dict[QuestionId, dict[str, Ballot]] = {}
        self._revealed: set[QuestionId] = set()

    @property
    def everything(self) -> tuple[dict[QuestionId, dict[str, Ballot]], tuple[QuestionId, ...]]:
        """Return a copy of all ballots, and the questions that were revealed."""
        return {question: dict(ballots) for question, ballots in self._ballots.items()}, tuple(sorted(self._revealed))

    def restore(
        self, ballots: Mapping[QuestionId, Mapping[str, tuple[int | None, Curve]]], revealed: Collection[QuestionId]
    ) -> None:
        """Take up what `everything` has returned."""
        self._ballots = {q: {student: Ballot(*one) for student, one in given.items()} for q, given in ballots.items()}
        self._revealed = set(revealed)

    def answer(self, question: QuestionId, student: str, choice: int) -> bool:
        """Take an answer instead of an earlier one; return whether it was taken: not after the reveal."""
        return choice >= 0 and self._put(question, student, self.ballot_of(question, student)._replace(choice=choice))

    def draw(self, question: QuestionId, student: str, curve: Curve) -> bool:
        """Take a curve instead of an earlier one, () for none; return whether it was taken: not after the reveal."""
        return self._put(question, student, self.ballot_of(question, student)._replace(curve=curve))

    def _put(self, question: QuestionId, student: str, ballot: Ballot) -> bool:
        if question in self._revealed:
            return False
        ballots = self._ballots.setdefault(question, {})
        ballots.pop(student, None)
        if ballot != Ballot():
            ballots[student] = ballot
        return True

    def ballot_of(self, question: QuestionId, student: str) -> Ballot:
        return self._ballots.get(question, {}).get(student, Ballot())

    def ballots_of(self, student: str) -> dict[QuestionId, Ballot]:
        return {question: ballots[student] for question, ballots in self._ballots.items() if student in ballots}

    def tally(self, question: QuestionId, choices: int, here: Collection[str]) -> Tally:
        """Return the counts of a question. `choices`: how many there are; `here`: the students who are present."""
        ballots, counts = self._ballots.get(question, {}), [0] * choices
        for choice, _ in ballots.values():
            if choice is not None and choice < choices:
                counts[choice] += 1
        curves = tuple(ballot.curve for ballot in ballots.values() if ballot.curve)
        return Tally(tuple(counts), len(set(here) - set(ballots)), len(ballots), curves)

    def reveal(self, question: QuestionId) -> None:
        """Show the tally to everybody; from now on no answer changes."""
        self._revealed.add(question)

    def revealed(self, question: QuestionId) -> bool:
        """Return whether everybody sees the tally."""
        return question in self._revealed

    def ask_again(self, question: QuestionId) -> None:
        """Delete all answers and ask the question again."""
        self._ballots.pop(question, None)
        self._revealed.discard(question)
