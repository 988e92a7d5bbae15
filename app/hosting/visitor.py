"""One visitor's private stand, and the note of who comes and goes."""

import threading
from collections.abc import Callable
from time import perf_counter

import viser

from app.hosting.admission import Pieces
from app.hosting.resume import open_link
from app.i18n.reader_language import language_of
from app.i18n.speaking import set_language
from app.lessons.lesson import LessonBook
from app.lessons.session.lesson_session import LessonSession
from app.lessons.session.saved import SavedLesson
from app.lessons.translated_book import in_language
from app.page.operation import Operation
from app.page.view import View
from app.runtime.job_pool import JobPool
from app.session.clock import budget_of
from app.session.frame import freeze, make_frame
from app.session.input_sources import InputSources
from app.session.session import Session
from app.settings import Language, Settings
from app.web.request import browser_language, request_query
from app.web.server import DuetServer


class Visitor:
    """A session, what is seen of it, and what is operated. The page is there once `build` has come to its end.

    Args:
        client: the visitor's.
        settings: to begin with.
        problems: what was wrong with the visitor's link.
        wake: asks for a frame at once.
        background: computes for the session.
        people: who can be imitated.
        book: the lessons.
        found: what was kept of the visitor, and whether they are to be where they were.
        back: the visitor's own session and lessons, if they are back from having been away; None for new ones.

    Attributes:
        session, lessons: the visitor's.
        superseded: whether the same tab has come by another connection meanwhile.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        settings: Settings,
        problems: tuple[str, ...],
        wake: Callable[[], None],
        background: JobPool,
        people: InputSources,
        book: LessonBook,
        found: tuple[SavedLesson, bool] | None,
        back: tuple[Session, LessonSession] | None = None,
    ) -> None:
        self.client, self.query = client, request_query(client)
        self.superseded = False
        self.session = Session(settings, wake, background, people) if back is None else back[0]
        self._book, self._problems, self._found, self._back = book, problems, found, back
        self._browser: Language = browser_language(client)
        self._language: Language = language_of(self.session.settings, self._browser)
        set_language(self._language)
        self.lessons = LessonSession(self.session, in_language(book, self._language)) if back is None else back[1]
        self.view: View
        self.operation: Operation

    def build(self) -> Pieces:
        """Build the page piece by piece; the browser is sent the whole of it at once."""
        client = self.client
        with client.atomic():
            self._speak()
            self.view = View(client, self.session, lambda: [client], self.lessons)
            yield
            self._speak()
            self.view.show(freeze(self.session, perf_counter()))
            yield
            self._speak()
            self.operation = Operation(client, self.session, self.view)
            yield
            self._speak()
            self.view.welcome(client)
            if self._back is None:
                self.operation.notify_problems((*self._problems, *open_link(self.lessons, self.query, self._found)))
                self.operation.notify_lessons(self._book)

    def _speak(self) -> None:
        # Between two pieces the pages of others are drawn, perhaps in other languages.
        set_language(self._language)

    def _translate(self) -> None:
        """Make the page anew in another language; the session and the lessons go on where they are."""
        saved = self.lessons.saved()
        self.operation.close()
        self._language = language_of(self.session.settings, self._browser)
        set_language(self._language)
        self.lessons = LessonSession(self.session, in_language(self._book, self._language))
        if saved is not None:
            self.lessons.resume(saved, reopen=True)
        with self.client.atomic():
            self.client.gui.reset()
            self.view = View(self.client, self.session, lambda: [self.client], self.lessons)
            self.operation = Operation(self.client, self.session, self.view)
            self.view.welcome(self.client)

    @property
    def language(self) -> Language:
        """What the page speaks."""
        return self._language

    def halt(self, halted: bool) -> None:
        """Stop the session for the teacher, or let it go on as it did before."""
        self.session.halt.set("teacher", halted)

    def frame(self, now: float, elapsed: float, sessions: int) -> None:
        """Advance and draw. `now`: wall time [s]; `elapsed`: since the last frame [s]; `sessions`: that have a frame at this time."""
        self._speak()
        if language_of(self.session.settings, self._browser) != self._language:
            self._translate()
        frame = make_frame(self.session, self.lessons, now, elapsed, budget_of(sessions))
        with self.client.atomic():
            self.view.show(frame)
            self.operation.show(frame)
        self.client.flush()


class Connections:
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
