"""Lessons of a session, on its thread; another thread simulates further runs."""

import logging
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import ClassVar, Final

import msgspec

from app.features.custom_law.examination import ExaminationProgress
from app.features.custom_law.student_law import let_custom_law_run, tests_of
from app.features.lessons.bookmark import OpenSteps, Phase
from app.features.lessons.labels import label_of
from app.features.lessons.lesson import NO_LESSONS, LessonBook
from app.features.lessons.progress import SavedLesson
from app.features.lessons.runs import LONGEST
from app.features.lessons.session import lesson_actions
from app.features.lessons.session.step_runner import (
    StepRunner,
    asks_for_custom_law,
    deviation_from_lesson,
    with_look,
)
from app.features.lessons.walkthrough import Walkthrough
from app.features.studies.background_studies import BackgroundStudies
from app.i18n.catalogue import words_of
from app.runtime.throttled_log import ThrottledLog
from app.session.parts import SessionPart
from app.session.session import Session
from app.settings import Language, Settings, to_query
from controllers.errors import BadSetting, DuetError
from scenes.inputs import Recorded, RecordedPerson
from scenes.settings import RunSettings, specs
from scenes.simulation import Simulation

log = logging.getLogger("duet.lessons")

PATIENCE: Final = 40.0
"""Time without the hand until a duel's run restarts [s]; with a push it still fits into a link."""


OF_STEPS: Final = ("scene", "rig", "robot", "autopilot", "ghost", "whatif", "plot", "speed", "lever")
"""Settings that a step decides, so its link omits them."""

_SEEN: Final = "seen"
_KEPT: Final = "kept"
_TAB: Final = "\t"


