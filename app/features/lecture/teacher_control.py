"""Performs the teacher's actions, and receives the students' answers."""

import re
from collections.abc import Hashable
from time import monotonic
from typing import Final, Literal

from app.features.classroom.classroom import Classroom, Poll
from app.features.lecture.class_messages import Progressed, Ran, Reported
from app.features.lecture.presenter import MOST_QUOTES, TIMERS, Presenter, ScreenAction, ShownWork, Station
from app.features.lessons.bookmark import open_steps_from_text
from app.features.lessons.curve_drawing import median_curve
from app.features.lessons.lesson import LessonBook
from app.features.lessons.session.lesson_actions import Choose, Draw, Press
from app.features.lessons.session.lesson_session import LessonSession
from app.features.lessons.tally import QuestionId
from app.features.lessons.walkthrough import Walkthrough
from app.i18n.speaking import tr
from app.page.panels.drawing_board import TakeDrawing
from app.plots.curve_chart import Curve
from app.session.action_handlers import ActionHandlers
from app.session.actions import Action, ActionQueue
from app.session.session import Session
from controllers.errors import BadSetting

TeacherAction = (
    Literal[
        "follow",
        "free",
        "pause",
        "reveal",
        "again",
        "pages",
        "quote",
        "expect",
        "invite",
        "invite all",
        "hide",
    ]
    | Literal["show", "show run", "pace"]
    | ScreenAction
)
"""follow, free: shared or breakout sessions. pages: count votes without a page or not. quote: show reasons.
pace: open steps.
"""

EVERY_PRESS: Final[frozenset[TeacherAction]] = frozenset({"on", "back", "pause", "pages", "freeze", "blank"})
"""Steps and toggles: two presses between frames count twice."""


class Teach(Action, newest_by=("what",)):
    """A teacher's action. `value`: a name or text."""

    what: TeacherAction
    value: str = ""

    @property
    def control(self) -> Hashable:
        return None if self.what in EVERY_PRESS else super().control


class Answer(Action, newest_by=("student",)):
    """A student's answer (0-based). `student`: id of the tab."""

    student: str
    choice: int


class Because(Action, newest_by=("student", "question")):
    """A student's reason for an answer."""

    student: str
    question: QuestionId
    reason: str


