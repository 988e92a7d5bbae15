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
    """A student gets a breakout session. `begin`: its record if none is saved."""

    student: str
    begin: VisitorRecord
    worked: bool
    report: HandIn | None
    name: str
    group: str


class ClassState(NamedTuple):
    """The teacher's decisions, as in `Classroom`."""

    free: bool
    paused: bool
    pace: OpenSteps | None
    wanted: str


class Present(NamedTuple):
    """Students and load of process `worker`."""

    worker: int
    students: tuple[str, ...]
    load: ServerLoad


class Progressed(Action, newest_by=("student",)):
    """Progress in a breakout session, as JSON. `student`: the group."""

    student: str
    progress: str


class Reported(Action, newest_by=("student",)):
    """A report is handed in (`name` "" if anonymous) or withdrawn (`name` None). `progress`: of the own
    session, as JSON.
    """

    student: str
    name: str | None
    progress: str = ""


class Ran(Action, newest_by=("student",), eq=False):
    """Newest part of a run; None before it begins. `student`: the group."""

    student: str
    recorded: Recorded | None


WorkAction = Progressed | Reported | Ran


PostWork = Callable[[WorkAction], None]
"""Queues work for the next frame; thread-safe."""
