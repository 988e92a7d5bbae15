"""A lecture outlives a server that breaks off: the plenary, the answers and the lead are stored every second. Of one that has ended the
summary is left."""

from time import time
from typing import Final

from app.classroom.classroom import Classroom
from app.classroom.leader import Leader
from app.export.class_summary import ClassSummary
from app.hosting.session_store import SessionStore
from app.hosting.visitor import run_again
from app.hosting.visitor_record import ClassRecord, VisitorRecord
from app.lessons.lesson import LessonBook
from app.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.settings import Settings

SAVING: Final = 1.0
"""Time from one record to the next [s]."""


class LectureRecorder:
    """Stores a lecture while it goes on, and its summary when it ends.

    Args:
        record: of the lecture that broke off, which goes on here; None for a new one.
        book: the lessons.
    """

    def __init__(
        self,
        store: SessionStore,
        record: VisitorRecord | None,
        plenary: tuple[Session, LessonSession],
        room: Classroom,
        leader: Leader,
        book: LessonBook,
    ) -> None:
        self._store, (self._session, self._lessons), self._room, self._leader = store, plenary, room, leader
        self._book, self._save_at = book, 0.0
        self._last_class = _summary_in(store.last_lecture(), record is not None, book)
        if record is not None and record.room is not None:
            self._restore(record, record.room)

    @property
    def last_class(self) -> ClassSummary | None:
        """Return what the class before this one has left behind, for as long as records are kept."""
        last = self._last_class
        return None if last is None or abs(time() - last.saved) > self._store.keep else last

    def _restore(self, record: VisitorRecord, room: ClassRecord) -> None:
        if record.lessons is not None:
            self._lessons.resume(record.lessons, reopen=True)
        for _ in run_again(self._session, self._lessons, record):
            pass
        _take_up(self._room, room)
        self._room.free = room.free
        self._leader.restore(room.leader, room.students)

    def save(self, now: float) -> None:
        """Hand over the lecture every `SAVING`. `now`: wall time [s]."""
        if not self._store.lasting or now < self._save_at:
            return
        self._save_at = now + SAVING
        voters = self._room.voters
        ballots, work, (leader, students) = self._room.ballots, self._room.work, self._leader.tabs
        record = ClassRecord(
            time(),
            *ballots.everything,
            self._room.free,
            leader,
            students,
            ballots.earlier,
            work.passed,
            work.hand_ins,
            voters.pages_only,
            tuple(sorted(voters.pageless)),
            dict(self._room.board.names),
            self._room.pace,
            dict(work.nearest),
            dict(self._room.places.groups),
        )
        session = self._session
        self._store.save_lecture(
            VisitorRecord({}, session.settings, self._lessons.saved(), session.state(), record, self.last_class)
        )

    def close(self) -> None:
        summary = self._room.summary(self._book, time())
        self._store.save_lecture(VisitorRecord({}, Settings(), None, last_class=self.last_class if summary.empty else summary))


def _take_up(room: Classroom, record: ClassRecord) -> None:
    room.ballots.restore(record.ballots, record.revealed, record.earlier)
    room.work.restore(record.passed, record.hand_ins, record.nearest)
    room.voters.restore(record.pages_only, record.pageless)
    room.board.names, room.pace = dict(record.names), record.pace
    room.places.groups = dict(record.groups)
    room.count_pages_only(record.pages_only)


def _summary_in(record: VisitorRecord | None, goes_on: bool, book: LessonBook) -> ClassSummary | None:
    """Return the summary of the last class that has ended. `goes_on`: whether the lecture of the record goes on."""
    if record is None:
        return None
    if record.room is not None and not goes_on:
        # It broke off, and was not started again in time.
        room = Classroom(0)
        _take_up(room, record.room)
        summary = room.summary(book, record.room.saved)
        if not summary.empty:
            return summary
    return record.last_class
