"""Who sees what: a private session for every tab, or one stage for a whole lecture."""

import logging
import threading
import time
import warnings
from collections.abc import Mapping
from pathlib import Path
from time import perf_counter
from typing import Final

import viser

from app.background import Background
from app.classroom.key import WRONG_KEY, is_mistaken, is_teacher
from app.cloakroom import Cloakroom, same_tab
from app.languages.speaking import say
from app.languages.visitor import language_script
from app.lecture import LectureHost
from app.lessons.lesson import NO_LESSONS, LessonBook
from app.lessons.loading import load_lessons, load_notes
from app.mishaps import Mishaps
from app.page.keys import relay_script
from app.page.lesson_resume import Keeper, resume_script
from app.page.replay_box import box_script
from app.page.software import software_script
from app.page.teacher import NotesPanel
from app.page.teacher_script import class_script
from app.page.view import View
from app.people import NOBODY_ELSE, People
from app.server.request import request_query
from app.server.server import DuetServer, start_server
from app.session import Session
from app.settings import Settings, from_query
from app.stand import Stand, Visitors

log = logging.getLogger("duet.hosts")

# A tab that closes in the middle of a frame is no news; the next frame is drawn without it.
warnings.filterwarnings("ignore", message="Queued a .* on a closed connection", category=UserWarning)


FRAME: Final = 1.0 / 32.0
"""Wall time of a frame [s]."""

SOONEST: Final = 0.008
"""Least wall time between two frames when what a visitor does asks for one at once [s]."""


class PrivateHost(Visitors):
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
        background: Background,
        people: People = NOBODY_ELSE,
        book: LessonBook = NO_LESSONS,
        key: str | None = None,
        notes: Mapping[str, str] | None = None,
    ) -> None:
        self._start, self._background, self._people, self._book = start, background, people, book
        self._key, self._notes = key, notes or {}
        self._teachers: dict[int, tuple[View, NotesPanel]] = {}
        self._keeper, self._cloakroom = Keeper(), Cloakroom()
        self._stands: dict[int, Stand] = {}
        self._mishaps = Mishaps(log)
        super().__init__(server)

    @property
    def sessions(self) -> dict[int, Session]:
        """The live sessions by client id."""
        return {number: stand.session for number, stand in list(self._stands.items())}

    def close(self) -> None:
        """Close every session, also of those who are away."""
        for session in self.sessions.values():
            session.close()
        self._cloakroom.close()

    def frame(self, now: float, elapsed: float) -> None:
        """Advance and draw every session."""
        arrivals, departures = self.changes()
        self._cloakroom.tidy()
        for number in departures:
            self._teachers.pop(number, None)
            self._mishaps.forget(number)
            if number in self._stands:
                stand = self._stands.pop(number)
                self._keeper.keep(stand.query, stand.lessons.saved())
                stand.operation.close()
                if stand.superseded:
                    stand.session.close()
                else:
                    self._cloakroom.leave(stand.query, stand.session, stand.lessons)
        for client in arrivals:
            try:
                self._let_in(client)
            except Exception:
                log.exception("a visitor's page could not be built")
        for number, stand in list(self._stands.items()):
            try:
                stand.frame(now, elapsed)
                self._show_notes(number, stand)
            except Exception as error:
                # One broken page must not stop the others; a tab that is just closing ends up here too.
                if number in self._server.get_clients():
                    self._mishaps.tell("a frame of a visitor's page failed", error, number)

    def _let_in(self, client: viser.ClientHandle) -> None:
        query = request_query(client)
        settings, problems = from_query(query, self._start)
        self._keep_all(query)
        found, back = self._keeper.find(query), self._cloakroom.fetch(query)
        before = [stand for stand in self._stands.values() if same_tab(stand.query, query)]
        if before:
            settings = before[-1].session.settings
        try:
            stand = Stand(
                client, settings, problems, lambda: self.wake(), self._background, self._people, self._book, found, back
            )
        except Exception:
            if back is not None:
                self._cloakroom.leave(query, *back)
            raise
        if before and not stand.lessons.open:
            # Whether the other connection is broken cannot be known yet: a tab may have been doubled, and keeps its own session.
            stand.session.go_on_from(before[-1].session)
        for one in before:
            one.superseded = True
        self._stands[client.client_id] = stand
        self._look_at_key(stand)

    def _keep_all(self, query: dict[str, str]) -> None:
        """Keep what the newcomer's tab did, if its old connection has not been noticed to be gone."""
        for stand in self._stands.values():
            if stand.query.get("resume") and stand.query.get("resume") == query.get("resume"):
                self._keeper.keep(stand.query, stand.lessons.saved())

    def _look_at_key(self, stand: Stand) -> None:
        """Tell whoever has another key than the teacher's."""
        if is_mistaken(self._key, stand.query):
            stand.client.add_notification(say("The key is another one"), say(WRONG_KEY), color="orange", auto_close_seconds=12.0)

    def _show_notes(self, number: int, stand: Stand) -> None:
        """Show a teacher the notes; another language makes the page anew."""
        if not is_teacher(self._key, stand.query):
            return
        with stand.client.atomic():
            if number not in self._teachers or self._teachers[number][0] is not stand.view:
                self._teachers[number] = stand.view, NotesPanel(stand.client.gui, self._notes)
            self._teachers[number][1].show(stand.lessons)


