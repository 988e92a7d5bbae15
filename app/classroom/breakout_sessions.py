"""Breakout sessions: students of a lecture explore in sessions of their own, which they find again when they come back."""

import logging
from collections.abc import Collection
from dataclasses import replace
from time import monotonic
from typing import Final

from app.classroom.breakout_workers import BreakoutWorkers
from app.classroom.classroom import Classroom
from app.classroom.participant import Participant
from app.hosting.admission import Pieces
from app.hosting.app_context import AppContext
from app.hosting.visitor import Visitor, open_visitor
from app.hosting.visitor_record import VisitorRecord, tab_id
from app.lessons.session.lesson_session import LessonSession
from app.lessons.session.saved import SavedLesson
from app.page.panels.server_load import ServerLoad
from app.runtime.throttled_log import ThrottledLog
from app.session.session import Session
from app.settings import Settings
from app.web.audiences import SCREEN, Audiences
from scenes.settings import values

log = logging.getLogger("duet.lecture")

SETTLE: Final = 0.25
"""Time between two assignments of places [s]."""


Stage = tuple[Session, LessonSession]
"""The stage's session and lessons."""


class BreakoutSessions:
    """The students' own sessions beside the stage.

    Attributes:
        workers: the processes that have the sessions; None where this one has them.
    """

    def __init__(self, context: AppContext, room: Classroom, workers: BreakoutWorkers | None = None) -> None:
        self._context, self._room, self.workers = context, room, workers
        self._errors = ThrottledLog(log)
        self._next = 0.0

    def expects(self, query: dict[str, str]) -> bool:
        """Return whether the browser that connects with a query gets a breakout session; from any thread."""
        tab = None if self.workers is not None else tab_id(query)
        return tab is not None and SCREEN not in query and self._room.free and self._room.places.holds(tab)

    def load(self, here: ServerLoad) -> ServerLoad:
        """Return how busy all processes are. `here`: how busy this one is."""
        return here if self.workers is None else self.workers.load(here)

    def hurry(self) -> None:
        """Assign places in the next frame, after a decision of the teacher's."""
        self._next = 0.0

    def settle(self, participants: Collection[Participant], audiences: Audiences, stage: Stage, now: float) -> None:
        """Every `SETTLE`, assign places and move students to their own sessions or back to the stage. `now`: wall time [s]."""
        self._context.store.tidy()
        if self.workers is not None:
            self.workers.exchange()
        if now < self._next:
            return
        self._next = now + SETTLE
        room = self._room
        students = [one for one in participants if one.banner is not None or one.visitor is not None]
        elsewhere = () if self.workers is None else self.workers.students
        room.settle((*(one.id for one in students if one.lasting), *elsewhere), monotonic())
        for one in students:
            wanted = room.free and one.lasting and room.places.holds(one.id)
            if wanted != (one.visitor is not None) and not one.moved:
                one.moved = True
                if wanted and self.workers is not None:
                    self.workers.send(one.id, self.begin(one.id, *stage))
                audiences.move(one.client)

    def begin(self, student: str, session: Session, lessons: LessonSession) -> VisitorRecord:
        """Return a session like the stage's, with a student's own answers."""
        return VisitorRecord({}, session.settings, self._from_stage(student, lessons))

    def admit(self, participant: Participant, participants: Collection[Participant], begin: VisitorRecord) -> Pieces:
        """Give a student the session left in the store, or one with the student's last settings, or one that begins as `begin` says."""
        for other in participants:
            if other is not participant and other.id == participant.id and other.visitor is not None:
                # A lost connection may not have been noticed yet.
                other.visitor.supersede()
        found = yield from self._context.store.recall(participant.query)
        # A student's lesson is open again by any link.
        record = replace(begin if found is None else found, query=participant.query)
        visitor = yield from open_visitor(self._context, participant.client, record.settings, record=record)
        if not visitor.is_back and found is not None and found.lessons is not None and found.lessons.open:
            visitor.session.post(lambda: _restore(visitor.session, found.settings), "restore")
        participant.visitor = visitor

    def leave(self, participant: Participant) -> None:
        """Keep the session of a student who has disconnected."""
        self._errors.forget(participant.client.client_id)
        if participant.visitor is not None:
            participant.visitor.leave()

    def frame(self, client_id: int, visitor: Visitor, now: float, elapsed: float) -> None:
        """Advance and draw one student's session. `now`: wall time; `elapsed`: since the last frame [s]."""
        try:
            visitor.session.halt.set("teacher", self._room.paused)
            visitor.frame(now, elapsed)
        except Exception as error:
            # One broken page must not stop the others; a tab that is just closing ends up here too.
            if client_id in self._context.server.get_clients():
                self._errors.exception("a frame of a student's page failed", error, client_id)

    def _from_stage(self, student: str, lessons: LessonSession) -> SavedLesson | None:
        """Return the stage's lesson and step with the student's own answers; None outside the lessons."""
        saved = lessons.saved()
        if saved is None or not saved.open:
            return None
        return SavedLesson(self._room.progress_of(student, lessons.walk), saved.own, True)


def _restore(session: Session, settings: Settings) -> None:
    """Restore the settings that a student had changed within a step."""
    for key, value in values(settings).items():
        if values(session.settings)[key] != value:
            session.change(key, value)
