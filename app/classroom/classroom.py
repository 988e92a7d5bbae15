"""The class as a whole: who is there, the question on the stage, and what the teacher has decided."""

from dataclasses import dataclass
from typing import NamedTuple

from app.classroom.ballots import Ballots, Place, Tally
from app.classroom.breakout_places import Places
from app.lessons.lesson import Lesson, LessonBook, Step
from app.lessons.outcomes import AnswerVerdict, StepOutcome
from app.lessons.phases import Phase
from app.lessons.progress import Progress, StepProgress, to_json
from app.lessons.step_view import StepPosition as LessonPlace
from app.lessons.step_view import fill, verdict
from app.lessons.walkthrough import Walkthrough


@dataclass(frozen=True)
class Poll:
    """The question on the stage, and how the class has answered.

    Attributes:
        place: lesson and step.
        choices: what can be answered, as Markdown.
        tally: the answers.
        open: whether answers are taken: until the reveal, or until the outcome is on the stage.
        revealed: whether everybody sees the tally.
        outcome: what was measured, line by line; empty before it is on the stage.
        right: the choice that the outcome confirms; None before it is on the stage.
        verdicts: what is said to each choice; empty before the outcome is on the stage.
    """

    place: Place
    choices: tuple[str, ...]
    tally: Tally
    open: bool
    revealed: bool
    outcome: tuple[str, ...] = ()
    right: int | None = None
    verdicts: tuple[AnswerVerdict | None, ...] = ()


class Headcount(NamedTuple):
    """How many students there are: all of them, and those who explore by themselves."""

    all: int
    exploring: int


class _Told(NamedTuple):
    choices: tuple[str, ...]
    outcome: tuple[str, ...] = ()
    verdicts: tuple[AnswerVerdict | None, ...] = ()


class Classroom:
    """What the teacher leads. All methods belong to the thread that draws.

    Args:
        most: how many students may explore by themselves at once.

    Attributes:
        free: whether the students explore; otherwise they follow.
        paused: whether everything stands still.
        inviting: whether the address is on everybody's screen.
        ballots, places: the answers, and the sessions of the students' own.
    """

    def __init__(self, most: int) -> None:
        self.free = self.paused = self.inviting = False
        self.ballots = Ballots()
        self.places = Places(most)
        self._here: dict[int, str] = {}
        self._told: dict[str, tuple[tuple[Step, StepOutcome | None], _Told]] = {}

    # ---- who is here -------------------------------------------------------------------------------------------------------

    def enter(self, number: int, who: str) -> None:
        """A student's tab is there. `number`: of its connection; `who`: the word that it keeps."""
        self._here[number] = who

    def leave(self, number: int) -> None:
        """A connection is gone; one that was no student's is not missed."""
        self._here.pop(number, None)

    @property
    def here(self) -> tuple[str, ...]:
        """The words of all students, each once, in the order in which they came."""
        return tuple(dict.fromkeys(self._here.values()))

    @property
    def heads(self) -> Headcount:
        """How many students there are."""
        return Headcount(len(self.here), sum(map(self.places.holds, self.here)))

    # ---- follow me, or explore ---------------------------------------------------------------------------------------------

    def follow(self) -> None:
        """Call everybody back to the stage."""
        self.free = False
        self.places.take_all()

    def settle(self, able: tuple[str, ...], now: float) -> None:
        """While the students explore: give places to those who are able to take one. `now`: the clock [s]."""
        if self.free:
            self.places.give(able, now)

    # ---- the question ------------------------------------------------------------------------------------------------------

    def poll(self, walk: Walkthrough | None, book: LessonBook | None = None) -> Poll | None:
        """Return the question on the stage; None if there is none.

        Args:
            walk: the stage's, None while no lesson is open.
            book: the lessons in the reader's language; None for the stage's.
        """
        at = None if walk is None else walk.in_book(book)
        if walk is None or at is None or at.step.question is None:
            return None
        question, lesson, step, done = at.step.question, at.lesson, at.step, walk.done
        place = lesson.id, step.id
        if walk.phase is Phase.PREDICT and done.untouched and self.ballots.revealed(place):
            # The teacher has begun the step anew.
            self.ballots.ask_again(place)
        tally = self.ballots.tally(place, len(question.choices), self.here)
        revealed = self.ballots.revealed(place)
        known = None if walk.phase in (Phase.PREDICT, Phase.DO) else done.outcome
        told = self._tell(lesson, step, known)
        if known is None:
            return Poll(place, told.choices, tally, done.outcome is None and not revealed, revealed)
        return Poll(place, told.choices, tally, False, revealed, told.outcome, question.right, told.verdicts)

    def _tell(self, lesson: Lesson, step: Step, outcome: StepOutcome | None) -> _Told:
        """Return the texts of a question, which are put together once in every language and not in every frame."""
        if lesson.language in self._told:
            (known_step, known_outcome), told = self._told[lesson.language]
            if known_step is step and known_outcome is outcome:
                return told
        told = _told(lesson, step, outcome)
        self._told[lesson.language] = (step, outcome), told
        return told

    def answer(self, walk: Walkthrough | None, who: str, choice: int) -> bool:
        """Take a student's answer to the question on the stage; return whether it was taken."""
        poll = self.poll(walk)
        if poll is None or not poll.open or not 0 <= choice < len(poll.choices):
            return False
        return self.ballots.answer(poll.place, who, choice)

    def answer_of(self, walk: Walkthrough | None, who: str) -> int | None:
        """Return what a student has answered to the question on the stage."""
        if walk is None:
            return None
        return self.ballots.answer_of((walk.lesson.id, walk.step.id), who)

    def progress_of(self, who: str, walk: Walkthrough) -> str:
        """Return a walkthrough's progress, as JSON, in which a student finds their own answers at the place of the stage's."""
        progress = Progress(walk.lesson.id, walk.step.id)
        for place, choice in self.ballots.answers_of(who).items():
            progress.steps[place] = StepProgress(choice=choice)
        return to_json(progress)


def _told(lesson: Lesson, step: Step, outcome: StepOutcome | None) -> _Told:
    question = step.question
    if question is None:
        return _Told(())
    choices = tuple(fill(step, choice.text, None, lesson.language) for choice in question.choices)
    if outcome is None:
        return _Told(choices)
    index = lesson.steps.index(step)
    verdicts = tuple(
        verdict(LessonPlace(lesson, step, index, Phase.OBSERVE, StepProgress(choice=i, outcome=outcome), False))
        for i in range(len(choices))
    )
    return _Told(choices, outcome.lines(step, lesson.language), verdicts)
