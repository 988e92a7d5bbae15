"""Students of a lecture who explore: who gets a place, and how everybody finds their own session again."""

import logging
from collections.abc import Callable, Collection
from time import monotonic
from typing import Final

from app.classroom.breakout_places import Kept
from app.classroom.classroom import Classroom
from app.classroom.participant import Participant
from app.hosting.admission import Pieces
from app.hosting.resume import word_of
from app.hosting.session_store import SessionStore
from app.hosting.visitor import Visitor
from app.lessons.lesson import LessonBook
from app.lessons.session.lesson_session import LessonSession
from app.lessons.session.saved import SavedLesson
from app.runtime.job_pool import JobPool
from app.runtime.throttled_log import ThrottledLog
from app.session.input_sources import InputSources
from app.session.session import Session
from app.settings import Settings
from app.web.audiences import Audiences
from app.web.server import DuetServer
from scenes.settings import values

log = logging.getLogger("duet.lecture")

SETTLE: Final = 0.25
"""Time between two looks at who gets a place of their own [s]."""


class BreakoutSessions:
    """Sessions of students' own, beside the stage.

    Args:
        server: that the browsers are connected to.
        room: the class.
        background: computes for the sessions.
        people: who can be imitated.
        book: the lessons.
        wake: asks for a frame at once.

    Attributes:
        waiting: the words of those who have no place.
    """

    def __init__(
        self,
        server: DuetServer,
        room: Classroom,
        background: JobPool,
        people: InputSources,
        book: LessonBook,
        wake: Callable[[], None],
    ) -> None:
        self._server, self._room, self._wake = server, room, wake
        self._background, self._people, self._book = background, people, book
        self._cloakroom = SessionStore()
        self._mishaps = ThrottledLog(log)
        self._next = 0.0
        self.waiting: tuple[str, ...] = ()

    def close(self) -> None:
        """Close the sessions of those who are away."""
        self._cloakroom.close()

    def expects(self, query: dict[str, str]) -> bool:
        """Return whether the student's browser that comes with a query is to have its own session; may be asked from any thread."""
        word = word_of(query)
        return word is not None and "screen" not in query and self._room.free and self._room.places.holds(word)

    def hurry(self) -> None:
        """Settle in the next frame: the teacher has decided something."""
        self._next = 0.0

    def settle(self, seats: Collection[Participant], apart: Audiences, now: float) -> None:
        """Now and then: give places, and have `apart` call those elsewhere who are not where they belong. `now`: wall time [s]."""
        self._cloakroom.tidy()
        if now < self._next:
            return
        self._next = now + SETTLE
        room = self._room
        students = [seat for seat in seats if seat.banner is not None or seat.stand is not None]
        room.settle(tuple(seat.who for seat in students if seat.lasting), monotonic())
        for seat in students:
            wanted = room.free and seat.lasting and room.places.holds(seat.who)
            if wanted != (seat.stand is not None) and not seat.moved:
                seat.moved = True
                apart.move(seat.client)
        self.waiting = tuple(who for who in room.here if room.free and not room.places.holds(who))

    def let_in(self, seat: Participant, seats: Collection[Participant], stage: Settings, lessons: LessonSession) -> Pieces:
        """Give a student a session: their own where they left it, or one with their settings, or one as the stage's is.

        Its page is built piece by piece; the seat has it once it is whole.
        """
        for other in seats:
            if other is not seat and other.who == seat.who and other.stand is not None:
                # A connection that is gone may not have been noticed yet.
                self._keep(seat.who, other.stand)
                other.stand.superseded = True
        back, kept = self._cloakroom.fetch(seat.query), self._room.places.kept(seat.who)
        settings = stage if kept is None else kept.settings
        saved = self._from_stage(seat.who, lessons) if kept is None else kept.saved
        found = None if saved is None else (saved, True)
        stand: Visitor | None = None
        try:
            stand = Visitor(seat.client, settings, (), self._wake, self._background, self._people, self._book, found, back)
            yield
            yield from stand.build()
        except BaseException:
            # Also of a tab that is closed before its page is whole.
            if back is not None:
                self._cloakroom.leave(seat.query, *back)
            elif stand is not None:
                stand.session.close()
            raise
        if back is None and kept is not None and saved is not None and saved.open:
            stand.session.post(lambda: _restore(stand.session, kept.settings), "restore")
        seat.stand = stand

    def leave(self, seat: Participant) -> None:
        """A student's connection is gone: what is theirs is kept for when they are back."""
        self._mishaps.forget(seat.client.client_id)
        stand = seat.stand
        if stand is None:
            return
        stand.session.posts.drop()
        stand.halt(False)
        self._keep(seat.who, stand)
        stand.operation.close()
        if stand.superseded:
            stand.session.close()
        else:
            self._cloakroom.leave(seat.query, stand.session, stand.lessons)

    def frame(self, number: int, stand: Visitor, now: float, elapsed: float) -> None:
        """Advance and draw one student's session. `number`: of the client; `now`: wall time; `elapsed`: since the last frame [s]."""
        try:
            stand.halt(self._room.paused)
            stand.frame(now, elapsed, 1 + self._room.places.taken)
        except Exception as error:
            # One broken page must not stop the others; a tab that is just closing ends up here too.
            if number in self._server.get_clients():
                self._mishaps.exception("a frame of a student's page failed", error, number)

    def _from_stage(self, who: str, lessons: LessonSession) -> SavedLesson | None:
        """Return the stage's lesson and step as a place to begin at, with the student's own answers; None outside the lessons."""
        saved = lessons.saved()
        if saved is None or not saved.open:
            return None
        return SavedLesson(self._room.progress_of(who, lessons.walk), saved.own, True)

    def _keep(self, who: str, stand: Visitor) -> None:
        self._room.places.keep(who, Kept(stand.session.settings, stand.lessons.saved()))


def _restore(session: Session, settings: Settings) -> None:
    """Take on the settings that a student had changed within a step."""
    for key, value in values(settings).items():
        if values(session.settings)[key] != value:
            session.change(key, value)
