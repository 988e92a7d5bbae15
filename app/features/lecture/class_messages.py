"""What the processes of a lecture say to each other: the plenary's and those with breakout sessions; and what students hand in."""

from collections.abc import Callable
from typing import NamedTuple

from app.features.classroom.class_summary import HandIn
from app.features.lessons.bookmark import OpenSteps
from app.hosting.visitor_record import VisitorRecord
from app.page.panels.server_load import ServerLoad
from app.session.actions import Action
from scenes.inputs import Recorded


class Exploring(NamedTuple):
    """A student gets a breakout session.

    Attributes:
        begin: where a student begins who has left nothing in the store.
        worked: whether the student has done something that can be handed in.
        report: handed in; None if there is no report.
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
    """What the teacher has decided; see `app.features.classroom.classroom.Classroom`."""

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
    """A student hands in a report, or takes it back.

    Attributes:
        name: "" for none; None where the report is taken back.
        progress: of the student's own session, as JSON.
    """

    student: str
    name: str | None
    progress: str = ""


class Ran(Action, newest_by=("student",), eq=False):
    """The newest part of the run that the teacher wants to show. `student`: the group; `recorded`: None where it has not begun."""

    student: str
    recorded: Recorded | None


WorkAction = Progressed | Reported | Ran
"""What comes from a student's own session; `student`: id of the tab."""


PostWork = Callable[[WorkAction], None]
"""Queues what a student hands in, or shows, for the next frame; from any thread."""
