"""A private session for every tab."""

import logging
from collections.abc import Mapping

import viser

from app.classroom.teacher_panel import NotesPanel
from app.hosting.admission import Admission, Pieces
from app.hosting.resume import ProgressStore
from app.hosting.session_store import SessionStore, same_tab
from app.hosting.teacher_key import is_mistaken, is_teacher
from app.hosting.visitor import Connections, Visitor
from app.lessons.lesson import NO_LESSONS, LessonBook
from app.page.panels.key_notice import name_mistake
from app.page.view import View
from app.runtime.job_pool import JobPool
from app.runtime.throttled_log import ThrottledLog
from app.session.input_sources import NO_SOURCES, InputSources
from app.session.session import Session
from app.settings import Settings, from_query
from app.web.request import request_query
from app.web.server import DuetServer

log = logging.getLogger("duet.hosts")


class PrivateHost(Connections):
    """Every tab has its own session.

    Args:
        server: viser's.
        start: what a link without a query shows.
        background: computes for all sessions.
        people: who can be imitated beside the built-in person.
        book: the lessons.
        key: a word that a teacher's link carries (`?key=…`); None if nobody is one.
        notes: the teacher's, by the id of their lesson.
    """

    def __init__(
        self,
        server: DuetServer,
        start: Settings,
        background: JobPool,
        people: InputSources = NO_SOURCES,
        book: LessonBook = NO_LESSONS,
        key: str | None = None,
        notes: Mapping[str, str] | None = None,
    ) -> None:
        self._start, self._background, self._people, self._book = start, background, people, book
        self._key, self._notes = key, notes or {}
        self._teachers: dict[int, tuple[View, NotesPanel]] = {}
        self._keeper, self._cloakroom = ProgressStore(), SessionStore()
        self._stands: dict[int, Visitor] = {}
        self._mishaps = ThrottledLog(log)
        self._entrance = Admission(self._let_in, lambda _: log.exception("a visitor's page could not be built"))
        super().__init__(server)

    @property
    def sessions(self) -> dict[int, Session]:
        """The live sessions by client id."""
        return {number: stand.session for number, stand in list(self._stands.items())}

    def close(self) -> None:
        """Close every session, also of those who are away."""
        self._entrance.close()
        for session in self.sessions.values():
            session.close()
        self._cloakroom.close()

    def frame(self, now: float, elapsed: float) -> None:
        """Advance and draw every session."""
        arrivals, departures = self.changes()
        self._cloakroom.tidy()
        for number in departures:
            self._entrance.leave(number)
            self._teachers.pop(number, None)
            self._mishaps.forget(number)
            if number in self._stands:
                stand = self._stands.pop(number)
                stand.session.posts.drop()
                self._keeper.keep(stand.query, stand.lessons.saved())
                stand.operation.close()
                if stand.superseded:
                    stand.session.close()
                else:
                    self._cloakroom.leave(stand.query, stand.session, stand.lessons)
        for client in arrivals:
            self._entrance.come(client)
        self._entrance.advance()
        if self._entrance.busy:
            self.wake()
        for number, stand in list(self._stands.items()):
            try:
                stand.frame(now, elapsed, len(self._stands))
                self._show_notes(number, stand)
            except Exception as error:
                # One broken page must not stop the others; a tab that is just closing ends up here too.
                if number in self._server.get_clients():
                    self._mishaps.exception("a frame of a visitor's page failed", error, number)

    def _let_in(self, client: viser.ClientHandle) -> Pieces:
        """Build a visitor's page piece by piece; it is drawn once it is whole."""
        query = request_query(client)
        settings, problems = from_query(query, self._start)
        self._keep_all(query)
        found, back = self._keeper.find(query), self._cloakroom.fetch(query)
        before = [stand for stand in self._stands.values() if same_tab(stand.query, query)]
        if before:
            settings = before[-1].session.settings
        stand: Visitor | None = None
        try:
            stand = Visitor(
                client, settings, problems, lambda: self.wake(), self._background, self._people, self._book, found, back
            )
            yield
            yield from stand.build()
        except BaseException:
            # Also of a tab that is closed before its page is whole.
            if back is not None:
                self._cloakroom.leave(query, *back)
            elif stand is not None:
                stand.session.close()
            raise
        if before and not stand.lessons.open and before[-1].session.settings == settings:
            # Whether the other connection is broken cannot be known yet: a tab may have been doubled, and keeps its own session.
            stand.session.go_on_from(before[-1].session)
        for one in before:
            one.superseded = True
        left = self._cloakroom.fetch(query) if before else None
        if left is not None:
            # It turned out to be broken while the page was built.
            left[0].close()
        self._stands[client.client_id] = stand
        self._look_at_key(stand)

    def _keep_all(self, query: dict[str, str]) -> None:
        """Keep what the newcomer's tab did, if its old connection has not been noticed to be gone."""
        for stand in self._stands.values():
            if stand.query.get("resume") and stand.query.get("resume") == query.get("resume"):
                self._keeper.keep(stand.query, stand.lessons.saved())

    def _look_at_key(self, stand: Visitor) -> None:
        """Tell whoever has another key than the teacher's."""
        if is_mistaken(self._key, stand.query):
            name_mistake(stand.client)

    def _show_notes(self, number: int, stand: Visitor) -> None:
        """Show a teacher the notes; another language makes the page anew."""
        if not is_teacher(self._key, stand.query):
            return
        with stand.client.atomic():
            if number not in self._teachers or self._teachers[number][0] is not stand.view:
                self._teachers[number] = stand.view, NotesPanel(stand.client.gui, self._notes)
            self._teachers[number][1].show(stand.lessons)
