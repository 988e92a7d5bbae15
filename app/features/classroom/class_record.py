"""What a class would lose with its server, as parts of the record of its shared session."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from time import time
from typing import Final

from app.features.classroom.class_summary import ClassSummary, HandIn
from app.features.lessons.bookmark import OpenSteps
from app.features.lessons.tally import Ballot, QuestionId
from app.features.store.session_store import SessionStore
from app.hosting.parking import AWAY
from app.hosting.visitor_record import VisitorRecord, part_of, with_part

NAME: Final = "lecture"
"""Name of the shared session's record in the store."""

_CLASS, _LAST_CLASS = "room", "last_class"
"""Names of the parts, which earlier releases have given them."""


@dataclass(frozen=True, kw_only=True)
class ClassRecord:
    """What a class would lose with its server, besides the shared session.

    Attributes:
        saved: when it was so [s since 1970].
        ballots: question → id of a student's tab → what was handed in.
        revealed: the questions with a tally that everybody sees.
        free: whether the students explore.
        leader: id of the tab that leads; None while no tab leads.
        students: ids of the tabs that do not lead.
        earlier: question → the ballots of its rounds before the newest one, oldest first.
        passed: lesson and step → ids of the tabs that have passed the challenge.
        hand_ins: the reports that were handed in, by the id of a student's tab.
        pages_only, pageless: see `app.features.classroom.ballots.Ballots`.
        names, pace: the invented names by the id of a student's tab, and the steps that are open to those who explore.
        nearest: lesson and step of a duel → the smallest d less d_m of the class [m].
        groups: see `app.features.classroom.breakout_places.BreakoutPlaces`.
    """

    saved: float = 0.0
    ballots: Mapping[QuestionId, Mapping[str, Ballot]] = field(default_factory=dict)
    revealed: tuple[QuestionId, ...] = ()
    free: bool = False
    leader: str | None = None
    students: tuple[str, ...] = ()
    earlier: Mapping[QuestionId, tuple[Mapping[str, Ballot], ...]] = field(default_factory=dict)
    passed: Mapping[QuestionId, tuple[str, ...]] = field(default_factory=dict)
    hand_ins: Mapping[str, HandIn] = field(default_factory=dict)
    pages_only: bool = False
    pageless: tuple[str, ...] = ()
    names: Mapping[str, str] = field(default_factory=dict)
    pace: OpenSteps | None = None
    nearest: Mapping[QuestionId, float] = field(default_factory=dict)
    groups: Mapping[str, str] = field(default_factory=dict)


NEW_CLASS: Final = ClassRecord()
"""A class that has done nothing yet."""


def with_class(record: VisitorRecord, room: ClassRecord | None, last: ClassSummary | None) -> VisitorRecord:
    """Record of a shared session with its class, and with the summary of the class before."""
    return with_part(with_part(record, _CLASS, room), _LAST_CLASS, last)


def class_of(record: VisitorRecord) -> ClassRecord | None:
    """Class of a shared session; None if it has ended."""
    return part_of(record, _CLASS, ClassRecord)


def last_class_of(record: VisitorRecord) -> ClassSummary | None:
    """Summary of the class before; None if there was no other."""
    return part_of(record, _LAST_CLASS, ClassSummary)


def interrupted(store: SessionStore) -> VisitorRecord | None:
    """Shared session that broke off less than `AWAY` ago, which goes on; None otherwise. Waits for the disk."""
    record = store.named(NAME)
    room = None if record is None else class_of(record)
    return record if room is not None and abs(time() - room.saved) < AWAY else None
