"""Who sees what: a private session for every tab, or one stage for a whole lecture."""

import contextlib
import logging
import secrets
import threading
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Final

import viser

from app.background import Background
from app.lessons.lesson import LessonBook
from app.lessons.loading import load_lessons
from app.page.keys import relay_script
from app.page.lesson_resume import Keeper, open_link, resume_script
from app.page.lesson_run import LessonRun
from app.page.lesson_saved import Saved
from app.page.page import Operation, View
from app.page.software import software_script
from app.people import NOBODY_ELSE, People
from app.server import DuetServer, request_query, start_server
from app.session import Session
from app.settings import Settings, from_query

log = logging.getLogger("duet.hosts")

# A tab that closes in the middle of a frame is no news; the next frame is drawn without it.
warnings.filterwarnings("ignore", message="Queued a .* on a closed connection", category=UserWarning)

NO_LESSONS: Final = LessonBook((), ())

FRAME: Final = 1.0 / 32.0
"""Wall time of a frame [s]."""

SOONEST: Final = 0.008
"""Least wall time between two frames when what a visitor does asks for one at once [s]."""


class _Stand:
    """One visitor's private stand: a session, what is seen of it, and what is operated."""

    def __init__(
        self,
        client: viser.ClientHandle,
        settings: Settings,
        problems: tuple[str, ...],
        wake: Callable[[], None],
        background: Background,
        people: People,
        book: LessonBook,
        found: tuple[Saved, bool] | None,
    ) -> None:
        self.client, self.query = client, request_query(client)
        self.session = Session(settings, wake, background, people)
        self.lessons = LessonRun(self.session, book)
        with client.atomic():
            self.view = View(client, self.session, lambda: [client], self.lessons)
            self.operation = Operation(client, self.session, self.view)
            self.view.welcome(client)
            self.operation.notify_problems((*problems, *open_link(self.lessons, self.query, found)))
            self.operation.notify_lessons(book)

    def frame(self, now: float, elapsed: float) -> None:
        moved = self.session.advance(elapsed) > 0
        self.lessons.frame()
        with self.client.atomic():
            self.view.show(now, moved)
            self.operation.show()
        self.client.flush()


class _Visitors:
    """Notes on the network's thread who comes and goes, and tells it on the frame loop's.

    Attributes:
        wake: asks for a frame at once; set by the frame loop.
    """

    def __init__(self, server: DuetServer) -> None:
        self._server = server
        self.wake: Callable[[], None] = lambda: None
        self._arrivals: list[viser.ClientHandle] = []
        self._departures: set[int] = set()
        self._lock = threading.Lock()

        @server.on_client_connect
        async def _(client: viser.ClientHandle) -> None:
            with self._lock:
                self._arrivals.append(client)
            self.wake()

        @server.on_client_disconnect
        async def _(client: viser.ClientHandle) -> None:
            with self._lock:
                self._departures.add(client.client_id)

    def changes(self) -> tuple[list[viser.ClientHandle], set[int]]:
        """Return who came (and is still there) and the ids of who left since the last call."""
        with self._lock:
            arrivals, self._arrivals = self._arrivals, []
            departures, self._departures = self._departures, set()
        return [client for client in arrivals if client.client_id not in departures], departures


class PrivateHost(_Visitors):
    """Every tab has its own session.

    Args:
        server: viser's.
        start: what a link without a query shows.
        background: computes for all sessions.
        people: who can be imitated beside the built-in person.
        book: the lessons.
    """

    def __init__(
        self,
        server: DuetServer,
        start: Settings,
        background: Background,
        people: People = NOBODY_ELSE,
        book: LessonBook = NO_LESSONS,
    ) -> None:
        self._start, self._background, self._people, self._book = start, background, people, book
        self._keeper = Keeper()
        self._stands: dict[int, _Stand] = {}
        super().__init__(server)

    @property
    def sessions(self) -> dict[int, Session]:
        """The live sessions by client id."""
        return {number: stand.session for number, stand in list(self._stands.items())}

    def frame(self, now: float, elapsed: float) -> None:
        """Advance and draw every session."""
        arrivals, departures = self.changes()
        for client in arrivals:
            query = request_query(client)
            settings, problems = from_query(query, self._start)
            try:
                self._keep_all(query)
                found = self._keeper.find(query)
                self._stands[client.client_id] = _Stand(
                    client, settings, problems, lambda: self.wake(), self._background, self._people, self._book, found
                )
            except Exception:
                log.exception("a visitor's page could not be built")
        for number in departures:
            if number in self._stands:
                stand = self._stands.pop(number)
                self._keeper.keep(stand.query, stand.lessons.saved())
                stand.operation.close()
                stand.session.close()
        for number, stand in list(self._stands.items()):
            try:
                stand.frame(now, elapsed)
            except Exception:
                # One broken page must not stop the others; a tab that is just closing ends up here too.
                if number in self._server.get_clients():
                    log.exception("a frame of a visitor's page failed")

    def _keep_all(self, query: dict[str, str]) -> None:
        """Keep what the newcomer's tab did, if its old connection has not been noticed to be gone."""
        for stand in self._stands.values():
            if stand.query.get("resume") and stand.query.get("resume") == query.get("resume"):
                self._keeper.keep(stand.query, stand.lessons.saved())


