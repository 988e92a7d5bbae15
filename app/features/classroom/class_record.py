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
        saved: [s since 1970].
        ballots: of the last round, by tab id.
        students: tabs that do not lead.
        earlier: oldest round first.
        passed: tabs that passed a step's challenge.
        hand_ins, names: reports and invented names by tab id.
        nearest: smallest d − d_m of the class in a duel [m].
        pages_only, pageless, groups: see `Ballots` and `BreakoutPlaces`.
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
    """None if the class has ended."""
    return part_of(record, _CLASS, ClassRecord)


def last_class_of(record: VisitorRecord) -> ClassSummary | None:
    return part_of(record, _LAST_CLASS, ClassSummary)


def interrupted(store: SessionStore) -> VisitorRecord | None:
    """Shared session interrupted less than `AWAY` ago, or None. Waits for the disk."""
    record = store.named(NAME)
    room = None if record is None else class_of(record)
    return record if room is not None and abs(time() - room.saved) < AWAY else None
