"""Carries out the teacher's actions and takes the students' answers, on the stage."""

from collections.abc import Callable

from app.classroom.classroom import Classroom, Poll
from app.classroom.teacher_panel import Action
from app.lessons.curve_drawing import median_curve
from app.lessons.lesson import LessonBook
from app.lessons.session.lesson_actions import Choose, Draw, ResetStep
from app.lessons.session.lesson_session import LessonSession
from app.lessons.tally import QuestionId
from app.lessons.walkthrough import Walkthrough
from app.plots.curve_chart import Curve
from app.session.action_queue import ActionQueue
from app.session.session import Session


class TeacherControl:
    """All methods but those that post belong to the stage's thread.

    Args:
        decided: called after every action.

    Attributes:
        answers: the students' answers; they are done before the teacher's actions, and are not lost with the teacher's tab.
    """

    def __init__(self, room: Classroom, session: Session, lessons: LessonSession, decided: Callable[[], None]) -> None:
        self._room, self._session, self._lessons, self._decided = room, session, lessons, decided
        self.answers = ActionQueue()

    @property
    def _walk(self) -> Walkthrough | None:
        return self._lessons.walk if self._lessons.open else None

    def poll(self, book: LessonBook | None = None) -> Poll | None:
        """Return the question on the stage; None if there is none. `book`: the lessons in the reader's language; None for the stage's."""
        return self._room.poll(self._walk, book)

    def post(self, action: Action) -> None:
        """Queue an action of the teacher's for the next frame; from any thread."""
        self._session.post(lambda: self._act(action), ("teacher", action))

    def post_answer(self, student: str, choice: int) -> None:
        """Queue a student's answer for the next frame; from any thread. `student`: id of the tab."""
        self.answers.put(lambda: self._answer(student, choice), student)

    def post_progress(self, student: str, progress: str) -> None:
        """Queue the progress of a student's own session, as JSON; from any thread."""
        self.answers.put(lambda: self._room.work.note(student, progress), (student, "progress"))

    def post_hand_in(self, student: str, name: str, progress: str = "") -> None:
        """Queue a student's report; from any thread. `name`: "" for none; `progress`: of the student's own session, as JSON."""
        self.answers.put(lambda: self._hand_in(student, name, progress), (student, "report"))

    def post_take_back(self, student: str) -> None:
        """Queue that a student's report is deleted; from any thread."""
        self.answers.put(lambda: self._room.work.take_back(student), (student, "report"))

    def _hand_in(self, student: str, name: str, progress: str) -> None:
        self._room.hand_in(self._lessons.walk if self._lessons.begun else None, student, name, progress)

    def _act(self, action: Action) -> None:
        room = self._room
        match action:
            case "follow":
                room.follow()
            case "free":
                room.free = True
            case "pause":
                room.paused = not room.paused
                self._session.halt.set("class", room.paused)
            case "reveal":
                self._reveal()
            case "again":
                self._ask_again()
            case "invite":
                room.inviting = not room.inviting
        self._decided()

    def _reveal(self) -> None:
        poll, lessons = self.poll(), self._lessons
        if poll is None or poll.revealed or not poll.tally.answered:
            return
        self._room.ballots.reveal(poll.question)
        favourite = poll.tally.favourite
        if not lessons.locked:
            return
        # The prediction that the run is compared with is the class's.
        if poll.tally.curves:
            lessons.act(Draw(*poll.question, median_curve(poll.tally.curves)))
        if favourite is not None:
            lessons.act(Choose(favourite))

    def _ask_again(self) -> None:
        poll = self.poll()
        if poll is not None:
            self._room.ballots.ask_again(poll.question)
            self._lessons.act(ResetStep())

    def draw(self, student: str, question: QuestionId, curve: Curve) -> None:
        """Take a student's curve."""
        self._room.draw(self._walk, student, question, curve)

    def _answer(self, student: str, choice: int) -> None:
        self._room.answer(self._walk, student, choice)
