"""One session on its way through the lessons: in and out, what the visitor does there, and when a run has come to its end.

Everything here belongs to the session's thread, but for the further runs that a step compares with, which another thread makes.
"""

import logging
from collections import deque
from collections.abc import Callable, Mapping

from app.custom_law.examination import NO_FILE, ExaminationProgress
from app.lessons.labels import label_of
from app.lessons.lesson import LessonBook
from app.lessons.phases import Phase
from app.lessons.session.further_runs import FurtherRuns
from app.lessons.session.lesson_settings import asks_for_custom_law, deviation_from_lesson, with_look
from app.lessons.session.saved import SavedLesson
from app.lessons.session.step_runner import StepRunner
from app.lessons.step_view import StepView
from app.lessons.walkthrough import Walkthrough
from app.runtime.throttled_log import ThrottledLog
from app.session.session import Session
from controllers.errors import BadSetting, DuetError
from scenes.inputs import Recorded
from scenes.settings import RunSettings, specs

log = logging.getLogger("duet.lessons")


class LessonSession:
    """The lessons of one session.

    Args:
        session: in which they run.
        book: all lessons.

    Attributes:
        open: whether a lesson is open; otherwise the page is the visitor's own.
        version: goes up whenever something has to be shown anew.
        notes: (title, text) of what the visitor is to be told; whoever shows them takes them out.
    """

    def __init__(self, session: Session, book: LessonBook) -> None:
        self.book, self.open, self.version = book, False, 0
        self.notes: deque[tuple[str, str]] = deque(maxlen=8)
        self._said: dict[tuple[str, str], list[float | None]] = {}
        self._session = session
        self._walk: Walkthrough | None = None
        self._own = session.settings
        self._turn = self._measured = self._troubled = -1
        self._mishaps = ThrottledLog(log)
        self._runs = FurtherRuns()
        self._step_run = StepRunner(session, self._runs, self.notes)
        self._waiting: tuple[str, tuple[object, ...]] | None = None

    # ---- in and out --------------------------------------------------------------------------------------------------------

    @property
    def walk(self) -> Walkthrough:
        """Return the way through the lessons; it outlives their being closed."""
        if self._walk is None:
            self._walk = Walkthrough(self.book)
        return self._walk

    @property
    def begun(self) -> bool:
        """Return whether anything was done in any lesson."""
        walk = self._walk
        return walk is not None and any(
            not walk.done_in(lesson.id, step.id).untouched for lesson in self.book.lessons for step in lesson.steps
        )

    def enter(self, lesson: int | str | None = None, step: int = 0) -> None:
        """Open the lessons where they were left, or at a step. `lesson`, `step`: from 0, or a lesson's name."""
        if not self.book.lessons:
            self.notes.append(("There are no lessons", "The folder of lessons holds none that can be read."))
            return
        try:
            if lesson is not None:
                self.walk.go(lesson, step)
        except BadSetting as error:
            self.notes.append(("This step is not there", str(error)))
        if not self.open:
            self._own = self._session.settings
            self.open = True
        self._turn = -1
        self._guarded(self._follow)

    def leave(self) -> None:
        """Close the lessons: the visitor's own settings are back, and the experiment begins anew with them."""
        if not self.open:
            return
        self._waiting = None
        try:
            self._session.let_custom_law_run(True)
            self._session.invite(None)
            self._step_run.adopt(with_look(self._own, self._session))
            self._session.reset()
        finally:
            self._session.paused, self.open = False, False
            self.version += 1

    def saved(self) -> SavedLesson | None:
        """Return what outlives a connection; None if no lesson was ever opened."""
        if self._walk is None:
            return None
        settings, open_now = self._session.settings, self.open
        said = {step: tuple(numbers) for step, numbers in self._said.items()}
        return SavedLesson(
            self._walk.to_json(),
            self._own if open_now else settings,
            open_now,
            self.seen,
            settings if open_now and not self._showing else None,
            dict(self._walk.kept),
            said,
        )

    def resume(self, saved: SavedLesson, reopen: bool) -> None:
        """Take up what was saved; `reopen`: also where the visitor was."""
        if not self.book.lessons:
            return
        self._walk = Walkthrough.from_json(self.book, saved.progress, saved.kept)
        self._step_run.seen = dict(saved.seen)
        self._said = {step: list(numbers) for step, numbers in saved.said.items()}
        if saved.open and reopen:
            self.enter()
            self._own = saved.own
            if saved.now is not None:
                self._step_run.adopt(with_look(saved.now, self._session))

    # ---- what the visitor does ---------------------------------------------------------------------------------------------

    @property
    def locked(self) -> bool:
        """Return whether Run is locked."""
        return self.open and self.walk.locked

    @property
    def said(self) -> list[float | None]:
        """Return the forecasts that the visitor has typed in the present step; whoever takes them writes them here."""
        return self._said.setdefault((self.walk.lesson.id, self.walk.step.id), [])

    @property
    def _showing(self) -> bool:
        """Return whether the run that shows why is on."""
        return self.walk.view().showing

    @property
    def seen(self) -> Mapping[tuple[str, str], Recorded]:
        """Return the runs in which the visitor saw what came of a step, by lesson and step."""
        return self._step_run.seen

    @property
    def hands_off(self) -> bool:
        """Return whether somebody else moves what the visitor could move."""
        return self.open and not self.walk.yours

    @property
    def computing(self) -> bool:
        """Return whether something waits for a further run."""
        return self._waiting is not None

    def act(self, action: str, *given: object) -> None:
        """Do what a button or a key of the lessons stands for; nothing that is asked at the wrong moment does any harm."""
        if not self.open:
            return
        self._waiting = None
        self._guarded(lambda: self._act(action, given))
        self._guarded(self._follow)

    def _guarded(self, what: Callable[[], None]) -> None:
        try:
            what()
        except DuetError as error:
            self.notes.append(("This is not possible here", str(error)))
        except Exception:
            log.exception("an action of a lesson failed and was left out")
            self.notes.append(("Something went wrong", "It was left out. Reset begins the step anew."))

    def _act(self, action: str, given: tuple[object, ...]) -> None:
        walk, session = self.walk, self._session
        if action in ("next", "check") and not self._runs.ready:
            self._waiting = action, given
            return
        match action:
            case "choose":
                walk.choose(int(str(given[0])))
            case "go":
                walk.go(int(str(given[0])), int(str(given[1])))
            case "next":
                if walk.phase is Phase.DO and walk.yours and walk.step.measurements and walk.finished(session.simulation):
                    self._step_run.observe(walk)
                if not self._hurries():
                    walk.next()
            case "back":
                walk.back()
            case "reset":
                walk.reset()
                self.said.clear()
                self._turn = -1
            case "again":
                self._run_again()
            case "run":
                self._run()
            case "why":
                walk.show_why()
            case "hint":
                walk.hint()
            case "check":
                self._check()
            case "leave":
                self.leave()
            case _:
                log.warning("a lesson knows no action %r", action[:40])

    def _hurries(self) -> bool:
        """Have a run that is to be measured go on to its end as fast as it can, for whoever does not want to wait for it.

        Returns whether it does; where it cannot, the outcome is that of the reference run.
        """
        walk, session = self.walk, self._session
        to_measure = walk.phase is Phase.DO and walk.step.measurements and walk.done.outcome is None and not self._showing
        if not to_measure or walk.yours or session.halted or walk.turn == self._measured or walk.finished(session.simulation):
            return False
        session.hurry(walk.setup.seconds)
        return True

    def _run(self) -> None:
        walk, session = self.walk, self._session
        if walk.locked:
            self.notes.append(("Predict first", "Choose an answer; then the run is free."))
        elif session.paused and not walk.yours and walk.finished(session.simulation):
            self._run_again()
            session.paused = False
        else:
            session.toggle_pause()

    def _run_again(self) -> None:
        self.walk.run_again()
        # A challenge is tried with the student's own settings, and tried again with them.
        self._begin(self.walk.phase is Phase.CHALLENGE)

    def _check(self) -> None:
        if self.walk.phase is Phase.CHALLENGE:
            self._step_run.check(self.walk, self.said)

    # ---- frame by frame ----------------------------------------------------------------------------------------------------

    def frame(self) -> None:
        """Look after the run, once a frame after the session has advanced; never raises."""
        if not self.open:
            return
        try:
            self._frame()
        except DuetError as error:
            self._stop_trouble(str(error))
        except Exception as error:
            self._mishaps.exception("a frame of a lesson failed", error)
            self._stop_trouble("The run could not be measured. Reset begins the step anew; next goes on without it.")

    def _stop_trouble(self, text: str) -> None:
        turn = self.walk.turn
        self._session.paused, self._measured = True, turn
        if self._troubled == turn:
            # Said once for a run, not once for a frame.
            return
        self._troubled = turn
        self.notes.append(("The lesson stopped here", text))
        self.version += 1

    def _frame(self) -> None:
        walk, session = self.walk, self._session
        note = deviation_from_lesson(session, walk)
        if note is not None:
            self.notes.append(note)
            self._begin()
            return
        if walk.locked:
            session.paused = True
        simulation = session.simulation
        walk.watch(simulation)
        if self._step_run.advance_own_tests(walk):
            self.version += 1
        if self._waiting is not None and self._runs.ready:
            action, given = self._waiting
            self.act(action, *given)
            return
        if walk.turn == self._measured or simulation.steps == 0 or not walk.finished(simulation):
            return
        runs_out = self._showing or walk.phase in (Phase.DO, Phase.CHALLENGE)
        if not runs_out:
            return
        if not walk.yours:
            session.paused = True
        if not self._runs.ready:
            return
        self._measured = walk.turn
        if walk.phase is not Phase.CHALLENGE or self._showing:
            if walk.step.measurements:
                self._step_run.observe(walk)
            elif not walk.yours:
                walk.next()
        elif not walk.yours and walk.step.challenge is not None and walk.step.challenge.criteria:
            self._check()
        self._follow()

    def vary(self, query: Mapping[str, str]) -> None:
        """Change settings of the present run as a link asks for."""
        for key, value in query.items():
            if key in specs(RunSettings):
                self._guarded(lambda key=key, value=value: self._session.change(key, value))

    def _follow(self) -> None:
        """Begin the run that the step asks for, if it is another than before."""
        self.version += 1
        if self.open and self.walk.turn != self._turn:
            self._begin()

    def _begin(self, own_settings: bool = False) -> None:
        walk = self.walk
        self._turn, self._measured = walk.turn, -1
        self._step_run.begin(walk, own_settings)
        self.version += 1

    # ---- what is shown -----------------------------------------------------------------------------------------------------

    def translate(self, book: LessonBook) -> None:
        """Go on with the same lessons in another language."""
        self.book = book
        if self._walk is not None:
            self._walk.translate(book)
        self.version += 1

    def view(self, book: LessonBook | None = None) -> StepView:
        """Return everything that is to be shown of the present step. `book`: the lessons in the reader's language; None for these."""
        return self.walk.view(book)

    @property
    def own_tests(self) -> ExaminationProgress | None:
        """Return how far the tests of the visitor's own law are; None where the step does not ask for one."""
        if not self.open or not asks_for_custom_law(self.walk):
            return None
        examination = self._session.examination
        return NO_FILE if examination is None else examination.progress

    @property
    def custom_law_state(self) -> tuple[str, bool]:
        """Return why the visitor's own law is not in force ("" if all is well), and whether its file is gone."""
        return self._session.custom_law_problem, self._session.custom_law_away

    def live(self, book: LessonBook | None = None) -> tuple[tuple[str, str], ...]:
        """Return label and value of the step's numbers, as they are now. `book`: see `view`."""
        language = self.walk.in_book(book).lesson.language
        try:
            return tuple((label_of(m, language), m.text(value)) for m, value in self.walk.live(self._session.simulation))
        except Exception as error:
            self._mishaps.exception("the numbers of a lesson could not be measured", error)
            return ()
