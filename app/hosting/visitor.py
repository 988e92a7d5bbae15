"""One visitor with a private session: the session, the page that shows it, and the controls."""

from collections.abc import Generator
from time import perf_counter

import viser

from app.hosting.admission import Pieces
from app.hosting.app_context import AppContext
from app.hosting.resume import open_link
from app.hosting.session_store import VisitorRecord
from app.i18n.reader_language import language_of
from app.i18n.speaking import set_language
from app.lessons.session.lesson_session import LessonSession
from app.lessons.translated_book import in_language
from app.page.operation import Operation
from app.page.panels.welcome import Welcome, is_for_newcomers
from app.page.view import View
from app.session.clock import budget_of
from app.session.frame import freeze, make_frame
from app.session.session import Session
from app.settings import Language, Settings
from app.web.request import browser_language, request_query


class Visitor:
    """A session with its page. The page is there once `build` has come to its end.

    Args:
        problems: what is wrong with the visitor's link.
        welcomes: whether a newcomer is greeted.
        parked: the visitor's own session and lessons, claimed from the store; None for new ones.

    Attributes:
        is_back: whether the session was claimed from the store.
        superseded: whether the same tab has connected again meanwhile.
    """

    def __init__(
        self,
        context: AppContext,
        client: viser.ClientHandle,
        settings: Settings,
        problems: tuple[str, ...] = (),
        record: VisitorRecord | None = None,
        parked: tuple[Session, LessonSession] | None = None,
        welcomes: bool = False,
    ) -> None:
        self._context, self._problems, self._record = context, problems, record
        self.client, self.query = client, request_query(client)
        self._welcomes = welcomes and parked is None and is_for_newcomers(self.query)
        self._welcome: Welcome | None = None
        self.is_back, self.superseded = parked is not None, False
        self.session = parked[0] if parked else Session(settings, context.wake, context.jobs, context.sources)
        self._browser: Language = browser_language(client)
        self.language: Language = language_of(self.session.settings, self._browser)
        set_language(self.language)
        self.lessons = parked[1] if parked else LessonSession(self.session, in_language(context.book, self.language))
        self.view: View
        self.operation: Operation

    def build(self) -> Pieces:
        """Build the page piece by piece; the browser is sent the whole of it at once."""
        client = self.client
        with client.atomic():
            # Between two pieces the pages of others are drawn, perhaps in other languages.
            set_language(self.language)
            self.view = View(client, self.session, lambda: [client], self.lessons)
            yield
            set_language(self.language)
            self.view.show(freeze(self.session, perf_counter()))
            yield
            set_language(self.language)
            self.operation = Operation(client, self.session, self.view)
            self._greet()
            yield
            set_language(self.language)
            self.view.welcome(client)
            if not self.is_back:
                self.operation.notify_problems((*self._problems, *open_link(self.lessons, self.query, self._record)))
                self.operation.notify_lessons(self._context.book)

    def _greet(self) -> None:
        if self._welcomes and self.lessons.book.lessons:
            self._welcome = Welcome(self.client.gui, self.session, self.lessons)

    def _translate(self) -> None:
        """Build the page again in another language; the session and the lessons go on where they are."""
        saved = self.lessons.saved()
        self.operation.close()
        self.language = language_of(self.session.settings, self._browser)
        set_language(self.language)
        self.lessons = LessonSession(self.session, in_language(self._context.book, self.language))
        if saved is not None:
            self.lessons.resume(saved, reopen=True)
        with self.client.atomic():
            self.client.gui.reset()
            self.view = View(self.client, self.session, lambda: [self.client], self.lessons)
            self.operation = Operation(self.client, self.session, self.view)
            self._greet()
            self.view.welcome(self.client)

    def frame(self, now: float, elapsed: float, sessions: int) -> None:
        """Advance and draw. `now`: wall time [s]; `elapsed`: since the last frame [s]; `sessions`: that have a frame at this time."""
        set_language(self.language)
        if language_of(self.session.settings, self._browser) != self.language:
            self._translate()
        frame = make_frame(self.session, self.lessons.decide, now, elapsed, budget_of(sessions))
        with self.client.atomic():
            self.view.show(frame)
            self.operation.show(frame)
            if self._welcome is not None:
                self._welcome.show()
        self.client.flush()

    def save(self) -> None:
        """Keep settings and progress in the store."""
        self._context.store.save(VisitorRecord(self.query, self.session.settings, self.lessons.saved()))

    def leave(self) -> None:
        """Close the page after its connection has gone, and keep in the store what the visitor may come back for."""
        self.session.posts.drop()
        self.session.halt.set("teacher", False)
        self.save()
        self.operation.close()
        if self.superseded:
            self.session.close()
        else:
            self._context.store.park(self.query, self.session, self.lessons)


def open_visitor(
    context: AppContext,
    client: viser.ClientHandle,
    settings: Settings,
    problems: tuple[str, ...] = (),
    record: VisitorRecord | None = None,
    welcomes: bool = False,
) -> Generator[None, None, Visitor]:
    """Build the page of a visitor who has connected piece by piece, and return the visitor; see `Visitor` for the arguments."""
    query = request_query(client)
    parked = context.store.claim(query)
    visitor: Visitor | None = None
    try:
        visitor = Visitor(context, client, settings, problems, record, parked, welcomes)
        yield
        yield from visitor.build()
    except BaseException:
        # Also of a tab that is closed before its page is whole.
        if parked is not None:
            context.store.park(query, *parked)
        elif visitor is not None:
            visitor.session.close()
        raise
    return visitor
