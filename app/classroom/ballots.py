"""The answers and drawings of a class for the questions of the lessons: one of every student in every round, counted without names; and
where they come from."""

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, NamedTuple, TypeVar

from app.lessons.tally import Ballot, QuestionId, Switch, Tally, switches_between, tally_of
from app.plots.curve_chart import Curve
from app.web.connection import FilteredConnection

T = TypeVar("T")

Round = Mapping[str, Ballot]
"""By the id of a student's tab."""


class Ballots:
    """The answers of a class to every question so far, by the id of each student's tab; an answer outlives its student's connection.

    A question that is asked again begins a new round; the ballots of earlier rounds stay as they are.
    """

    def __init__(self) -> None:
        self._ballots: dict[QuestionId, dict[str, Ballot]] = {}
        self._earlier: dict[QuestionId, tuple[dict[str, Ballot], ...]] = {}
        self._revealed: set[QuestionId] = set()
        self._left_out: frozenset[str] = frozenset()
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

    def counted_rounds_of(self, question: QuestionId) -> tuple[dict[str, Ballot], ...]:
        """Return `rounds_of` a question without the ballots that are left out."""
        rounds, left_out = self.rounds_of(question), self._left_out
        return tuple({one: ballot for one, ballot in given.items() if one not in left_out} for given in rounds)

    def leave_out(self, students: frozenset[str]) -> None:
        """Count the ballots of all but these students; theirs are kept."""
        if students != self._left_out:
            self._left_out = students
            self._counts.clear()

    def answer(self, question: QuestionId, student: str, choice: int) -> bool:
        """Take an answer instead of an earlier one; return whether it was taken: not after the reveal."""
        return choice >= 0 and self._put(question, student, self.ballot_of(question, student)._replace(choice=choice))

    def draw(self, question: QuestionId, student: str, curve: Curve) -> bool:
        """Take a curve instead of an earlier one, () for none; return whether it was taken: not after the reveal."""
        return self._put(question, student, self.ballot_of(question, student)._replace(curve=curve))

    def give_reason(self, question: QuestionId, student: str, reason: str) -> None:
        """Take the reason of an answer or a curve that was handed in, instead of an earlier one; not after the reveal."""
        ballot = self.ballot_of(question, student)
        if ballot._replace(reason="") != Ballot():
            self._put(question, student, ballot._replace(reason=reason))

    def reasons(self, question: QuestionId) -> dict[int, tuple[int | None, str]]:
        """Return answer and reason of all who have given one in the newest round, by the number of the ballot, from 1."""
        counted = enumerate(self.counted_rounds_of(question)[-1].values(), 1)
        return {number: (ballot.choice, ballot.reason) for number, ballot in counted if ballot.reason}

    def _put(self, question: QuestionId, student: str, ballot: Ballot) -> bool:
        if question in self._revealed:
            return False
        ballots = self._ballots.setdefault(question, {})
        if ballot._replace(reason="") == Ballot():
            ballots.pop(student, None)
        else:
            # In the order of arrival, also after a change.
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
        counts = self._counted("newest", question, choices, lambda: tally_of(self.counted_rounds_of(question)[-1], choices))
        return counts._replace(waiting=len(set(here) - self._ballots.get(question, {}).keys() - self._left_out))

    def first_tally(self, question: QuestionId, choices: int) -> Tally | None:
        """Return the counts of the first round; None for a question that was not asked again."""
        if question not in self._earlier:
            return None
        return self._counted("first", question, choices, lambda: tally_of(self.counted_rounds_of(question)[0], choices))

    def switches(self, question: QuestionId) -> tuple[Switch, ...]:
        """Return how often each pair of answers was given, in the first round and in the newest one, by one student."""
        first, *others = self.counted_rounds_of(question)
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


class VoterCount(NamedTuple):
    """How many votes a round has, from how many addresses, and how many of them without a page."""

    votes: int = 0
    addresses: int = 0
    pageless: int = 0


class Voters:
    """Knows where the students of a class come from. Addresses stay in memory; behind a proxy all students share one.

    Attributes:
        pages_only: whether votes without a page are left out of every count.
        pageless: the students without a page.
    """

    def __init__(self) -> None:
        self.pages_only = False
        self.pageless: set[str] = set()
        self._addresses: dict[str, str] = {}

    def restore(self, pages_only: bool, pageless: Iterable[str]) -> None:
        self.pages_only, self.pageless = pages_only, set(pageless)

    def note(self, student: str, origin: FilteredConnection) -> None:
        """Note where a student comes from now."""
        self._addresses[student] = origin.address
        (self.pageless.discard if origin.is_page else self.pageless.add)(student)

    @property
    def left_out(self) -> frozenset[str]:
        """The students who are left out of every count."""
        return frozenset(self.pageless if self.pages_only else ())

    def count(self, students: Collection[str]) -> VoterCount:
        """Return where the votes of a round come from. `students`: who have voted."""
        addresses = {self._addresses[student] for student in students if student in self._addresses}
        return VoterCount(len(students), len(addresses), sum(student in self.pageless for student in students))
