"""What a teacher decides, and what the students answer, put into effect on the stage."""

from collections.abc import Callable

from app.classroom.classroom import Classroom, Poll
from app.classroom.teacher_panel import Action
from app.lessons.lesson import LessonBook
from app.lessons.session.lesson_actions import Choose, ResetStep
from app.lessons.session.lesson_session import LessonSession
from app.lessons.walkthrough import Walkthrough
from app.session.action_queue import ActionQueue
from app.session.session import Session


class TeacherControl:
    """All methods but `post` and `post_answer` belong to the stage's thread.

    Args:
        room: the class.
        session: the stage's.
        lessons: the stage's.
        decided: called after every decision of the teacher's.

    Attributes:
        answers: what the students answer; never behind what the teacher asks for, nor lost with the teacher's tab.
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
        """Do what the teacher decides, in the next frame; from any thread."""
        self._session.post(lambda: self._act(action), ("teacher", action))

    def post_answer(self, who: str, choice: int) -> None:
        """Take a student's answer, in the next frame; from any thread. `who`: the word that the student's tab keeps."""
        self.answers.put(lambda: self._answer(who, choice), who)

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
        self._room.ballots.reveal(poll.place)
        favourite = poll.tally.favourite
        if lessons.locked and favourite is not None:
            # The prediction that the run is compared with is the class's.
            lessons.act(Choose(favourite))

    def _ask_again(self) -> None:
        poll = self.poll()
        if poll is not None:
            self._room.ballots.ask_again(poll.place)
            self._lessons.act(ResetStep())

    def _answer(self, who: str, choice: int) -> None:
        self._room.answer(self._walk, who, choice)
