"""One visitor with a private session: the session, the page that shows it, and the controls."""

from collections.abc import Generator
from time import perf_counter
from typing import Final

import viser

from app.hosting.admission import Pieces
from app.hosting.app_context import AppContext
from app.hosting.attention import Attention
from app.hosting.resume import open_link, run_again
from app.hosting.visitor_record import VisitorRecord, same_tab, tab_id
from app.i18n.reader_language import language_of
from app.i18n.speaking import N_, set_language
from app.lessons.session.lesson_session import LessonSession
from app.lessons.translated_book import in_language
from app.page.operation import Operation
from app.page.panels.welcome import Welcome, is_for_newcomers
from app.page.view import View
from app.session.frame import freeze, make_frame
from app.session.halt import NOT_THE_VISITORS
from app.session.session import Session
from app.settings import Language, Settings
from app.web.request import browser_language, request_query

SAVING: Final = 1.0
"""Time from one record to the next [s]; the file follows at once."""

SAVING_AT_REST: Final = 30.0
"""The same where nothing happens [s]: the record is kept for a while after the tab was last there."""

NOT_SAVED: Final = N_("The server's disk cannot be written. Go on; saving is tried again.")


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
        self._welcomes = welcomes and parked is None and record is None and is_for_newcomers(self.query)
        self._welcome: Welcome | None = None
        self.is_back, self.superseded = parked is not None, False
        self._save_at, self._warned = 0.0, False
        self._attention, self._heard = Attention(), 0
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
        if not self.is_back and self._record is not None and same_tab(self._record.query, self.query):
            yield from run_again(self.session, self.lessons, self._record)

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

    def frame(self, now: float, elapsed: float) -> bool:
        """Advance and draw, but for a page that rests or is out of sight only now and then; a run that is out of sight stands still.

        Args:
            now: wall time [s].
            elapsed: wall time since the last round [s].

        Returns:
            Whether there was a frame.
        """
        workload, page = self._context.workload, self._context.server.page_of(self.client.client_id)
        hidden, heard = (False, self._heard) if page is None else (page.hidden, page.heard)
        stirred, self._heard = self.session.stirred or heard != self._heard, heard
        self.session.halt.set("hidden", hidden)
        if not self._attention.due(now, hidden, self.session.paused, stirred):
            return False
        set_language(self.language)
        if language_of(self.session.settings, self._browser) != self.language:
            self._translate()
        frame = make_frame(self.session, self.lessons.decide, now, elapsed, workload.budget)
        workload.drew(self.session.stepping)
        with self.client.atomic():
            self.view.show(frame)
            self.operation.show(frame)
            if self._welcome is not None:
                self._welcome.show()
            self._keep_record(now)
        self.client.flush()
        self._attention.note(now, frame.state)
        return True

    def _keep_record(self, now: float) -> None:
        """Hand over the record every `SAVING`, and say once if it cannot be written. `now`: wall time [s]."""
        store = self._context.store
        if not store.lasting or self.superseded or tab_id(self.query) is None or now < self._save_at:
            return
        self._save_at = now + (SAVING_AT_REST if self._attention.rests(now) else SAVING)
        self.save()
        if store.problem and not self._warned:
            self.operation.notify("This cannot be saved now", NOT_SAVED)
        self._warned = bool(store.problem)

    def save(self) -> None:
        """Keep settings and progress in the store."""
        record = VisitorRecord(self.query, self.session.settings, self.lessons.saved(), self.session.state())
        self._context.store.save(record)

    def supersede(self) -> None:
        """Leave everything to a later connection of the same tab."""
        self.save()
        self.superseded = True

    def leave(self) -> None:
        """Close the page after its connection has gone, and keep in the store what the visitor may come back for."""
        self.session.posts.drop()
        for reason in NOT_THE_VISITORS:
            self.session.halt.set(reason, False)
        self.operation.close()
        if self.superseded:
            self.session.close()
        else:
            self.save()
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
