"""Messages between the processes of a lecture."""

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
        begin: initial record of a student without a saved one.
    """

    student: str
    begin: VisitorRecord
    worked: bool
    report: HandIn | None
    name: str
    group: str


class ClassState(NamedTuple):
    """The teacher's decisions; see `app.features.classroom.classroom.Classroom`."""

    free: bool
    paused: bool
    pace: OpenSteps | None
    wanted: str


class Present(NamedTuple):
    """Students in a process, and its load. `worker`: its index."""

    worker: int
    students: tuple[str, ...]
    load: ServerLoad


class Progressed(Action, newest_by=("student",)):
    """Progress in a breakout session, as JSON. `student`: the group."""

    student: str
    progress: str


class Reported(Action, newest_by=("student",)):
    """A student hands in a report, or withdraws it.

    Attributes:
        name: "" for an anonymous report; None to withdraw it.
        progress: of the student's own session, as JSON.
    """

    student: str
    name: str | None
    progress: str = ""


class Ran(Action, newest_by=("student",), eq=False):
    """Newest part of the run to show, None if it has not begun. `student`: the group."""

    student: str
    recorded: Recorded | None


WorkAction = Progressed | Reported | Ran
"""Message from a student's own session; `student`: id of the tab."""


PostWork = Callable[[WorkAction], None]
"""Queues a hand-in or a run for the next frame; from any thread."""
