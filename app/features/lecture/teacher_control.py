"""Carries out the teacher's actions and takes the students' answers, in the plenary."""

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
    Literal["follow", "free", "pause", "reveal", "again", "pages", "quote", "expect", "invite", "invite all", "hide"]
    | Literal["show", "show run", "pace"]
    | ScreenAction
)
"""The teacher's actions for the class: all students to the plenary or to breakout sessions, pause or resume, reveal the answers, ask again,
leave out or count votes without a page, put reasons on the screen, say how many are expected, show the address on the screen or on all
pages, or nowhere; for those who explore: the answer of a student on the projector, or the run, and which steps are open."""

EVERY_PRESS: Final[frozenset[TeacherAction]] = frozenset({"on", "back", "pause", "pages", "freeze", "blank"})
"""Steps, and what is switched on and off: two presses between two frames are two."""


class Teach(Action, newest_by=("what",)):
    """Do what a teacher asks for. `value`: the name or the text that belongs to it."""

    what: TeacherAction
    value: str = ""

    @property
    def control(self) -> Hashable:
        return None if self.what in EVERY_PRESS else super().control


class Answer(Action, newest_by=("student",)):
    """Take a student's answer, from 0. `student`: id of the tab."""

    student: str
    choice: int


class Because(Action, newest_by=("student", "question")):
    """Take the reason of a student's answer to a question."""

    student: str
    question: QuestionId
    reason: str


class TeacherControl:
    """All methods but those that post belong to the plenary's thread.

    Attributes:
        classroom, session, lessons: the class, and the plenary's.
        answers: the students' answers, and what they hand in; they are done before the teacher's actions, and are not lost with the
            teacher's tab.
        presenter: what the projectors show.
        refused: why the steps that the teacher has typed last are none of the lesson's; "" where they are.
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
        """Return the question in the plenary; None if there is none. `book`: the lessons in the reader's language; None for its own."""
        return self.classroom.poll(self._walk, book)

    @property
    def record(self) -> float | None:
        """Return the smallest d less d_m of the students' pushes in the plenary's duel [m]; None where there is none."""
        walk = self._walk
        return None if walk is None or not walk.duel else self.classroom.work.nearest.get((walk.lesson.id, walk.step.id))

    def post(self, action: TeacherAction, value: str = "") -> None:
        """Queue an action of the teacher's for the next frame; from any thread. `value`: see `Teach`."""
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
                    # A text that names no steps changes nothing, and is answered.
                    self.refused = str(error)
            case "quote":
                poll, numbers = self.poll(), map(int, re.findall(r"\d{1,4}", value))
                reasons = {} if poll is None else classroom.ballots.reasons(poll.question)
                presenter.quotes = tuple(reasons[number][1] for number in numbers if number in reasons)[:MOST_QUOTES]
            case "expect":
                presenter.expected = int(value)
            case "invite":
                # Where there is no projector, on the teacher's page.
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
        """Make the projectors follow the plenary; once a frame."""
        poll, presenter, player = self.poll(), self.presenter, self.session.player
        presenter.follow(self._walk, poll is not None and poll.revealed, not self.session.paused)
        runs = presenter.work is not None and presenter.work.run
        if self._replayed and not (runs and player.loaded == self._replayed):
            # Page ↓ ends the student's run, and so does the teacher's own button of the replay.
            if player.loaded == self._replayed:
                player.leave()
            presenter.work = None if runs else presenter.work
            self._replayed = ""

    # ---- what one student has done -----------------------------------------------------------------------------------------

    def _show_work(self, student: str | None, run: bool = False) -> None:
        """Show what a student has done in the present step, or that it is the step of the run; None takes it away."""
        self.presenter.uncover()
        if student is not None:
            progress = self.classroom.board.progress_of(student)
            step = progress.lesson, progress.step
            self.presenter.work = ShownWork(step, progress.at(*step), run)

    def _show_run(self, action: Ran) -> None:
        """Replay a student's run on the stage, if the teacher still wants it."""
        player, student, recorded = self.session.player, action.student, action.recorded
        if student != self.classroom.wanted:
            return
        self.classroom.wanted = ""
        if recorded is None:
            self.session.notify("There is nothing to replay yet", "Let it run for a moment.")
            return
        self._show_work(student, run=True)
        self._replayed = tr("a student's run")
        player.watch_file(recorded, self._replayed)

    def _go_on(self) -> None:
        """Show the next station of the step. A projector that is black or frozen, or shows the address, only comes back."""
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
                    # Without a prediction the lesson says that it needs one.
                    lessons.act(Press("run"))
            case Station.RUN if session.paused and not walk.showing and not walk.yours and not walk.finished(session.simulation):
                lessons.act(Press("run"))
            case Station.CHALLENGE:
                presenter.show(Station.TRY)
            case _:
                lessons.act(Press("next"))

    def _go_back(self) -> None:
        """Show the station before; what is revealed stays so."""
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
        """Give the class time to answer the question, which everybody sees then."""
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
        # The prediction that the run is compared with is the class's.
        if poll.tally.curves:
            lessons.act(Draw(*poll.question, median_curve(poll.tally.curves)))
        if favourite is not None:
            lessons.act(Choose(favourite))

    def draw(self, student: str, question: QuestionId, curve: Curve) -> None:
        """Take a student's curve for a question, as long as that takes answers."""
        self.classroom.draw(self._walk, student, question, curve)