class LessonSession(SessionPart):
    """Lessons of a session.

    Attributes:
        english: English book; `book` is in the operator's language.
        version: increases with every change to show.
        pace: steps that a teacher opened; None for all.
    """

    name: ClassVar[str] = "lessons"

    def __init__(self, session: Session, book: LessonBook = NO_LESSONS) -> None:
        super().__init__(session)
        self.version = 0
        self.session = session
        self._recordings: Mapping[str, Recorded] = {}
        self._errors = ThrottledLog(log)
        self.english = book
        self._forget(book)

    def _forget(self, book: LessonBook) -> None:
        self.book, self.open, self.listing = book, False, False
        self.version += 1
        self.pace: OpenSteps | None = None
        self.left: SavedLesson | None = None
        self._reopened: SavedLesson | None = None
        self._said: dict[tuple[str, str], list[float | None]] = {}
        self._walk: Walkthrough | None = None
        self._own = self.session.settings
        self._run_id = self._measured = self._reported_run = -1
        self._taken: float | None = None
        self._stood = ("", 0)
        self.runner = StepRunner(self.session)
        self._waiting: lesson_actions.LessonAction | None = None

    # ---- in and out --------------------------------------------------------------------------------------------------------

    @property
    def walk(self) -> Walkthrough:
        """It outlives closing the lessons."""
        if self._walk is None:
            self._walk = Walkthrough(self.book)
        return self._walk

    @property
    def begun(self) -> bool:
        return self._walk is not None and self._walk.begun

    def enter(self, lesson: int | str | None = None, step: int = 0) -> None:
        """Open the last place, or a step. `lesson`: id or 0-based; `step`: 0-based."""
        if not self.book.lessons:
            self.session.notify("There are no lessons", "The folder of lessons holds none that can be read.")
            return
        self.listing = False
        try:
            if lesson is not None:
                self.walk.go(lesson, step)
        except BadSetting as error:
            self.session.notify("This step is not there", str(error))
        if not self.open:
            self._own = self.session.settings
            self.open = True
        self._run_id = -1
        self._guarded(self._follow)

    def leave(self) -> None:
        self.listing = False
        self.version += 1
        if not self.open:
            return
        self._waiting = None
        try:
            let_custom_law_run(self.session, True)
            self.session.hand.set_source(None)
            self.runner.apply(with_look(self._own, self.session))
            self.session.reset()
        finally:
            self.session.control.halt.go_on()
            self.session.hand.on_grid = self.session.ghost_run.hidden = False
            self.session.control.frame_ends_at = 0.0
            self.session.player.leave()
            self.open = False
            self.version += 1

    @property
    def leads(self) -> bool:
        return self.open

    def saved(self) -> bytes:
        lesson = self.saved_lesson()
        # Recordings are saved separately, see `recordings`.
        return b"" if lesson is None else msgspec.msgpack.encode(replace(lesson, seen={}, kept={}))

    def recordings(self) -> dict[str, Recorded]:
        if self._walk is None:
            runs, kept = ({}, {}) if self.left is None else (self.left.seen, self.left.kept)
        else:
            runs, kept = self.seen, self._walk.kept
        seen = {_TAB.join((_SEEN, *step)): recorded for step, recorded in runs.items()}
        people = {name: one for name, one in kept.items() if isinstance(one, RecordedPerson)}
        return seen | {f"{_KEPT}{_TAB}{name}": one.recorded for name, one in people.items()}

    def restore_recordings(self, recordings: Mapping[str, Recorded]) -> None:
        self._recordings = recordings

    def restore(self, saved: bytes) -> None:
        try:
            lesson = msgspec.msgpack.decode(saved, type=SavedLesson)
        except msgspec.MsgspecError as error:
            log.warning("the lessons of a record cannot be read (%s)", str(error)[:120])
            return
        seen: dict[tuple[str, str], Recorded] = {}
        kept: dict[str, RecordedPerson] = {}
        for name, recorded in self._recordings.items():
            match name.split(_TAB):
                case ["seen", of_lesson, step]:
                    seen[of_lesson, step] = recorded
                case ["kept", *words]:
                    kept[_TAB.join(words)] = RecordedPerson(recorded)
                case _:
                    pass
        self.left = replace(lesson, seen=seen, kept=kept)

    def saved_lesson(self) -> SavedLesson | None:
        """None if no lesson was ever opened."""
        if self._walk is None:
            return self.left
        settings, open_now = self.session.settings, self.open
        said = {step: tuple(numbers) for step, numbers in self._said.items()}
        return SavedLesson(
            self._walk.to_json(),
            self._own if open_now else settings,
            open_now,
            dict(self.seen),
            settings if open_now and not self.walk.showing else None,
            dict(self._walk.kept),
            said,
            open_now and self._measured == self._walk.run_id,
        )

    def resume(self, saved: SavedLesson, reopen: bool) -> None:
        if not self.book.lessons:
            return
        self.left = None
        self._walk = Walkthrough(self.book, saved.progress, saved.kept)
        self.runner.seen = dict(saved.seen)
        self._said = {step: list(numbers) for step, numbers in saved.said.items()}
        if saved.open and reopen:
            self._reopened = saved
            self.enter()
            self._own = saved.own
            if saved.now is not None:
                self.runner.apply(with_look(saved.now, self.session))

    @property
    def history(self) -> float | None:
        lesson = self._reopened
        if not self.open or lesson is None:
            return 0.0
        # Restart the run that shows why an answer is wrong.
        return None if lesson.now is None else LONGEST

    def run_restored(self) -> None:
        measured = self._reopened is not None and self._reopened.measured
        self._run_id = self.walk.run_id if self.open else -1
        self._measured = self._run_id if measured else -1
        if self.open and measured:
            self._guarded(self._show_moment)

    # ---- what the visitor does ---------------------------------------------------------------------------------------------

    @property
    def locked(self) -> bool:
        return self.open and self.walk.locked

    @property
    def withholds(self) -> bool:
        """True until the answered run's first step: no page may say what the law does."""
        if not self.open or self.walk.step.question is None:
            return self.locked
        waits = self.walk.phase is Phase.DO and self.session.simulation.steps == 0
        return self.locked or waits

    @property
    def said(self) -> list[float | None]:
        """Typed forecasts, mutable."""
        return self._said.setdefault((self.walk.lesson.id, self.walk.step.id), [])

    @property
    def seen(self) -> Mapping[tuple[str, str], Recorded]:
        return self.runner.seen

    @property
    def hands_off(self) -> bool:
        """True if the lesson moves what the visitor could move."""
        return self.open and not self.walk.yours

    @property
    def over(self) -> bool:
        """True if *Run* begins the next run."""
        walk = self.walk
        if walk.pushes:
            return walk.run_id == self._measured
        return walk.ends and walk.finished(self.session.simulation)

    @property
    def computing(self) -> bool:
        return self._waiting is not None

    def act(self, action: lesson_actions.LessonAction) -> None:
        """Perform an action; one at the wrong moment does nothing."""
        match action:
            case lesson_actions.Press("list"):
                self.listing = bool(self.book.lessons) and not self.listing
                self.version += 1
            case lesson_actions.Enter(lesson):
                self.enter(lesson)
            case lesson_actions.GoTo() if self.listing and not self.open:
                self.enter(*self._place(action))
            case lesson_actions.SayNumber(lesson, step, index, number):
                said = self._said.setdefault((lesson, step), [])
                said.extend([None] * (index + 1 - len(said)))
                said[index] = number
            case lesson_actions.Write(lesson, step, words):
                self.walk.write(words, lesson, step)
            case lesson_actions.GiveReason(lesson, step, reason):
                self.walk.give_reason(reason, lesson, step)
            case _:
                self.listing = False
                if self.open:
                    self._waiting = None
                    self._guarded(lambda: self._act(action))
                    self._guarded(self._follow)

    def _guarded(self, what: Callable[[], None]) -> None:
        try:
            what()
        except DuetError as error:
            self.session.notify("This is not possible here", str(error))
        except Exception:
            log.exception("an action of a lesson failed and was left out")
            self.session.notify("Something went wrong", "It was left out. Reset restarts the step.")

    def _act(self, action: lesson_actions.LessonAction) -> None:
        walk, session = self.walk, self.session
        if (
            action in (lesson_actions.Press("next"), lesson_actions.Press("check"))
            and not self.runner.further.done()
        ):
            self._waiting = action
            return
        shown_beside = walk.showing and "teacher" not in session.control.halt
        match action:
            case lesson_actions.Choose(answer):
                walk.choose(answer)
            case lesson_actions.Draw(lesson, step, curve):
                # The last drawing may arrive when the student is already in the next step.
                if (lesson, step) == (walk.lesson.id, walk.step.id):
                    walk.draw(curve)
            case lesson_actions.Guess(lesson, step, distance):
                if (lesson, step) == (walk.lesson.id, walk.step.id):
                    walk.guess(distance)
            case lesson_actions.GoTo():
                walk.go(*self._place(action))
            case lesson_actions.Press("next"):
                if (
                    walk.phase is Phase.DO
                    and walk.yours
                    and walk.step.measurements
                    and walk.finished(session.simulation)
                ):
                    self.runner.observe(walk)
                if not self._fast_forwards():
                    walk.next()
            case lesson_actions.Press("back"):
                walk.back()
            case lesson_actions.Press("reset"):
                walk.reset()
                self.said.clear()
                self._run_id = -1
            case lesson_actions.Press("again"):
                self._run_again()
            case lesson_actions.Press("run"):
                self._run()
            case lesson_actions.Press("why" | "curve" as what):
                if walk.show_why() if what == "why" else walk.show_curve():
                    self._begin()
                    session.control.halt.go_on()
            case lesson_actions.Press("hint"):
                walk.hint()
            case lesson_actions.Press("check") if walk.pushes and self._taken is None:
                self.session.notify("Push first", "Take the hand and push it at the other one.")
            case lesson_actions.Press("check"):
                self.runner.check(walk, self.said)
                if walk.pushes:
                    self._measured = walk.run_id
                    session.control.halt.set("lesson")
                    self._show_moment()
            case lesson_actions.Press("leave"):
                self.leave()
            case _:
                raise TypeError(f"a lesson does not do {action!r}")
        if shown_beside and action in (lesson_actions.Press("next"), lesson_actions.Press("back")):
            # Simulate the question's run again at once, so that the plots show it, at its decisive moment.
            self._begin()
            session.control.hurry(walk.setup.seconds)

    def _place(self, wanted: lesson_actions.GoTo) -> tuple[int, int]:
        lesson = self.book.lessons.index(self.walk.lesson) if wanted.lesson is None else wanted.lesson
        return lesson, tuple(self.walk.entries())[lesson].step if wanted.step is None else wanted.step

    def _fast_forwards(self) -> bool:
        walk, session = self.walk, self.session
        to_measure = (
            walk.phase is Phase.DO
            and walk.step.measurements
            and walk.done.outcome is None
            and not walk.showing
        )
        over = walk.run_id == self._measured or walk.finished(session.simulation)
        possible = bool(to_measure) and not (walk.yours or over or "teacher" in session.control.halt)
        if possible:
            session.control.hurry(walk.setup.seconds)
        return possible

    def _run(self) -> None:
        walk, session = self.walk, self.session
        if walk.step.concept:
            walk.next()
            return
        if walk.locked and not walk.done.predicted:
            self.session.notify("Predict first", "Choose an answer; then the run is free.")
            return
        if walk.locked:
            walk.next()
            self._follow()
        if session.paused and self.over:
            self._run_again()
            session.control.halt.go_on()
        else:
            session.control.toggle_pause()

    def _run_again(self) -> None:
        self.walk.run_again()
        # A challenge is tried with the student's own settings, and tried again with them.
        self._begin(self.walk.challenge is not None)

    # ---- frame by frame ----------------------------------------------------------------------------------------------------

    def decide(self) -> None:
        """Begin, stop or measure the run: every frame, between actions and steps. Never raises."""
        if not self.open:
            return
        try:
            self._decide()
        except DuetError as error:
            self._stop_trouble(str(error))
        except Exception as error:
            self._errors.exception("a frame of a lesson failed", error)
            self._stop_trouble(
                "The run could not be measured. Reset restarts the step; Next continues without it."
            )

    def _stop_trouble(self, text: str) -> None:
        run_id = self.walk.run_id
        self.session.control.halt.set("lesson")
        self._measured = run_id
        if self._reported_run == run_id:
            # Reported once a run, not once a frame.
            return
        self._reported_run = run_id
        self.session.notify("The lesson stopped here", text)
        self.version += 1

    def _decide(self) -> None:
        walk, session = self.walk, self.session
        if self._left_pace():
            self._follow()
        note = deviation_from_lesson(session, walk)
        if note is not None:
            session.notify(*note)
            self._begin()
            return
        if walk.locked:
            session.control.halt.set("lesson")
        session.ghost_run.hidden = walk.rival_hidden
        simulation = session.simulation
        if walk.watch(simulation):
            self.version += 1
        if self._taken is None and session.held is not None:
            self._taken = simulation.time
        if self.runner.advance_law_tests(walk):
            self.version += 1
        if self._waiting is not None and self.runner.further.done():
            self.act(self._waiting)
            return
        if (
            walk.run_id == self._measured
            or simulation.steps == 0
            or not walk.finished(simulation)
            or self._push_goes_on()
        ):
            return
        if walk.ends:
            session.control.halt.set("lesson")
        if not walk.showing and walk.phase is not Phase.DO and walk.challenge is None:
            # The run is shown again; it was measured before.
            self._measured = walk.run_id
            self._show_moment()
            return
        if not self.runner.further.done():
            return
        self._measured = walk.run_id
        if walk.challenge is None:
            if walk.step.measurements:
                self.runner.observe(walk)
            elif not walk.yours:
                walk.next()
        elif walk.ends and walk.challenge.criteria:
            self.runner.check(walk, self.said)
        self._follow()
        self._show_moment()

    def _push_goes_on(self) -> bool:
        """A push begins when the hand is taken; an untouched hand restarts the run."""
        simulation, seconds = self.session.simulation, self.walk.setup.seconds
        if self._taken is None and self.walk.pushes and simulation.time > PATIENCE:
            self._begin(True)
        return self.walk.pushes and (self._taken is None or simulation.time < self._taken + seconds)

    def _left_pace(self) -> bool:
        """Return to an open step before another is seen, answered or run; true if necessary."""
        walk, pace, here = self.walk, self.pace, (self.walk.lesson.id, self.walk.step_index)
        if pace is None or pace.allows(*here):
            self._stood = here
            return False
        walk.go(*(self._stood if pace.allows(*self._stood) else (pace.lesson, pace.nearest(*here))))
        self.session.notify("Your teacher has not opened this step", pace.words)
        return True

    def _show_moment(self) -> None:
        walk = self.walk
        if walk.run_id == self._measured and (mark := walk.decisive(self.session.simulation)) is not None:
            self.session.player.review(mark.time, mark)
            self.session.parts.of(BackgroundStudies).microscope.go_to(
                mark.time - self.session.settings.run.dt
            )

    def vary(self, query: Mapping[str, str]) -> None:
        for key, value in query.items():
            if key in specs(RunSettings):
                self._guarded(lambda key=key, value=value: self.session.change(key, value))

    def _follow(self) -> None:
        if self.open:
            self._left_pace()
        self.version += 1
        if self.open and self.walk.run_id != self._run_id:
            self._begin()

    def _begin(self, own_settings: bool = False) -> None:
        walk = self.walk
        self._run_id, self._measured, self._taken = walk.run_id, -1, None
        self.runner.begin(walk, own_settings)
        self.session.player.leave()
        self.version += 1

    # ---- what is shown -----------------------------------------------------------------------------------------------------

    def link(self, query: dict[str, str]) -> dict[str, str]:
        if not self.open:
            return query
        query = to_query(self.session.settings, self.walk.setup.settings(Settings()))
        query = {key: text for key, text in query.items() if key not in OF_STEPS}
        return {
            "lesson": self.walk.lesson.id,
            "step": str(self.walk.lesson.steps.index(self.walk.step) + 1),
            **query,
        }

    def begin_with(self, english: LessonBook, language: Language) -> None:
        self.english, self.book = english, english.in_language(language)

    def read_again(self, english: LessonBook, language: Language) -> None:
        saved, self.english = self.saved_lesson(), english
        self._forget(english.in_language(language))
        if saved is not None:
            self.resume(saved, reopen=True)

    def translate(self, book: LessonBook) -> None:
        self.book = book
        if self._walk is not None:
            self._walk.translate(book)
        self.version += 1

    @property
    def own_tests(self) -> ExaminationProgress | None:
        """None if the step asks for no custom law."""
        return tests_of(self.session) if self.open and asks_for_custom_law(self.walk) else None

    def live(self, simulation: Simulation, book: LessonBook | None = None) -> tuple[tuple[str, str], ...]:
        """Labels and values. `book`: None for the session's language."""
        language = self.walk.in_book(book).lesson.language
        try:
            return tuple(
                (label_of(m, language), words_of(language)(m.text(value)))
                for m, value in self.walk.live(simulation)
            )
        except Exception as error:
            self._errors.exception("the numbers of a lesson could not be measured", error)
            return ()
