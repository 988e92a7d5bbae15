"""The answers and drawings of a class for the questions of the lessons: one of every student in every round, counted without names."""

from collections.abc import Callable, Collection, Mapping
from typing import Any, TypeVar

from app.lessons.tally import Ballot, QuestionId, Switch, Tally, switches_between, tally_of
from app.plots.curve_chart import Curve

T = TypeVar("T")

Round = Mapping[str, tuple[int | None, Curve]]
"""Choice and curve by the id of a student's tab."""


class Ballots:
    """The answers of a class to every question so far, by the id of each student's tab; an answer outlives its student's connection.

    A question that is asked again begins a new round; the ballots of earlier rounds stay as they are.
    """

    def __init__(self) -> None:
        self._ballots: dict[QuestionId, dict[str, Ballot]] = {}
        self._earlier: dict[QuestionId, tuple[dict[str, Ballot], ...]] = {}
        self._revealed: set[QuestionId] = set()
        # Every page of a class asks for the counts in every frame; they change with an answer.
        self._counts: dict[tuple[str, QuestionId, int], Any] = {}

    @property
    def everything(self) -> tuple[dict[QuestionId, dict[str, Ballot]], tuple[QuestionId, ...]]:
        """Return a copy of all ballots of the newest rounds, and the questions that were revealed."""
        return {question: dict(ballots) for question, ballots in self._ballots.items()}, tuple(sorted(self._revealed))

    @property
    def earlier(self) -> dict[QuestionId, tuple[dict[str, Ballot], ...]]:
        """Return the ballots of the rounds before, oldest first."""
        return dict(self._earlier)

    def restore(
        self,
        ballots: Mapping[QuestionId, Round],
        revealed: Collection[QuestionId],
        earlier: Mapping[QuestionId, tuple[Round, ...]],
    ) -> None:
        """Take up what `everything` and `earlier` have returned."""
        self._ballots = {question: _read(given) for question, given in ballots.items()}
        self._earlier = {question: tuple(map(_read, rounds)) for question, rounds in earlier.items()}
        self._revealed = set(revealed)
        self._counts.clear()

    @property
    def questions(self) -> tuple[QuestionId, ...]:
        """Return every question that was answered, in the order in which that was."""
        return tuple(dict.fromkeys((*self._earlier, *(question for question, given in self._ballots.items() if given))))

    def rounds_of(self, question: QuestionId) -> tuple[dict[str, Ballot], ...]:
        """Return the ballots of every round, oldest first; the last one is open until the reveal."""
        return (*self._earlier.get(question, ()), self._ballots.get(question, {}))

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
        self._counts.clear()
        return True

    def _counted(self, kind: str, question: QuestionId, choices: int, count: Callable[[], T]) -> T:
        """Return what `count` returns, which is called once after every change."""
        key = kind, question, choices
        if key not in self._counts:
            self._counts[key] = count()
        return self._counts[key]

    def ballot_of(self, question: QuestionId, student: str) -> Ballot:
        return self._ballots.get(question, {}).get(student, Ballot())

    def first_ballot_of(self, question: QuestionId, student: str) -> Ballot:
        """Return what a student handed in when the question was asked for the first time, if it was asked again."""
        rounds = self._earlier.get(question)
        return rounds[0].get(student, Ballot()) if rounds else Ballot()

    def ballots_of(self, student: str) -> dict[QuestionId, Ballot]:
        """Return a student's newest ballot on every question."""
        found: dict[QuestionId, Ballot] = {}
        for question in self.questions:
            for ballots in self.rounds_of(question):
                if student in ballots:
                    found[question] = ballots[student]
        return found

    def tally(self, question: QuestionId, choices: int, here: Collection[str]) -> Tally:
        """Return the counts of the newest round. `choices`: how many there are; `here`: the students who are present."""
        ballots = self._ballots.get(question, {})
        counts = self._counted("newest", question, choices, lambda: tally_of(ballots, choices))
        return counts._replace(waiting=len(set(here) - ballots.keys()))

    def first_tally(self, question: QuestionId, choices: int) -> Tally | None:
        """Return the counts of the first round; None for a question that was not asked again."""
        rounds = self._earlier.get(question)
        return self._counted("first", question, choices, lambda: tally_of(rounds[0], choices)) if rounds else None

    def switches(self, question: QuestionId) -> tuple[Switch, ...]:
        """Return how often each pair of answers was given, in the first round and in the newest one, by one student."""
        first, *others = self.rounds_of(question)
        return self._counted("switches", question, 0, lambda: switches_between(first, others[-1])) if others else ()

    def reveal(self, question: QuestionId) -> None:
        """Show the tally to everybody; from now on no answer changes."""
        self._revealed.add(question)

    def revealed(self, question: QuestionId) -> bool:
        """Return whether everybody sees the tally."""
        return question in self._revealed

    def ask_again(self, question: QuestionId) -> None:
        """Begin a new round of a question; the ballots so far are kept as a round of their own."""
        ballots = self._ballots.pop(question, None)
        if ballots:
            self._earlier[question] = (*self._earlier.get(question, ()), ballots)
        self._revealed.discard(question)
        self._counts.clear()


def _read(ballots: Round) -> dict[str, Ballot]:
    return {student: Ballot(*one) for student, one in ballots.items()}