class TeacherControl:
    """Belongs to the shared session's thread, except `post` and `answers.put`.

    Attributes:
        answers: of students, processed before the teacher's actions; they survive the teacher's tab.
        refused: why the typed steps are invalid, or "".
    """

    def __init__(self, classroom: Classroom, session: Session, lessons: LessonSession) -> None:
        self.classroom, self.session, self.lessons = classroom, session, lessons
        handlers = self._of_students = ActionHandlers()
        handlers.add(Answer, self._take_answer)
        handlers.add(Because, self._take_reason)
        handlers.add(TakeDrawing, lambda action: action.board.take(action.text))
        handlers.add(Progressed, lambda action: classroom.note(action.student, action.progress, monotonic()))
        handlers.add(Ran, self._show_run)
        handlers.add(Reported, self._hand_in)
        self.answers = ActionQueue(handlers.do)
        self.presenter = Presenter()
        self._replayed = self.refused = ""
        session.handlers.add(Teach, self._act)

    @property
    def _walk(self) -> Walkthrough | None:
        return self.lessons.walk if self.lessons.open else None

    def poll(self, book: LessonBook | None = None) -> Poll | None:
        """See `Classroom.poll`."""
        return self.classroom.poll(self._walk, book)

    @property
    def record(self) -> float | None:
        """Smallest d − d_m of the students' pushes in a duel [m], or None."""
        walk = self._walk
        return (
            None
            if walk is None or not walk.duel
            else self.classroom.work.nearest.get((walk.lesson.id, walk.step.id))
        )

    def post(self, action: TeacherAction, value: str = "") -> None:
        """Queue an action for the next frame; thread-safe."""
        self.session.post(Teach(action, value))

    def _take_answer(self, action: Answer) -> None:
        self.classroom.answer(self._walk, action.student, action.choice)

    def _take_reason(self, action: Because) -> None:
        self.classroom.give_reason(self._walk, action.student, action.question, action.reason)

    def _hand_in(self, action: Reported) -> None:
        if action.name is None:
            self.classroom.work.hand_in(action.student, None)
        else:
            walk = self.lessons.walk if self.lessons.begun else None
            self.classroom.hand_in(walk, action.student, action.name, action.progress)

    def _act(self, action: Teach) -> None:
        classroom, presenter, what, value = self.classroom, self.presenter, action.what, action.value
        match what:
            case "follow":
                classroom.follow()
            case "free":
                classroom.explore()
            case "pause":
                classroom.paused = not classroom.paused
                self.session.control.halt.set("class", classroom.paused)
            case "reveal":
                self._reveal()
            case "again":
                if (poll := self.poll()) is not None:
                    classroom.ballots.ask_again(poll.question)
                    self.lessons.act(Press("reset"))
            case "pages":
                classroom.ballots.count_pages_only(not classroom.ballots.pages_only)
            case "show":
                self._show_work(classroom.board.student_of(value))
            case "show run":
                student = classroom.board.student_of(value)
                classroom.wanted = student if student in classroom.groups else ""
            case "pace":
                try:
                    classroom.pace, self.refused = open_steps_from_text(value, self.lessons.walk.lesson), ""
                except BadSetting as error:
                    # A text without valid steps changes nothing, and gets an answer.
                    self.refused = str(error)
            case "quote":
                poll, numbers = self.poll(), map(int, re.findall(r"\d{1,4}", value))
                reasons = {} if poll is None else classroom.ballots.reasons(poll.question)
                presenter.quotes = tuple(reasons[number][1] for number in numbers if number in reasons)[
                    :MOST_QUOTES
                ]
            case "expect":
                presenter.expected = int(value)
            case "invite":
                # Without a projector, on the teacher's page.
                presenter.inviting = "screens" if presenter.screens else "teachers"
            case "invite all":
                presenter.inviting = "all"
            case "hide":
                presenter.inviting = ""
            case "on":
                self._go_on()
            case "back":
                self._go_back()
            case "live":
                presenter.uncover()
            case "freeze":
                presenter.frozen = not presenter.frozen
            case "blank":
                presenter.blank = not presenter.blank
            case "stage" | "panels":
                presenter.panels = what == "panels"
            case _:
                self._start_timer(TIMERS[what])

    # ---- the projector -----------------------------------------------------------------------------------------------------

    def present(self) -> None:
        poll, presenter, player = self.poll(), self.presenter, self.session.player
        presenter.follow(self._walk, poll is not None and poll.revealed, not self.session.paused)
        runs = presenter.work is not None and presenter.work.run
        if self._replayed and not (runs and player.loaded == self._replayed):
            # Page ↓ ends the student's run, and so does the replay's button.
            if player.loaded == self._replayed:
                player.leave()
            presenter.work = None if runs else presenter.work
            self._replayed = ""

    # ---- what one student has done -----------------------------------------------------------------------------------------

    def _show_work(self, student: str | None, run: bool = False) -> None:
        """`student`: None hides the work."""
        self.presenter.uncover()
        if student is not None:
            progress = self.classroom.board.progress_of(student)
            step = progress.lesson, progress.step
            self.presenter.work = ShownWork(step, progress.at(*step), run)

    def _show_run(self, action: Ran) -> None:
        player, student, recorded = self.session.player, action.student, action.recorded
        if student != self.classroom.wanted:
            return
        self.classroom.wanted = ""
        if recorded is None:
            self.session.notify("There is nothing to replay yet", "Run it for a moment.")
            return
        self._show_work(student, run=True)
        self._replayed = tr("a student's run")
        player.watch_file(recorded, self._replayed)

    def _go_on(self) -> None:
        presenter, walk, lessons, session = self.presenter, self._walk, self.lessons, self.session
        if presenter.uncover() or walk is None:
            return
        poll = self.poll()
        match presenter.station:
            case Station.SCENE if poll is not None:
                presenter.show(Station.QUESTION)
            case Station.QUESTION if poll is not None and poll.revealed:
                presenter.show(Station.ANSWERS)
            case Station.QUESTION if poll is not None and poll.tally.handed_in:
                self._reveal()
            case Station.QUESTION | Station.ANSWERS if walk.step.concept:
                lessons.act(Press("next"))
            case Station.SCENE | Station.QUESTION | Station.ANSWERS:
                presenter.show(Station.RUN if not walk.locked or walk.done.predicted else presenter.station)
                if session.paused:
                    # Without a prediction the lesson asks for one.
                    lessons.act(Press("run"))
            case Station.RUN if (
                session.paused
                and not walk.showing
                and not walk.yours
                and not walk.finished(session.simulation)
            ):
                lessons.act(Press("run"))
            case Station.CHALLENGE:
                presenter.show(Station.TRY)
            case _:
                lessons.act(Press("next"))

    def _go_back(self) -> None:
        """Show the previous station; what is revealed stays revealed."""
        presenter, walk, lessons = self.presenter, self._walk, self.lessons
        if presenter.uncover() or walk is None:
            return
        poll = self.poll()
        match presenter.station:
            case Station.ANSWERS:
                presenter.show(Station.QUESTION)
            case Station.QUESTION:
                presenter.show(Station.SCENE)
            case Station.RUN if poll is not None and not walk.showing:
                if not self.session.paused:
                    lessons.act(Press("run"))
                presenter.show(Station.ANSWERS if poll.revealed else Station.QUESTION)
            case Station.TRY:
                presenter.show(Station.CHALLENGE)
            case _:
                lessons.act(Press("back"))

    def _start_timer(self, seconds: int) -> None:
        poll = self.poll()
        if poll is None or not poll.open:
            seconds = 0
        elif self.presenter.station is Station.SCENE and seconds:
            self.presenter.show(Station.QUESTION)
        self.presenter.start_timer(seconds)

    # ---- the question ------------------------------------------------------------------------------------------------------

    def _reveal(self) -> None:
        poll, lessons = self.poll(), self.lessons
        if poll is None or poll.revealed or not poll.tally.handed_in:
            return
        self.classroom.ballots.reveal(poll.question)
        favourite = poll.tally.favourite
        if not lessons.locked:
            return
        # The class's prediction is compared with the run.
        if poll.tally.curves:
            lessons.act(Draw(*poll.question, median_curve(poll.tally.curves)))
        if favourite is not None:
            lessons.act(Choose(favourite))

    def draw(self, student: str, question: QuestionId, curve: Curve) -> None:
        self.classroom.draw(self._walk, student, question, curve)
