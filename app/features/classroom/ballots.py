"""Answers and drawings of a class."""

from collections.abc import Collection, Mapping
from typing import NamedTuple

from app.features.classroom.class_record import NEW_CLASS, ClassRecord
from app.features.lessons.lesson import LAST, LessonBook
from app.features.lessons.tally import Ballot, QuestionId, Switch, Tally, switches_between, tally_of
from app.plots.curve_chart import Curve
from app.web.connection import FilteredConnection


class Counts(NamedTuple):
    """Counts of a question. `first`: None if there is one round; `switches`: from the first to the last
    round.
    """

    newest: Tally
    first: Tally | None = None
    switches: tuple[Switch, ...] = ()


class VoterCount(NamedTuple):
    """Votes of a round, their addresses, and votes without a page."""

    votes: int = 0
    addresses: int = 0
    pageless: int = 0


class Ballots:
    """All answers of a class by tab id.

    A repeated question begins a new round. Addresses are not saved; students behind a proxy share one.
    `pages_only`: ignore votes without a page.
    """

    def __init__(self, record: ClassRecord = NEW_CLASS) -> None:
        self._rounds = {
            question: [*map(dict, record.earlier.get(question, ())), dict(record.ballots.get(question, {}))]
            # In the order of the first answers.
            for question in {**record.ballots, **record.earlier}
        }
        self.revealed = set(record.revealed)
        self.pages_only, self.pageless = record.pages_only, set(record.pageless)
        self._addresses: dict[str, str] = {}
        # Every page of a class asks for the counts in every frame; they change with an answer.
        self._counts: dict[tuple[QuestionId, int], Counts] = {}

    @property
    def rounds(self) -> dict[QuestionId, tuple[dict[str, Ballot], ...]]:
        """Copy of all ballots, oldest round first."""
        return {question: tuple(map(dict, rounds)) for question, rounds in self._rounds.items()}

    @property
    def questions(self) -> tuple[QuestionId, ...]:
        """In the order of the first answers."""
        return tuple(question for question, rounds in self._rounds.items() if any(rounds))

    def rounds_of(self, question: QuestionId) -> tuple[dict[str, Ballot], ...]:
        """Oldest round first; the last one is open until the reveal."""
        return tuple(self._rounds.get(question, ({},)))

    def counted_rounds_of(self, question: QuestionId) -> tuple[dict[str, Ballot], ...]:
        rounds, left_out = self.rounds_of(question), self._left_out
        return tuple(
            {one: ballot for one, ballot in given.items() if one not in left_out} for given in rounds
        )

    @property
    def _left_out(self) -> Collection[str]:
        return self.pageless if self.pages_only else ()

    def paired(
        self, book: LessonBook, own: Mapping[QuestionId, Mapping[str, int]]
    ) -> dict[QuestionId, tuple[tuple[int, int], ...]]:
        """Sorted (before, after) of each student for every repeated question, without names.

        `own`: answers that count for students without a vote.
        """
        paired: dict[QuestionId, tuple[tuple[int, int], ...]] = {}

        def answers(question: QuestionId) -> dict[str, int]:
            voted = {
                student: ballot.choice for student, ballot in self.counted_rounds_of(question)[0].items()
            }
            return {
                **own.get(question, {}),
                **{student: choice for student, choice in voted.items() if choice is not None},
            }

        for lesson in book.lessons:
            for step in lesson.steps if lesson.asked == "first" else ():
                before, after = answers((lesson.id, step.id)), answers((lesson.id + LAST, step.id))
                both = sorted((before[student], after[student]) for student in before.keys() & after.keys())
                if both:
                    paired[lesson.id, step.id] = tuple(both)
        return paired

    def count_pages_only(self, pages_only: bool) -> None:
        self.pages_only = pages_only
        self._counts.clear()

    def note(self, student: str, origin: FilteredConnection) -> None:
        self._addresses[student] = origin.address
        if origin.is_page:
            self.pageless.discard(student)
        else:
            self.pageless.add(student)
        self._counts.clear()

    def voters_of(self, question: QuestionId) -> VoterCount:
        students = self.rounds_of(question)[-1].keys()
        addresses = {self._addresses[student] for student in students if student in self._addresses}
        return VoterCount(len(students), len(addresses), len(students & self.pageless))

    def answer(self, question: QuestionId, student: str, choice: int) -> bool:
        """False after the reveal."""
        return choice >= 0 and self._put(
            question, student, self.ballot_of(question, student)._replace(choice=choice)
        )

    def draw(self, question: QuestionId, student: str, curve: Curve) -> bool:
        """Record a curve; () removes it. False after the reveal."""
        return self._put(question, student, self.ballot_of(question, student)._replace(curve=curve))

    def give_reason(self, question: QuestionId, student: str, reason: str) -> None:
        """Ignored without a ballot, and after the reveal."""
        ballot = self.ballot_of(question, student)
        if ballot._replace(reason="") != Ballot():
            self._put(question, student, ballot._replace(reason=reason))

    def reasons(self, question: QuestionId) -> dict[int, tuple[int | None, str]]:
        """Ballot number (1-based) → answer and reason, in the last round."""
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
        first, *later = self.rounds_of(question)
        return first.get(student, Ballot()) if later else Ballot()

    def ballots_of(self, student: str) -> dict[QuestionId, Ballot]:
        found: dict[QuestionId, Ballot] = {}
        for question in self.questions:
            for ballots in self.rounds_of(question):
                if student in ballots:
                    found[question] = ballots[student]
        return found

    def counts(self, question: QuestionId, choices: int, here: Collection[str]) -> Counts:
        """Counts of a question. `choices`: their number; `here`: present students."""
        if (question, choices) not in self._counts:
            rounds = self.counted_rounds_of(question)
            counts = Counts(tally_of(rounds[-1], choices))
            if len(rounds) > 1:
                counts = Counts(
                    counts.newest, tally_of(rounds[0], choices), switches_between(rounds[0], rounds[-1])
                )
            self._counts[question, choices] = counts
        known = self._counts[question, choices]
        waiting = len(set(here).difference(self.rounds_of(question)[-1], self._left_out))
        return known._replace(newest=known.newest._replace(waiting=waiting))

    def reveal(self, question: QuestionId) -> None:
        """No answer changes afterwards."""
        self.revealed.add(question)

    def ask_again(self, question: QuestionId) -> None:
        """Earlier ballots are kept."""
        rounds = self._rounds.get(question, [{}])
        if rounds[-1]:
            rounds.append({})
        self.revealed.discard(question)
        self._counts.clear()
