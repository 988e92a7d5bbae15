"""Saved state of a class in its shared session's record."""

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

_CLASS, _LAST_CLASS = "room", "last_class"
"""Names of the parts, from earlier releases."""


@dataclass(frozen=True, kw_only=True)
class ClassRecord:
    """State of a class in addition to its shared session.

    Attributes:
        saved: time [s since 1970].
        ballots: question → tab id → ballot of the last round.
        students: ids of the tabs that do not lead.
        earlier: question → ballots of its earlier rounds, oldest first.
        passed: lesson and step → tabs that passed the challenge.
        hand_ins: reports by tab id.
        pages_only, pageless: see `app.features.classroom.ballots.Ballots`.
        names, pace: invented names by tab id, and open steps for exploring students.
        nearest: lesson and step of a duel → smallest d − d_m of the class [m].
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


def with_class(record: VisitorRecord, room: ClassRecord | None, last: ClassSummary | None) -> VisitorRecord:
    return with_part(with_part(record, _CLASS, room), _LAST_CLASS, last)


def class_of(record: VisitorRecord) -> ClassRecord | None:
    """Class of a shared session; None if it has ended."""
    return part_of(record, _CLASS, ClassRecord)


def last_class_of(record: VisitorRecord) -> ClassSummary | None:
    return part_of(record, _LAST_CLASS, ClassSummary)


def interrupted(store: SessionStore) -> VisitorRecord | None:
    """Shared session interrupted less than `AWAY` ago, to be resumed, or None. Waits for the disk."""
    record = store.named(NAME)
    room = None if record is None else class_of(record)
    return record if room is not None and abs(time() - room.saved) < AWAY else None
