"""Records of a lecture."""

from time import time
from typing import Final

from app.features.classroom.class_record import NAME, ClassRecord, class_of, last_class_of, with_class
from app.features.classroom.class_summary import ClassSummary
from app.features.classroom.classroom import Classroom
from app.features.lecture.leader import Leader
from app.features.lecture.teacher_control import TeacherControl
from app.features.lessons.lesson import LessonBook
from app.features.lessons.panel.lesson_visit import LessonServer
from app.features.store.session_store import store_of
from app.hosting.app_context import AppContext
from app.hosting.visitor import record_of, run_again
from app.hosting.visitor_record import VisitorRecord
from app.settings import Settings

SAVING: Final = 1.0
"""Period of the records [s]."""


class LectureRecorder:
    """Saves a running lecture, and its summary at the end. `record`: of an interrupted lecture to resume."""

    def __init__(
        self, context: AppContext, record: VisitorRecord | None, control: TeacherControl, leader: Leader
    ) -> None:
        self._store, self._book, self._leader, self._save_at = (
            store_of(context),
            context.part(LessonServer).book,
            leader,
            0.0,
        )
        self._session, self._lessons, self._classroom = control.session, control.lessons, control.classroom
        self._last_class = _summary_in(self._store.named(NAME), record is not None, self._book)
        if record is not None and class_of(record) is not None:
            self._session.parts.restore(record.parts, record.recordings)
            if self._lessons.left is not None:
                self._lessons.resume(self._lessons.left, reopen=True)
            for _ in run_again(self._session, record):
                pass

    @property
    def last_class(self) -> ClassSummary | None:
        """Report of the previous class, until its record expires."""
        last = self._last_class
        return None if last is None or abs(time() - last.saved) > self._store.keep else last

    def save(self, now: float) -> None:
        """Save the lecture every `SAVING`. `now`: wall time [s]."""
        if not self._store.lasting or now < self._save_at:
            return
        self._save_at = now + SAVING
        ballots, work, (leader, students) = self._classroom.ballots, self._classroom.work, self._leader.tabs
        rounds = ballots.rounds
        record = ClassRecord(
            saved=time(),
            ballots={question: given[-1] for question, given in rounds.items()},
            revealed=tuple(sorted(ballots.revealed)),
            free=self._classroom.free,
            leader=leader,
            students=students,
            earlier={question: given[:-1] for question, given in rounds.items() if len(given) > 1},
            passed={question: tuple(sorted(passed)) for question, passed in work.passed.items()},
            hand_ins=dict(work.hand_ins),
            pages_only=ballots.pages_only,
            pageless=tuple(sorted(ballots.pageless)),
            names=dict(self._classroom.board.names),
            pace=self._classroom.pace,
            nearest=dict(work.nearest),
            groups=dict(self._classroom.places.groups),
        )
        self._store.save_named(NAME, with_class(record_of({}, self._session), record, self.last_class))

    def close(self) -> None:
        summary = self._classroom.summary(self._book, time())
        last = self.last_class if summary.empty else summary
        self._store.save_named(NAME, with_class(VisitorRecord({}, Settings()), None, last))


def _summary_in(record: VisitorRecord | None, goes_on: bool, book: LessonBook) -> ClassSummary | None:
    """Summary of the last finished class. `goes_on`: the record's lecture is resumed."""
    if record is None:
        return None
    room = class_of(record)
    if room is not None and not goes_on:
        # Interrupted, and not resumed in time.
        summary = Classroom(0, room).summary(book, room.saved)
        if not summary.empty:
            return summary
    return last_class_of(record)
