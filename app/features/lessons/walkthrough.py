"""A student's way through the lessons, without a page: goal → predict → do → observe → explain → challenge.

The page shows `view`, begins a simulation by `setup` and `kept` whenever `run_id` changes, passes it to
`watch` every frame and to `observe` at its end.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf
from typing import Final

from app.features.custom_law.arena import TrialResult
from app.features.lessons.attempts import RunWatch, attempt_of, attempted
from app.features.lessons.bookmark import (
    Bookmark,
    Phase,
    first_phase,
    fitting,
    furthest_phase,
    is_finished,
    phases_of,
)
from app.features.lessons.lesson import AT_ONCE, LAST, Challenge, Lesson, LessonBook, Measurement, Step
from app.features.lessons.outcomes import (
    FARTHEST,
    Attempt,
    StepOutcome,
    asks_for_distance,
    decisive_moment,
    guessed_answer,
    observed,
    reference,
)
from app.features.lessons.progress import (
    MOST_TRIES,
    MOST_WORDS,
    StepProgress,
    Try,
    from_json,
    kept_reason,
    to_json,
)
from app.features.lessons.runs import Setup
from app.features.lessons.step_view import LessonEntry, StepPosition, StepView, has_curve, make_view, why_of
from app.features.measures.evidence import Evidence
from app.features.measures.quantities.quantity import measure
from app.plots.curve_chart import Curve
from app.plots.drawing_axes import checked_curve, law_curve
from app.session.replay_player import Mark
from controllers.errors import BadSetting
from scenes.inputs import Recorded, RecordedPerson
from scenes.laws import DRAWN_LAW
from scenes.roles import TargetSource
from scenes.settings import values
from scenes.simulation import Simulation

LIVE_ROWS: Final = 250
"""Newest rows for a live number: where two pairs tie, the resting distance is a mean over 0.25 s."""


class Walkthrough:
    """A student's way through a book of lessons.

    Args:
        progress: JSON of `to_json`, or ""; what does not fit the book is left out.

    Attributes:
        run_id: increases whenever a fresh run has to begin.
        beside: shown run that is not the step's own: why an answer is wrong, or the student's curve.
        kept: recorded motions for later steps, by name; not in `to_json`.

    Raises:
        BadSetting: the book has no lesson.
    """

    def __init__(
        self, book: LessonBook, progress: str = "", kept: Mapping[str, TargetSource] | None = None
    ) -> None:
        if not book.lessons:
            raise BadSetting("There is no lesson to walk through; the folder holds none that can be read.")
        self.book = book
        self.run_id = 0
        saved = self._progress = from_json(progress)
        self.beside: Setup | None = None
        self.kept: dict[str, TargetSource] = dict(kept or {})
        self.run_watch = RunWatch()
        self._counted: tuple[object, ...] = ()
        self._judged = -1
        self._running: tuple[Bookmark, Setup] | None = None
        # Resume where it fits the book.
        places = {(lesson.id, step.id): step for lesson in book.lessons for step in lesson.steps}
        known = ((place, step) for place, step in places.items() if place in saved.steps)
        saved.steps = {place: fitting(step, saved.steps[place]) for place, step in known}
        self._at = Bookmark(book).of(saved.lesson, saved.step)
        allowed = self.phases[: self.phases.index(furthest_phase(self.step, self.done)) + 1]
        phase = next(
            (phase for phase in allowed if phase.value == saved.phase), first_phase(self.step, self.done)
        )
        self._enter(self._at, phase)

    # ---- where -------------------------------------------------------------------------------------------------------------

    @property
    def lesson(self) -> Lesson:
        return self._at.lesson

    @property
    def step(self) -> Step:
        return self._at.step

    @property
    def step_index(self) -> int:
        return self._at.step_index

    @property
    def phases(self) -> tuple[Phase, ...]:
        return phases_of(self.step)

    @property
    def challenge(self) -> Challenge | None:
        return self.step.challenge if self.phase is Phase.CHALLENGE else None

    @property
    def done(self) -> StepProgress:
        return self._progress.at(self.lesson.id, self.step.id)

    def done_in(self, lesson: str, step: str) -> StepProgress:
        return self._progress.steps.get((lesson, step), StepProgress())

    @property
    def begun(self) -> bool:
        return any(not done.untouched for done in self._progress.steps.values())

    @property
    def locked(self) -> bool:
        """True until the answer: no page may say what the law does."""
        return self.phase is Phase.PREDICT

    @property
    def showing(self) -> bool:
        return self.beside is not None

    @property
    def plots(self) -> tuple[str, ...]:
        """Before an answer, only those that are empty until the run."""
        return (
            tuple(plot for plot in self.step.plots if plot not in AT_ONCE) if self.locked else self.step.plots
        )

    def go(self, lesson: str | int, step: int = 0) -> None:
        """Go to a step, whose progress stays.

        Raises:
            BadSetting: unknown lesson or step.
        """
        at = self._at.at(lesson, step)
        self._enter(at, furthest_phase(at.step, self.done_in(at.lesson.id, at.step.id)))

    # ---- what the student does ---------------------------------------------------------------------------------------------

    def choose(self, answer: int) -> bool:
        """Choose an answer (0-based) until the outcome is known; true if accepted."""
        question = self.step.question
        if question is None or not 0 <= answer < len(question.choices) or not self._answerable:
            return False
        self.done.choice = answer
        if self.phase is Phase.PREDICT and not self.step.concept:
            self._enter(self._at, Phase.DO)
        return True

    def guess(self, distance: float) -> bool:
        """Guess d on the line of contact [m], and so its answer; true if accepted."""
        if not self.guessing or not abs(distance) <= FARTHEST:
            return False
        self.done.guess = distance
        answer = guessed_answer(self.step, distance)
        if answer is not None:
            self.choose(answer)
        return True

    @property
    def guessing(self) -> bool:
        return asks_for_distance(self.step) and self._answerable

    @property
    def _answerable(self) -> bool:
        if (
            self.step.asked == "first"
            and self.done_in(self.lesson.id + LAST, self.step.id).outcome is not None
        ):
            # The last test told the right answer.
            return False
        return self.phase in (Phase.PREDICT, Phase.DO) and self.done.outcome is None

    def draw(self, curve: Curve) -> bool:
        """Replace the curve before the run; true if accepted. () clears it."""
        drawing = self.step.drawing
        if drawing is None or self.phase is not Phase.PREDICT or self.done.outcome is not None:
            return False
        checked = checked_curve(drawing, curve)
        if checked is None:
            return False
        self.done.drawing = checked
        return True

    def next(self) -> bool:
        """Next phase or step; false at the end, or before an answer."""
        ahead = self._ahead()
        if ahead is None:
            return False
        skips = self.step.concept or (self.phase is Phase.DO and self.step.measurements)
        if ahead[0] == self._at and self.done.outcome is None and skips:
            # A student who skips the run sees the outcome of the reference run.
            self.done.outcome = reference(self.step, self.step.setup)
        self._enter(*ahead)
        return True

    def back(self) -> bool:
        """Previous phase or step; false at the beginning."""
        behind = self._behind()
        if behind is None:
            return False
        self._enter(*behind)
        return True

    def reset(self) -> None:
        """Restart the step, keeping own words; a test's answer stays once the right one was told."""
        if self.step.asked and not self._answerable:
            return
        done = self._progress.steps.pop((self.lesson.id, self.step.id), None)
        if done is not None and done.words:
            self.done.words = done.words
        self._enter(self._at, self.phases[0])

    def run_again(self) -> None:
        self.run_id += 1
        self._running = self._at, self.setup
        self.run_watch.begin()

    def show_why(self) -> bool:
        """False if no run shows why the answer is wrong."""
        return self._show_beside(why_of(self._place()))

    def show_curve(self) -> bool:
        if not has_curve(self._place()) or self.step.drawing is None:
            return False
        changes = {"law": DRAWN_LAW, "curve": law_curve(self.step.drawing, self.done.drawing)}
        return self._show_beside(self.step.setup.with_changes(tuple(changes.items())))

    def _show_beside(self, setup: Setup | None) -> bool:
        if self.showing or setup is None:
            return False
        self.beside, self.done.why = setup, None
        self.run_again()
        return True

    def hint(self) -> str | None:
        hints, done = self.step.hints, self.done
        if done.hints >= len(hints):
            return None
        done.hints += 1
        return hints[done.hints - 1]

    def write(self, words: str, lesson: str | None = None, step: str | None = None) -> None:
        self._progress.at(lesson or self.lesson.id, step or self.step.id).words = words[:MOST_WORDS]

    def give_reason(self, reason: str, lesson: str, step: str) -> None:
        self._progress.at(lesson, step).because = kept_reason(reason)

    # ---- the run -----------------------------------------------------------------------------------------------------------

    @property
    def rival_hidden(self) -> bool:
        """True if the ghost is the student's opponent, hidden until the end."""
        return self.phase is Phase.DO and self.step.at_lever

    @property
    def setup(self) -> Setup:
        return self.beside or (self.step.setup if self.challenge is None else self.challenge.setup)

    @property
    def yours(self) -> bool:
        return self.setup.input.kind == "yours"

    @property
    def duel(self) -> bool:
        return self.step.challenge is not None and self.step.challenge.best_of > 0

    @property
    def pushes(self) -> bool:
        return self.duel and self.challenge is not None

    @property
    def ends(self) -> bool:
        """False for the student's own run, except a push of a duel."""
        return not self.yours or self.pushes

    @property
    def nearest(self) -> Recorded | None:
        person = self.kept.get(self._nearest) if self.pushes and self.done.tries else None
        return person.recorded if isinstance(person, RecordedPerson) else None

    @property
    def _nearest(self) -> str:
        return f"nearest {self.lesson.id} {self.step.id}"

    def live(self, simulation: Simulation) -> tuple[tuple[Measurement, float | None], ...]:
        evidence = Evidence(simulation, newest=LIVE_ROWS)
        return tuple((m, measure(evidence, m.name, m.parameters)) for m in self.step.numbers)

    def watch(self, simulation: Simulation) -> bool:
        """Once a frame: changed settings spoil a run for a challenge.

        True if the last attempt asked for this run, and is cleared.
        """
        self.run_watch.see(simulation)
        last = self.done.last
        asked = simulation.steps > 0 and last is not None and bool(last.note) and not last.judgements
        if asked:
            self.done.last = None
        return asked

    def finished(self, simulation: Simulation) -> bool:
        return simulation.time >= self.setup.seconds - 0.5 * simulation.settings.dt

    def observe(self, simulation: Simulation) -> StepOutcome:
        """Measure the run; at its end keep the outcome and, unless the student moves, go to OBSERVE."""
        setup = self.beside or self.step.setup
        until = inf if self.yours else setup.seconds
        outcome = observed(self.step, setup, Evidence(simulation, until), simulation.time)
        if outcome.complete and self.showing:
            self.done.why = outcome
        elif outcome.complete and self.phase is Phase.DO:
            if outcome.unlike and self.step.question is not None:
                # The replies explain the numbers of the question's settings, not of others.
                outcome = replace(reference(self.step, setup), unlike=outcome.unlike)
            self.done.outcome = outcome
            if not self.yours:
                self.next()
        return outcome

    def decisive(self, simulation: Simulation) -> Mark | None:
        """None for the run's end, or without a decisive moment."""
        if not self.ends or not simulation.history.count:
            return None
        criteria = None if self.challenge is None else self.challenge.criteria
        asked = self.step.measurements if criteria is None else tuple(each.measurement for each in criteria)
        return decisive_moment(asked, Evidence(simulation, self.setup.seconds))

    def attempt(
        self, simulation: Simulation, said: Sequence[float | None] = (), person: TargetSource | None = None
    ) -> Attempt | None:
        """Judge the run, counted once; None without an open challenge.

        Args:
            person: the student's motion, kept for a later step.
        """
        challenge = self.challenge
        if challenge is None or challenge.custom_law:
            return None
        finished, mixed = self.finished(simulation), self.run_watch.mixed
        attempt = attempted(challenge, simulation, said, yours=self.yours, finished=finished, mixed=mixed)
        if attempt.passed and challenge.keep and person is not None:
            self.kept[challenge.keep] = person
        # A run that is checked twice is one attempt; new numbers are another one.
        counted = self.lesson.id, self.step.id, self.run_watch.run, *said
        self._judged = self.run_watch.run
        again, self._counted = (
            counted == self._counted or not attempt.judgements,
            counted if attempt.judgements else (),
        )
        if (
            not again
            and not attempt.note
            and attempt.judgements
            and (value := attempt.judgements[0].value) is not None
        ):
            tries, met = self.done.tries, attempt.judgements[0].passed
            if challenge.search:
                setting = float(values(simulation.settings)[challenge.search])
                self.done.tries = (*tries, Try(setting, value, met))[-MOST_TRIES:]
            elif len(tries) < challenge.best_of and all(
                judgement.passed for judgement in attempt.judgements[1:]
            ):
                if person is not None and all(value < before.measured for before in tries):
                    self.kept[self._nearest] = person
                self.done.tries = (*tries, Try(simulation.settings.hand_speed, value, met))
        self.done.note(attempt, again)
        return attempt

    def attempt_custom_law(self, verdicts: Sequence[TrialResult]) -> Attempt | None:
        if self.challenge is None or not self.challenge.custom_law:
            return None
        attempt = attempt_of(verdicts)
        self.done.note(attempt)
        return attempt

    # ---- what is shown -----------------------------------------------------------------------------------------------------

    def in_book(self, book: LessonBook | None) -> Bookmark:
        """Current place in another language's book; None for this book."""
        return (
            self._at if book is None or book is self.book else Bookmark(book).of(self.lesson.id, self.step.id)
        )

    def translate(self, book: LessonBook) -> None:
        self._at, self.book = self.in_book(book), book
        if self._running is not None:
            self._running = self._at, self.setup

    def view(self, book: LessonBook | None = None) -> StepView:
        return make_view(self._place(book), self.yours, self._ahead() is not None, self._behind() is not None)

    def entries(self, book: LessonBook | None = None) -> Iterator[LessonEntry]:
        begun = self.begun or self.step is not self.book.lessons[self.book.first].steps[0]
        for lesson in (book or self.book).lessons:
            finished = tuple(is_finished(step, self.done_in(lesson.id, step.id)) for step in lesson.steps)
            here = begun and lesson.id == self.lesson.id
            step = self.step_index if here else finished.index(False) if False in finished else 0
            yield LessonEntry(lesson, finished, here, step)

    def to_json(self) -> str:
        progress = self._progress
        progress.lesson, progress.step, progress.phase = self.lesson.id, self.step.id, self.phase.value
        return to_json(progress)

    # ---- inside ------------------------------------------------------------------------------------------------------------

    def _enter(self, at: Bookmark, phase: Phase) -> None:
        showed, self.beside = self.showing, None
        self._at, self.phase = at, phase
        # Looking back from EXPLAIN to OBSERVE leaves the run alone; the other phases restart it.
        if showed or phase in (Phase.PREDICT, Phase.DO, Phase.CHALLENGE) or self._running != (at, self.setup):
            self.run_again()

    def _place(self, book: LessonBook | None = None) -> StepPosition:
        at, challenge = self.in_book(book), self.step.challenge
        # The custom law is tested, not the run.
        tested = challenge is not None and challenge.custom_law
        stale = self.done.last is not None and not tested and 0 <= self._judged != self.run_watch.run
        return StepPosition(at.lesson, at.step, at.step_index, self.phase, self.done, self.beside, stale)

    def _ahead(self) -> tuple[Bookmark, Phase] | None:
        if self.showing:
            return self._at, self.phase
        if self.locked and not self.done.predicted and self.step.asked != "first":
            return None
        place = self.phases.index(self.phase) + 1
        if place < len(self.phases):
            return self._at, self.phases[place]
        after = self._at.next_to(1)
        return (
            None
            if after is None
            else (after, first_phase(after.step, self.done_in(after.lesson.id, after.step.id)))
        )

    def _behind(self) -> tuple[Bookmark, Phase] | None:
        """Previous place; a known outcome fixes the answer."""
        if self.showing:
            return self._at, self.phase
        place = self.phases.index(self.phase) - 1
        if place >= 0 and (self.phases[place] is not Phase.PREDICT or self.done.outcome is None):
            return self._at, self.phases[place]
        before = self._at.next_to(-1)
        return (
            None
            if before is None
            else (before, furthest_phase(before.step, self.done_in(before.lesson.id, before.step.id)))
        )
