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
from app.languages.lesson_book import in_language
from app.languages.speaking import speak
from app.languages.visitor import accepted_by, asked_by, language_script, with_language
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
from app.settings import Language, Settings, from_query

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
        self._book = book
        self._language: Language = settings.page.language
        speak(self._language)
        self.lessons = LessonRun(self.session, in_language(book, self._language))
        with client.atomic():
            self.view = View(client, self.session, lambda: [client], self.lessons)
            self.operation = Operation(client, self.session, self.view)
            self.view.welcome(client)
            self.operation.notify_problems((*problems, *open_link(self.lessons, self.query, found)))
            self.operation.notify_lessons(book)

    def _translate(self) -> None:
        """Make the page anew in another language; the session and the lessons go on where they are."""
        saved = self.lessons.saved()
        self.operation.close()
        self._language = self.session.settings.page.language
        speak(self._language)
        self.lessons = LessonRun(self.session, in_language(self._book, self._language))
        if saved is not None:
            self.lessons.resume(saved, reopen=True)
        with self.client.atomic():
            self.client.gui.reset()
            self.view = View(self.client, self.session, lambda: [self.client], self.lessons)
            self.operation = Operation(self.client, self.session, self.view)
            self.view.welcome(self.client)

    def frame(self, now: float, elapsed: float) -> None:
        speak(self._language)
        moved = self.session.advance(elapsed) > 0
        if self.session.settings.page.language != self._language:
            self._translate()
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
            settings = with_language(settings, accepted_by(client))
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
        self._choose_language = start.page.language == "auto"
        start = with_language(start, "")
        self.session = Session(start, lambda: self.wake(), background, people)
        self._language: Language = start.page.language
        self._clients: dict[int, viser.ClientHandle] = {}
        self._operation: Operation | None = None
        self._operator: int | None = None
        speak(self._language)
        self.lessons = LessonRun(self.session, in_language(book, self._language))
        self._view = View(server, self.session, lambda: list(self._clients.values()), self.lessons)
        server.gate.may_share = lambda client_id: client_id == self._operator
        super().__init__(server)

    @property
    def operator(self) -> int | None:
        """Id of the client that has the controls, None if nobody has."""
        return self._operator

    def frame(self, now: float, elapsed: float) -> None:
        """Advance the one session and draw it for all."""
        speak(self._language)
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
        if self.session.settings.page.language != self._language:
            self._translate()
        self.lessons.frame()
        with self._server.atomic():
            self._view.show(now, moved)
        if self._operation is not None:
            self._operation.show()
        self._server.flush()

    def _translate(self) -> None:
        """Make everybody's page anew in another language; the session and the lessons go on where they are."""
        saved = self.lessons.saved()
        self._language = self.session.settings.page.language
        speak(self._language)
        self.lessons = LessonRun(self.session, in_language(self._book, self._language))
        if saved is not None:
            self.lessons.resume(saved, reopen=True)
        operator = None if self._operator is None else self._clients.get(self._operator)
        if self._operation is not None:
            self._operation.close()
        with self._server.atomic():
            if operator is not None:
                operator.gui.reset()
            self._server.gui.reset()
            self._view = View(self._server, self.session, lambda: list(self._clients.values()), self.lessons)
        self._operation = None if operator is None else Operation(operator, self.session, self._view)
        for client in self._clients.values():
            with contextlib.suppress(Exception):
                self._view.welcome(client)

    def _hand_over(self) -> None:
        for number, client in self._clients.items():
            given = request_query(client).get("key", "")
            if self._key is None or secrets.compare_digest(given.encode(), self._key.encode()):
                self._operator = number
                if self._choose_language:
                    # The stage has one language: that of the first one who has the controls.
                    self._choose_language = False
                    self.session.change("lang", asked_by(client, request_query(client).get("lang")))
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
        script=software_script() + relay_script() + resume_script() + language_script(),
    )
    server.scene.world_axes.visible = False
    background = Background()
    book = load_lessons() if lessons is None else load_lessons(lessons)
    for problem in book.problems:
        log.warning("a lesson was left out: %s", problem)
    if lecture:
        return House(server, LectureHost(server, settings, key, background, people, book), background, people)
    return House(server, PrivateHost(server, settings, background, people, book), background, people)
