"""What the processes of a lecture say to each other: the plenary's and those with breakout sessions; and where a student's work goes."""

from collections.abc import Callable, Hashable
from typing import NamedTuple

from app.classroom.classroom import Classroom
from app.classroom.student_work import clean_name
from app.export.class_summary import HandIn
from app.hosting.visitor_record import VisitorRecord
from app.hosting.worker_messages import WorkerLink
from app.lessons.open_steps import OpenSteps
from app.page.panels.server_load import ServerLoad
from app.session.actions import Action, ActionQueue
from scenes.inputs import Recorded


class Exploring(NamedTuple):
    """A student gets a breakout session.

    Attributes:
        begin: where a student begins who has left nothing in the store.
        worked: whether the student has done something that can be handed in.
        report: that is handed in; None for none.
        name: the invented one.
        group: that has the session.
    """

    student: str
    begin: VisitorRecord
    worked: bool
    report: HandIn | None
    name: str
    group: str


class ClassState(NamedTuple):
    """What the teacher has decided; see `app.classroom.classroom.Classroom`."""

    free: bool
    paused: bool
    pace: OpenSteps | None
    wanted: str


class Present(NamedTuple):
    """The students that a process has now, and how busy it is. `worker`: its index."""

    worker: int
    students: tuple[str, ...]
    load: ServerLoad


class Progressed(Action, newest_by=("student",)):
    """The progress in a breakout session, as JSON. `student`: the group."""

    student: str
    progress: str


class Reported(Action, newest_by=("student",)):
    """A student hands in a report. `name`: "" for none; `progress`: of the student's own session, as JSON."""

    student: str
    name: str
    progress: str = ""


class TakenBack(Action):
    """A student takes the report back."""

    student: str

    @property
    def control(self) -> Hashable:
        return Reported(self.student, "").control


class Ran(Action, newest_by=("student",), eq=False):
    """The newest part of the run that the teacher wants to show. `student`: the group; `recorded`: None where it has not begun."""

    student: str
    recorded: Recorded | None


WorkAction = Progressed | Reported | TakenBack | Ran
"""What comes from a student's own session; `student`: id of the tab."""


PostWork = Callable[[WorkAction], None]
"""Queues what a student hands in, or shows, for the next frame; from any thread."""


class PostsToPlenary:
    """Sends what students hand in to the plenary's process, and keeps it in this process for their pages.

    Args:
        classroom: of this process.

    Attributes:
        queue: what the thread that `classroom` belongs to has to do.
    """

    def __init__(self, link: WorkerLink, classroom: Classroom) -> None:
        self._link, self._classroom = link, classroom
        self.queue = ActionQueue(self._handle)

    def post_work(self, work: WorkAction) -> None:
        self._link.to_plenary(work)
        self.queue.put(work)

    def _handle(self, action: Action) -> None:
        match action:
            case Progressed(student, progress):
                self._classroom.work.note(student, progress)
            case Reported(student, name, progress):
                # The plenary makes the whole report; the student's page shows that there is one.
                self._classroom.work.hand_in(student, HandIn(clean_name(name), progress))
            case TakenBack(student):
                self._classroom.work.hand_ins.pop(student, None)
            case _:
                raise TypeError(f"nothing here does {action!r}")
