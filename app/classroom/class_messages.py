"""What the stage of a lecture and its breakout sessions in other processes say to each other."""

from typing import NamedTuple

from app.export.class_summary import HandIn
from app.hosting.visitor_record import VisitorRecord
from app.page.panels.server_load import ServerLoad


class Exploring(NamedTuple):
    """A student gets a breakout session.

    Attributes:
        begin: where a student begins who has left nothing in the store.
        worked: whether the student has done something that can be handed in.
        report: that is handed in; None for none.
    """

    student: str
    begin: VisitorRecord
    worked: bool
    report: HandIn | None


class ClassState(NamedTuple):
    """What the teacher has decided; see `app.classroom.classroom.Classroom`."""

    free: bool
    paused: bool


class Present(NamedTuple):
    """The students that a process has now, and how busy it is. `worker`: its index."""

    worker: int
    students: tuple[str, ...]
    load: ServerLoad


class Progressed(NamedTuple):
    """A student's progress, as JSON."""

    student: str
    progress: str


class Reported(NamedTuple):
    """A student hands in a report; see `app.classroom.teacher_control.TeacherControl.post_hand_in`."""

    student: str
    name: str
    progress: str


class TakenBack(NamedTuple):
    """A student takes the report back."""

    student: str
