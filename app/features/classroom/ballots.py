"""The answers and drawings of a class for the questions of the lessons: one of every student in every round, counted without names; and
where they come from."""

from collections.abc import Collection, Mapping
from typing import NamedTuple

from app.features.classroom.class_record import NEW_CLASS, ClassRecord
from app.features.lessons.lesson import LAST, LessonBook
from app.features.lessons.tally import Ballot, QuestionId, Switch, Tally, switches_between, tally_of
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


class VoterCount(NamedTuple):
    """How many votes a round has, from how many addresses, and how many of them without a page."""

    votes: int = 0
    addresses: int = 0
    pageless: int = 0


class Ballots:
    """The answers of a class to every question so far, by the id of each student's tab, and where they come from; an answer outlives its
    student's connection.

    A question that is asked again begins a new round; the ballots of earlier rounds stay as they are. Addresses stay in memory; behind a
    proxy all students share one.

    Args:
        record: of the class, which goes on from there.

    Attributes:
        revealed: the questions with a tally that everybody sees.
        pages_only: whether votes without a page are left out of every count.
        pageless: the students without a page.
    """

    def __init__(self, record: ClassRecord = NEW_CLASS) -> None:
        self._rounds = {
            question: [*map(dict, record.earlier.get(question, ())), dict(record.ballots.get(question, {}))]
            for question in {**record.earlier, **record.ballots}
        }
        self.revealed = set(record.revealed)
        self.pages_only, self.pageless = record.pages_only, set(record.pageless)
        self._addresses: dict[str, str] = {}
        # Every page of a class asks for the counts in every frame; they change with an answer.
        self._counts: dict[tuple[QuestionId, int], Counts] = {}

    @property
    def rounds(self) -> dict[QuestionId, tuple[dict[str, Ballot], ...]]:
        """Return a copy of the ballots of every question and round, oldest first."""
        return {question: tuple(map(dict, rounds)) for question, rounds in self._rounds.items()}

    @property
    def questions(self) -> tuple[QuestionId, ...]:
        """Return every question that was answered, in the order in which that was."""
        return tuple(question for question, rounds in self._rounds.items() if any(rounds))

    def rounds_of(self, question: QuestionId) -> tuple[dict[str, Ballot], ...]:
        """Return the ballots of every round, oldest first; the last one is open until the reveal."""
        return tuple(self._rounds.get(question, ({},)))

    def counted_rounds_of(self, question: QuestionId) -> tuple[dict[str, Ballot], ...]:
        """Return `rounds_of` a question without the ballots that are left out."""
        rounds, left_out = self.rounds_of(question), self._left_out
        return tuple({one: ballot for one, ballot in given.items() if one not in left_out} for given in rounds)

    @property
    def _left_out(self) -> Collection[str]:
        """The students who are left out of every count."""
        return self.pageless if self.pages_only else ()

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

    def count_pages_only(self, pages_only: bool) -> None:
        """Leave votes without a page out of every count, or count them again; they are kept."""
        self.pages_only = pages_only
        self._counts.clear()

    def note(self, student: str, origin: FilteredConnection) -> None:
        """Note where a student comes from now."""
        self._addresses[student] = origin.address
        if origin.is_page:
            self.pageless.discard(student)
        else:
            self.pageless.add(student)
        self._counts.clear()

    def voters_of(self, question: QuestionId) -> VoterCount:
        """Source of the votes of the newest round."""
        students = self.rounds_of(question)[-1].keys()
        addresses = {self._addresses[student] for student in students if student in self._addresses}
        return VoterCount(len(students), len(addresses), len(students & self.pageless))

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
        if question in self.revealed:
            return False
        ballots = self._rounds.setdefault(question, [{}])[-1]
        if ballot._replace(reason="") == Ballot():
            ballots.pop(student, None)
        else:
            # In the order of arrival, also after a change.
            ballots[student] = ballot
        self._counts.clear()
        return True

    def ballot_of(self, question: QuestionId, student: str) -> Ballot:
        return self.rounds_of(question)[-1].get(student, Ballot())

    def first_ballot_of(self, question: QuestionId, student: str) -> Ballot:
        """First hand-in of a student to a question that was asked again."""
        first, *later = self.rounds_of(question)
        return first.get(student, Ballot()) if later else Ballot()

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
        waiting = len(set(here).difference(self.rounds_of(question)[-1], self._left_out))
        return known._replace(newest=known.newest._replace(waiting=waiting))

    def reveal(self, question: QuestionId) -> None:
        """Show the tally to everybody; from now on no answer changes."""
        self.revealed.add(question)

    def ask_again(self, question: QuestionId) -> None:
        """Begin a new round of a question; the ballots so far are kept as a round of their own."""
        rounds = self._rounds.setdefault(question, [{}])
        if rounds[-1]:
            rounds.append({})
        self.revealed.discard(question)
        self._counts.clear()
