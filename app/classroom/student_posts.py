"""Where what a student hands in goes: to the teacher's control, or from another process to the stage's."""

from typing import Protocol

from app.classroom.class_messages import Progressed, Reported, TakenBack
from app.classroom.classroom import Classroom
from app.classroom.student_work import clean_name
from app.export.class_summary import HandIn
from app.hosting.worker_link import WorkerLink
from app.session.action_queue import ActionQueue


class StudentPosts(Protocol):
    """Takes what students hand in; from any thread. `student`: id of the tab; `progress`: of the student's own session, as JSON."""

    def post_progress(self, student: str, progress: str) -> None: ...

    def post_hand_in(self, student: str, name: str, progress: str = "") -> None:
        """Hand in a report. `name`: "" for none."""
        ...

    def post_take_back(self, student: str) -> None:
        """Delete a report."""
        ...


class PostsToStage:
    """Sends what students hand in to the stage's process, and keeps it in this process for their pages.

    Args:
        room: of this process.

    Attributes:
        queue: what the thread that `room` belongs to has to do.
    """

    def __init__(self, link: WorkerLink, room: Classroom) -> None:
        self._link, self._room = link, room
        self.queue = ActionQueue()

    def post_progress(self, student: str, progress: str) -> None:
        self._link.to_stage(Progressed(student, progress))
        self.queue.put(lambda: self._room.work.note(student, progress), (student, "progress"))

    def post_hand_in(self, student: str, name: str, progress: str = "") -> None:
        self._link.to_stage(Reported(student, name, progress))
        self.queue.put(lambda: self._hand_in(student, name, progress), (student, "report"))

    def _hand_in(self, student: str, name: str, progress: str) -> None:
        # The stage makes the whole report; the student's page shows that there is one.
        self._room.work.hand_in(student, HandIn(clean_name(name), progress))

    def post_take_back(self, student: str) -> None:
        self._link.to_stage(TakenBack(student))
        self.queue.put(lambda: self._room.work.take_back(student), (student, "report"))