class FrameLoop:
    """The one thread that simulates and draws: every `FRAME`, and at once (but not sooner than `SOONEST`) when it is woken.

    Args:
        host: what is advanced and drawn.
    """

    def __init__(self, host: PrivateHost | LectureHost) -> None:
        self._host = host
        self._stopped = False
        self._news = threading.Event()
        self._mishaps = Mishaps(log)
        self._thread = threading.Thread(target=self._run, name="duet-frames", daemon=True)
        host.wake = self._news.set

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self) -> None:
        """End, and wait until the last frame is done."""
        self._stopped = True
        self._news.set()
        self._thread.join(timeout=5.0)

    def _run(self) -> None:
        last = due = perf_counter()
        while not self._stopped:
            self._news.clear()
            now = perf_counter()
            try:
                self._host.frame(now, now - last)
            except Exception as error:
                self._mishaps.tell("a frame failed", error)
            last = now
            if now >= due:
                # After a late frame the beat starts anew instead of catching up.
                due = max(due + FRAME, now + FRAME / 2.0)
            time.sleep(max(now + SOONEST - perf_counter(), 0.0))
            self._news.wait(max(due - perf_counter(), 0.0))


class House:
    """A running server with its host and its frame loop; made by `open_house`.

    Attributes:
        server, host, background: as made.
        url: where the page is.
    """

    def __init__(
        self, server: DuetServer, host: PrivateHost | LectureHost, background: Background, people: People = NOBODY_ELSE
    ) -> None:
        self.server, self.host, self.background, self.url = server, host, background, server.url
        self._people = people
        self._loop = FrameLoop(host)
        self._loop.start()
        self._closed = threading.Event()

    def wait(self) -> None:
        """Block until `close` is called or Ctrl+C."""
        while not self._closed.wait(0.5):
            pass

    def close(self) -> None:
        """End the frames and everything that is being computed, close every connection and release the port."""
        self._loop.stop()
        self.host.close()
        self.background.close()
        self._people.close()
        self.server.stop()
        self._closed.set()


def open_house(
    host: str,
    port: int,
    settings: Settings,
    sessions: int = 8,
    lecture: bool = False,
    key: str | None = None,
    allowed_origins: tuple[str, ...] = (),
    people: People = NOBODY_ELSE,
    lessons: Path | None = None,
) -> House:
    """Start to serve the page.

    Args:
        host, port: where; port 0 takes any free one.
        settings: what the page shows at first.
        sessions: how many private sessions there may be at once; a lecture has no limit for those who watch.
        lecture: one stage for all.
        key: of the teacher, or None.
        allowed_origins: further web addresses whose pages may connect.
        people: who can be imitated beside the built-in person; let go of when the house is closed.
        lessons: folder of lessons; None for our own.

    Raises:
        PortInUse, BadSetting: see `app.server.server.start_server`.
    """
    server = start_server(
        host,
        port,
        allowed_origins=allowed_origins,
        max_clients=None if lecture else sessions,
        script=software_script() + relay_script() + resume_script() + box_script() + language_script() + class_script(),
    )
    server.scene.world_axes.visible = False
    background = Background()
    book = load_lessons() if lessons is None else load_lessons(lessons)
    for problem in book.problems:
        log.warning("a lesson was left out: %s", problem)
    # The notes are not even read where nobody has a key to them.
    notes = {} if key is None else load_notes() if lessons is None else load_notes(lessons)
    if lecture:
        stage = LectureHost(server, settings, key, background, people, book, notes, sessions, host)
        return House(server, stage, background, people)
    return House(server, PrivateHost(server, settings, background, people, book, key, notes), background, people)
