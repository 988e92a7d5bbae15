"""The breakout sessions that run in other processes, as the stage sees them."""

from collections.abc import Callable
from itertools import count

from app.classroom.class_messages import ClassState, Exploring, Present, Progressed, Reported, TakenBack
from app.classroom.classroom import Classroom
from app.classroom.student_posts import StudentPosts
from app.hosting.visitor_record import VisitorRecord
from app.hosting.worker_link import WorkerLink
from app.hosting.worker_process import Replaced
from app.page.panels.server_load import ServerLoad, combined


class BreakoutWorkers:
    """Sends students to other processes, and knows who is there. Belongs to the stage's thread.

    Args:
        room: in which the students are present.
        posts: takes what they hand in.
    """

    def __init__(self, link: WorkerLink, room: Classroom, posts: StudentPosts, changed: Callable[[], None]) -> None:
        self._link, self._room, self._posts, self._changed = link, room, posts, changed
        self._present: dict[int, Present] = {}
        self._numbers = count(-1, -1)
        self._entered: dict[str, int] = {}
        self._said: ClassState | None = None

    @property
    def students(self) -> tuple[str, ...]:
        """Return the students who are there."""
        return tuple(self._entered)

    def load(self, stage: ServerLoad) -> ServerLoad:
        """Return the load of all processes; that of the stage has room for nothing else."""
        return combined([stage._replace(places=1), *(present.load for present in self._present.values())])

    def send(self, student: str, begin: VisitorRecord) -> None:
        """Have a student's next connection come to a session in another process; see `Exploring`."""
        work = self._room.work
        self._link.to_tab(student, Exploring(student, begin, self._room.has_work(student), work.handed_in(student)))

    def exchange(self) -> None:
        """Take what the other processes say, and let them know what the teacher has decided."""
        for message in self._link.received():
            match message:
                case Present(worker):
                    self._present[worker] = message
                    self._update()
                case Replaced(worker):
                    self._present.pop(worker, None)
                    self._update()
                case Progressed(student, progress):
                    self._posts.post_progress(student, progress)
                case Reported(student, name, progress):
                    self._posts.post_hand_in(student, name, progress)
                case TakenBack(student):
                    self._posts.post_take_back(student)
                case _:
                    raise TypeError(f"the stage does not understand {message!r}")
        state = ClassState(self._room.free, self._room.paused)
        if state != self._said:
            self._said = state
            if not state.free:
                self._link.forget_tabs()
            self._link.to_all(state)

    def _update(self) -> None:
        here = {student for present in self._present.values() for student in present.students}
        for student in [student for student in self._entered if student not in here]:
            self._room.leave(self._entered.pop(student))
        for student in sorted(here - self._entered.keys()):
            # Ids of connections to this process are 0 or more.
            self._entered[student] = next(self._numbers)
            self._room.enter(self._entered[student], student)
        self._changed()
