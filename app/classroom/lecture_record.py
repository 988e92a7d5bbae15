"""A lecture outlives a server that breaks off: the stage, the answers and the lead are stored every second."""

from time import time
from typing import Final

from app.classroom.classroom import Classroom
from app.classroom.leader import Leader
from app.hosting.resume import run_again
from app.hosting.session_store import SessionStore
from app.hosting.visitor_record import ClassRecord, VisitorRecord
from app.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.settings import Settings

SAVING: Final = 1.0
"""Time from one record to the next [s]."""


class LectureRecorder:
    """Stores a lecture while it goes on. A lecture that ends by itself leaves nothing.

    Args:
        record: of the lecture that broke off, which goes on here; None for a new one.
    """

    def __init__(
        self,
        store: SessionStore,
        record: VisitorRecord | None,
        stage: tuple[Session, LessonSession],
        room: Classroom,
        leader: Leader,
    ) -> None:
        self._store, (self._session, self._lessons), self._room, self._leader = store, stage, room, leader
        self._save_at = 0.0
        if record is not None and record.room is not None:
            self._restore(record, record.room)

    def _restore(self, record: VisitorRecord, room: ClassRecord) -> None:
        if record.lessons is not None:
            self._lessons.resume(record.lessons, reopen=True)
        for _ in run_again(self._session, self._lessons, record):
            pass
        self._room.ballots.restore(room.ballots, room.revealed)
        self._room.free = room.free
        self._leader.restore(room.leader, room.students)

    def save(self, now: float) -> None:
        """Hand over the lecture every `SAVING`. `now`: wall time [s]."""
        if not self._store.lasting or now < self._save_at:
            return
        self._save_at = now + SAVING
        room = ClassRecord(time(), *self._room.ballots.everything, self._room.free, *self._leader.tabs)
        session = self._session
        self._store.save_lecture(VisitorRecord({}, session.settings, self._lessons.saved(), session.state(), room))

    def close(self) -> None:
        self._store.save_lecture(VisitorRecord({}, Settings(), None))
