"""State of a class."""

from collections import Counter
from dataclasses import dataclass, replace

from app.features.classroom.ballots import Ballots
from app.features.classroom.breakout_places import BreakoutPlaces
from app.features.classroom.class_record import NEW_CLASS, ClassRecord
from app.features.classroom.class_summary import AskedQuestion, ClassSummary, HandIn
from app.features.classroom.student_work import ProgressBoard, StudentWork, clean_name
from app.features.lessons.bookmark import OpenSteps, Phase
from app.features.lessons.lesson import Lesson, LessonBook, Question, Step
from app.features.lessons.outcomes import AnswerVerdict, StepOutcome
from app.features.lessons.progress import LONGEST_REASON, Progress, StepProgress, from_json, to_json
from app.features.lessons.step_view import StepPosition, answer_verdict
from app.features.lessons.tally import Ballot, QuestionId, Switch, Tally, switches_between, tally_of
from app.features.lessons.texts import fill
from app.features.lessons.walkthrough import Walkthrough
from app.page.panels.server_load import ServerLoad
from app.plots.curve_chart import Curve
from app.plots.drawing_axes import Drawing, checked_curve
from app.web.connection import FilteredConnection


@dataclass(frozen=True, kw_only=True)
class Poll:
    """The question in the shared session, with the class's answers.

    Attributes:
        choices: Markdown.
        open: until the reveal or the outcome.
        outcome, right, verdicts, truth: empty or None before the outcome.
        first, switches: see `Counts`.
        round: 1-based.
        staged: answers that the run is compared with: the chosen one, or all of a tie.
        unseen: on a projector before the reveal: no answers, empty axes.
    """

    question: QuestionId
    choices: tuple[str, ...]
    tally: Tally
    open: bool
    revealed: bool
    outcome: tuple[str, ...] = ()
    right: int | None = None
    verdicts: tuple[AnswerVerdict | None, ...] = ()
    drawing: Drawing | None = None
    truth: Curve = ()
    first: Tally | None = None
    switches: tuple[Switch, ...] = ()
    round: int = 1
    staged: tuple[int, ...] = ()
    unseen: bool = False
    runs: bool = True


_Texts = tuple[tuple[str, ...], tuple[str, ...], tuple[AnswerVerdict | None, ...]]


