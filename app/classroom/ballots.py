"""The answers and drawings of a class for the questions of the lessons: one of every student in every round, counted without names; and
where they come from."""

from collections.abc import Collection, Mapping
from typing import NamedTuple

from app.hosting.visitor_record import ClassRecord
from app.lessons.lesson import LAST, LessonBook
from app.lessons.tally import Ballot, QuestionId, Switch, Tally, switches_between, tally_of
from app.plots.curve_chart import Curve
from app.web.connection import FilteredConnection


class Counts(NamedTuple):
    """How a class has answered a question.

    Attributes:
        newest: counts of the newest round.
        first: those of the first one; None for a question that was not asked again.
        switches: how often each pair of answers was given, in the first round and in the newest one, by one student.
    """

    newest: Tally
    first: Tally | None = None
    switches: tuple[Switch, ...] = ()


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
        self._counts: dict[tuple[QuestionId, int], Counts] = {}

    @property
    def everything(self) -> tuple[dict[QuestionId, dict[str, Ballot]], tuple[QuestionId, ...]]:
        """Return a copy of all ballots of the newest rounds, and the questions that were revealed."""
        return {question: dict(ballots) for question, ballots in self._ballots.items()}, tuple(sorted(self._revealed))

    @property
    def earlier(self) -> dict[QuestionId, tuple[dict[str, Ballot], ...]]:
        """Return the ballots of the rounds before, oldest first."""
        return dict(self._earlier)

    def restore(self, record: ClassRecord) -> None:
        """Take up what `everything` and `earlier` have returned."""
        self._ballots = {question: dict(given) for question, given in record.ballots.items()}
        self._earlier = {question: tuple(map(dict, rounds)) for question, rounds in record.earlier.items()}
        self._revealed = set(record.revealed)
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

    def paired(
        self, book: LessonBook, own: Mapping[QuestionId, Mapping[str, int]]
    ) -> dict[QuestionId, tuple[tuple[int, int], ...]]:
        """Return question of a test that is asked before the lessons and after them → answers before and after of every student who gave
        both, without names and in no one's order.

        What counts is a student's first vote, and without one the answer in a session of their own. `own`: these, by question and student.
        """
        paired: dict[QuestionId, tuple[tuple[int, int], ...]] = {}

        def answers(question: QuestionId) -> dict[str, int]:
            voted = {student: ballot.choice for student, ballot in self.counted_rounds_of(question)[0].items()}
            return {**own.get(question, {}), **{student: choice for student, choice in voted.items() if choice is not None}}

        for lesson in book.lessons:
            for step in lesson.steps if lesson.asked == "first" else ():
                before, after = answers((lesson.id, step.id)), answers((lesson.id + LAST, step.id))
                both = sorted((before[student], after[student]) for student in before.keys() & after.keys())
                if both:
                    paired[lesson.id, step.id] = tuple(both)
        return paired

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

    def counts(self, question: QuestionId, choices: int, here: Collection[str]) -> Counts:
        """Return the counts of a question. `choices`: how many there are; `here`: the students who are present."""
        if (question, choices) not in self._counts:
            rounds = self.counted_rounds_of(question)
            counts = Counts(tally_of(rounds[-1], choices))
            if len(rounds) > 1:
                counts = Counts(counts.newest, tally_of(rounds[0], choices), switches_between(rounds[0], rounds[-1]))
            self._counts[question, choices] = counts
        known = self._counts[question, choices]
        waiting = len(set(here) - self._ballots.get(question, {}).keys() - self._left_out)
        return known._replace(newest=known.newest._replace(waiting=waiting))

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