class LectureHost(_Visitors):
    """All tabs see one stage; one of them has the controls: the first, or the one that came with the key.

    Args:
        server: viser's.
        start: what the stage shows at first.
        key: a word that the lecturer's link carries (`?key=…`); None gives the controls to the first tab.
        background: computes for the session.
        people: who can be imitated beside the built-in person.
        book: the lessons.
    """

    def __init__(
        self,
        server: DuetServer,
        start: Settings,
        key: str | None,
        background: Background,
        people: People = NOBODY_ELSE,
        book: LessonBook = NO_LESSONS,
    ) -> None:
        self._key, self._book = key, book
        self.session = Session(start, lambda: self.wake(), background, people)
        self._clients: dict[int, viser.ClientHandle] = {}
        self._operation: Operation | None = None
        self._operator: int | None = None
        self.lessons = LessonRun(self.session, book)
        self._view = View(server, self.session, lambda: list(self._clients.values()), self.lessons)
        server.gate.may_share = lambda client_id: client_id == self._operator
        super().__init__(server)

    @property
    def operator(self) -> int | None:
        """Id of the client that has the controls, None if nobody has."""
        return self._operator

    def frame(self, now: float, elapsed: float) -> None:
        """Advance the one session and draw it for all."""
        arrivals, departures = self.changes()
        for client in arrivals:
            self._clients[client.client_id] = client
            with contextlib.suppress(Exception):
                # Whoever is gone again before being welcomed must not cost the others their frame.
                self._view.welcome(client)
        for number in departures:
            self._clients.pop(number, None)
            if number == self._operator:
                if self._operation is not None:
                    self._operation.close()
                self._operator, self._operation = None, None
                self.session.hold(None)
        if self._operator is None:
            self._hand_over()
        moved = self.session.advance(elapsed) > 0
        self.lessons.frame()
        with self._server.atomic():
            self._view.show(now, moved)
        if self._operation is not None:
            self._operation.show()
        self._server.flush()

    def _hand_over(self) -> None:
        for number, client in self._clients.items():
            given = request_query(client).get("key", "")
            if self._key is None or secrets.compare_digest(given.encode(), self._key.encode()):
                self._operator = number
                self._operation = Operation(client, self.session, self._view)
                if not self.lessons.open:
                    self._operation.notify_problems(open_link(self.lessons, request_query(client), None))
                self._operation.notify_lessons(self._book)
                return


class FrameLoop:
    """The one thread that simulates and draws: every `FRAME`, and at once (but not sooner than `SOONEST`) when it is woken.

    Args:
        host: what is advanced and drawn.
    """

    def __init__(self, host: PrivateHost | LectureHost) -> None:
        self._host = host
        self._stopped = False
        self._news = threading.Event()
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
            except Exception:
                log.exception("a frame failed")
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
        for session in self.host.sessions.values() if isinstance(self.host, PrivateHost) else (self.host.session,):
            session.close()
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
        sessions: how many private sessions there may be at once; a lecture has no limit.
        lecture: one stage for all.
        key: of the lecturer, or None.
        allowed_origins: further web addresses whose pages may connect.
        people: who can be imitated beside the built-in person; let go of when the house is closed.
        lessons: folder of lessons; None for our own.

    Raises:
        PortInUse, BadSetting: see `app.server.start_server`.
    """
    server = start_server(
        host,
        port,
        allowed_origins=allowed_origins,
        max_clients=None if lecture else sessions,
        script=software_script() + relay_script() + resume_script(),
    )
    server.scene.world_axes.visible = False
    background = Background()
    book = load_lessons() if lessons is None else load_lessons(lessons)
    for problem in book.problems:
        log.warning("a lesson was left out: %s", problem)
    if lecture:
        return House(server, LectureHost(server, settings, key, background, people, book), background, people)
    return House(server, PrivateHost(server, settings, background, people, book), background, people)