class Classroom:
    """The class that the teacher leads. Belongs to the frame loop's thread.

    Attributes:
        free: the students explore; otherwise they follow.
        elsewhere: students with breakout sessions in other processes.
        load: None before it was measured.
        pace: open steps while they explore; None for all.
        wanted: student whose run is to be shown, or "".
    """

    def __init__(self, most: int, record: ClassRecord = NEW_CLASS) -> None:
        self.free, self.paused = record.free, False
        self.waiting = 0
        self.elsewhere: tuple[str, ...] = ()
        self.load: ServerLoad | None = None
        self.ballots, self.work = Ballots(record), StudentWork(record)
        self.places = BreakoutPlaces(most)
        self.places.groups |= record.groups
        self.board, self.wanted = ProgressBoard(), ""
        self.board.names |= record.names
        self.pace: OpenSteps | None = record.pace
        self._here: dict[int, tuple[str, FilteredConnection | None]] = {}
        self._texts: dict[str, tuple[Step, StepOutcome | None, _Texts]] = {}

    # ---- the students -------------------------------------------------------------------------------------------------------

    def enter(self, client_id: int, student: str, origin: FilteredConnection | None = None) -> None:
        """Add a student's connection. `student`: id of the tab; `origin`: the connection, if it can vote."""
        self._here[client_id] = student, origin
        self._look_at_voters(student)

    def leave(self, client_id: int) -> None:
        self._here.pop(client_id, None)

    def _look_at_voters(self, student: str) -> None:
        for one, origin in self._here.values():
            if one == student and origin is not None:
                self.ballots.note(student, origin)

    @property
    def here(self) -> tuple[str, ...]:
        """In the order of arrival; those elsewhere last."""
        return tuple(dict.fromkeys((*(student for student, _ in self._here.values()), *self.elsewhere)))

    @property
    def heads(self) -> tuple[int, int]:
        return len(self.here), sum(self.groups.values())

    @property
    def groups(self) -> dict[str, int]:
        """Group with a breakout session → present students."""
        return Counter(self.places.groups[student] for student in self.here if self.places.holds(student))

    # ---- follow me, or explore ---------------------------------------------------------------------------------------------

    def explore(self) -> None:
        """No groups if there is a place for each student."""
        if not self.free and len(self.here) <= self.places.most:
            self.places.groups.clear()
        self.free = True

    def follow(self) -> None:
        self.free, self.wanted = False, ""
        self.places.take_all()

    def settle(self, able: tuple[str, ...], now: float) -> None:
        """Give places to able students while the class explores. `now`: time [s]."""
        self.waiting = 0
        if self.free:
            self.places.give(able, now)
            self.waiting = sum(not self.places.holds(student) for student in self.here)

    # ---- the question ------------------------------------------------------------------------------------------------------

    def poll(self, walk: Walkthrough | None, book: LessonBook | None = None) -> Poll | None:
        """The shared session's question, or None.

        `book`: in the reader's language; None for the session's.
        """
        at = None if walk is None else walk.in_book(book)
        if walk is None or at is None or at.step.question is None:
            return None
        lesson, step, done = at.lesson, at.step, walk.done
        asked, question = at.step.question, (lesson.id, step.id)
        if walk.phase is Phase.PREDICT and done.untouched and question in self.ballots.revealed:
            # The teacher has restarted the step.
            self.ballots.ask_again(question)
        revealed, counts = (
            question in self.ballots.revealed,
            self.ballots.counts(question, len(asked.choices), self.here),
        )
        known = None if walk.phase in (Phase.PREDICT, Phase.DO) else done.outcome
        choices, outcome, verdicts = self._texts_of(lesson, step, asked, known)
        return Poll(
            question=question,
            choices=choices,
            tally=counts.newest,
            open=done.outcome is None and not revealed,
            revealed=revealed,
            outcome=outcome,
            right=None if known is None else asked.right,
            verdicts=verdicts,
            drawing=step.drawing,
            truth=() if known is None else known.curve,
            first=counts.first,
            switches=counts.switches,
            round=len(self.ballots.rounds_of(question)),
            staged=_staged(walk, counts.newest, revealed),
            runs=not step.concept and bool(step.measurements),
        )

    def _texts_of(self, lesson: Lesson, step: Step, asked: Question, outcome: StepOutcome | None) -> _Texts:
        """Cached for each language: needed every frame."""
        cached = self._texts.get(lesson.language)
        if cached is not None and cached[0] is step and cached[1] is outcome:
            return cached[2]
        choices = tuple(fill(step, choice.text, None, lesson.language) for choice in asked.choices)
        index = lesson.steps.index(step)
        each = (
            [] if outcome is None else [StepProgress(choice=i, outcome=outcome) for i in range(len(choices))]
        )
        verdicts = tuple(
            answer_verdict(StepPosition(lesson, step, index, Phase.OBSERVE, one, None)) for one in each
        )
        texts = choices, () if outcome is None else outcome.lines(step, lesson.language), verdicts
        self._texts[lesson.language] = step, outcome, texts
        return texts

    def answer(self, walk: Walkthrough | None, student: str, choice: int) -> bool:
        """False if the question is closed."""
        poll = self.poll(walk)
        if poll is None or not poll.open or not 0 <= choice < len(poll.choices):
            return False
        self._look_at_voters(student)
        return self.ballots.answer(poll.question, student, choice)

    def draw(self, walk: Walkthrough | None, student: str, question: QuestionId, curve: Curve) -> bool:
        """False if the question is closed, or not the current one."""
        poll = self.poll(walk)
        if poll is None or not poll.open or poll.question != question or poll.drawing is None:
            return False
        checked = checked_curve(poll.drawing, curve)
        self._look_at_voters(student)
        return checked is not None and self.ballots.draw(question, student, checked)

    def give_reason(self, walk: Walkthrough | None, student: str, question: QuestionId, reason: str) -> None:
        poll = self.poll(walk)
        if poll is not None and poll.open and poll.question == question:
            self.ballots.give_reason(question, student, clean_name(reason, LONGEST_REASON))

    def progress_of(self, student: str, walk: Walkthrough) -> str:
        """JSON: the shared session's step with the student's own answers."""
        progress = Progress(walk.lesson.id, walk.step.id)
        for question, ballot in self.ballots.ballots_of(student).items():
            progress.steps[question] = StepProgress(choice=ballot.choice, drawing=ballot.curve)
        return to_json(progress)

    # ---- what is left behind -----------------------------------------------------------------------------------------------

    def note(self, group: str, progress: str, now: float) -> None:
        """Record a group's progress (JSON) for each student. `now`: time [s]."""
        self.board.note(group, progress, now)
        for student in self.places.members(group) or (group,):
            self.work.note(student, progress)

    def has_work(self, student: str) -> bool:
        return bool(self.work.progress_of(student) or self.ballots.ballots_of(student))

    def hand_in(self, walk: Walkthrough | None, student: str, name: str, progress: str) -> bool:
        """False if the report is empty.

        Args:
            walk: the shared session's, for outcomes.
            progress: of the own session, as JSON; "" in the shared one.
        """
        if progress:
            self.work.note(student, progress)
        if not self.has_work(student):
            return False
        steps = from_json(self.work.progress_of(student)).steps
        ballots = self.ballots.ballots_of(student)
        for question, ballot in ballots.items():
            own = steps.get(question, StepProgress())
            if own.outcome is None:
                outcome = None if walk is None else walk.done_in(*question).outcome
                choice = own.choice if ballot.choice is None else ballot.choice
                mine = {"drawing": ballot.curve or own.drawing, "because": ballot.reason or own.because}
                steps[question] = replace(own, choice=choice, outcome=outcome, **mine)
        answers = {
            q: tuple(one.get(student, Ballot()).choice for one in self.ballots.rounds_of(q)) for q in ballots
        }
        self.work.hand_in(student, HandIn(clean_name(name), to_json(Progress(steps=steps)), answers))
        return True

    def summary(self, book: LessonBook, now: float) -> ClassSummary:
        """Report of the class. `now`: [s since 1970]."""
        steps = {(lesson.id, step.id): step for lesson in book.lessons for step in lesson.steps}
        asked = [q for q in self.ballots.questions if q in steps and steps[q].question is not None]
        rounds = {q: tuple(one for one in self.ballots.counted_rounds_of(q) if one) for q in asked}
        hand_ins = sorted(self.work.hand_ins.values(), key=lambda one: (not one.name, one.name.casefold()))
        return ClassSummary(
            now,
            len({student for given in rounds.values() for one in given for student in one}),
            tuple(_asked(q, steps[q], rounds[q]) for q in asked),
            {q: len(students) for q, students in self.work.passed.items()},
            tuple(hand_ins),
            self.ballots.paired(book, self.work.choices),
        )


def _asked(question: QuestionId, step: Step, rounds: tuple[dict[str, Ballot], ...]) -> AskedQuestion:
    choices = 0 if step.question is None else len(step.question.choices)
    switches = switches_between(rounds[0], rounds[-1]) if len(rounds) > 1 else ()
    return AskedQuestion(question, tuple(tally_of(one, choices) for one in rounds), switches)


def _staged(walk: Walkthrough, tally: Tally, revealed: bool) -> tuple[int, ...]:
    choice = walk.done.choice
    if choice is None:
        return ()
    return tally.favourites if revealed and choice in tally.favourites and not walk.showing else (choice,)
