"""One visitor with a private session."""

import logging
from collections.abc import Iterator, Mapping
from math import inf
from time import perf_counter
from typing import Final, Protocol

import viser

from app.hosting.admission import Pieces
from app.hosting.app_context import AppContext
from app.hosting.frame_loop import Attention
from app.hosting.server_part import Visit
from app.hosting.visitor_record import VisitorRecord, same_tab, tab_id
from app.i18n.reader_language import language_of
from app.i18n.speaking import set_language, tr
from app.page.operation import Operation
from app.page.view import View
from app.session.clock import NOT_THE_VISITORS
from app.session.frame import Frame, freeze, make_frame
from app.session.session import Session
from app.session.session_state import go_on_from, state_of
from app.settings import MOTION, OPENED, PANEL, PUSH, Language, Settings, asks_for_nothing
from app.web.request import browser_language, request_query
from controllers.errors import BadInputFile
from scenes.run_text import run_of_text
from scenes.settings import RunSettings

SAVING: Final = 1.0
"""Time between records [s]; the file follows at once."""

SAVING_AT_REST: Final = 30.0
"""Time between a resting page's records [s]; a record's age counts from the tab's last presence."""


class Beside(Protocol):
    """Another person's page of the same session."""

    client: viser.ClientHandle

    def act(self) -> None: ...

    def show(self, frame: Frame) -> None:
        """Draw a frame; never raises."""


class Visitor:
    """A private session, claimed from the store or new, and its page, which exists once `build` has ended.

    Args:
        private: the session belongs to no student: others may join it.
        query: key of the session in the store; None for the page's own.

    Attributes:
        is_back: the session was claimed from the store.
        superseded: the same tab has connected again.
        beside: pages of others who see the session.
    """

    def __init__(
        self,
        context: AppContext,
        client: viser.ClientHandle,
        settings: Settings,
        problems: tuple[str, ...] = (),
        record: VisitorRecord | None = None,
        private: bool = False,
        query: dict[str, str] | None = None,
    ) -> None:
        self._context, self._problems, self._record = context, problems, record
        self.client, self.query = client, query or request_query(client)
        self._private = private
        self._browser: Language = browser_language(client)
        self.beside: tuple[Beside, ...] = ()
        self._reloaded = context.store.is_reload(self.query)
        parked = context.store.claim(self.query)
        self.is_back, self.superseded = parked is not None, False
        self._saved_at, self._trouble = -inf, None
        self._attention, self._heard = Attention(), 0
        self.session = parked or Session(settings, context.wake, context.jobs, context.law)
        # A link, or the server's own settings, decide how the page begins.
        usual = context.options.settings.run == RunSettings()
        self.session.hand.source.opens = private and usual and asks_for_nothing(self.query)
        if parked is None and record is not None:
            self.session.parts.restore(record.parts, record.recordings)
        self.language: Language = language_of(self.session.settings, self._browser)
        set_language(self.language)
        visit = Visit(
            self.session, self.language, self.query, private, self.is_back, parked is None and record is None
        )
        made = (part.visit(visit) for part in context.parts)
        self._parts = tuple(part for part in made if part is not None)
        self.view: View
        self.operation: Operation

    def build(self) -> Pieces:
        """Build the page in pieces, for the browser at once. A failure parks a claimed session and closes a
        new one.
        """
        try:
            yield
            yield from self._pieces()
        except BaseException:
            # Also if the tab is closed before its page is whole.
            if self.is_back:
                self._context.store.park(self.query, self.session)
            else:
                self.session.close()
            raise

    def _pieces(self) -> Pieces:
        with self.client.atomic():
            yield from self._page(self.query.get(PANEL) != "small")
            if not self.is_back:
                opened = (problem for part in self._parts for problem in part.open(self._record))
                self.operation.notify_problems((*self._problems, *opened))
                for part in self._parts:
                    part.notify()
        if self.is_back:
            if self._reloaded:
                self._replay_link()
            return
        if self._record is not None and same_tab(self._record.query, self.query):
            yield from run_again(self.session, self._record)
            if self._record.query.get(OPENED) != self.query.get(OPENED):
                self._replay_link()
        else:
            self._begin_run()

    def _page(self, whole: bool) -> Pieces:
        client = self.client
        self.view = View(client, self.session, lambda: [client], overlays=self._context.overlays)
        yield
        self.view.show(freeze(self.session, perf_counter()))
        yield
        self.operation = Operation(
            client,
            self.session,
            self.view,
            whole=whole,
            private=self._private,
            owners=self._private and self._context.server.is_owners(self.client.client_id),
            panels=self._context.panels,
            key_help=self._context.key_help,
        )
        for part in self._parts:
            part.add_to(client, self.view)
        yield
        self.view.welcome(client)

    def _begin_run(self) -> None:
        if MOTION in self.query and not self.session.parts.lead:
            self.session.control.halt.set("visitor")
        self._replay_link()

    def _replay_link(self) -> None:
        for part in self.session.parts:
            self.operation.notify_problems(part.open_link(self.query))
        if PUSH in self.query:
            try:
                # Shown in place of a file's name.
                self.session.player.watch_file(run_of_text(self.query[PUSH]), tr("a push from a link"))
            except BadInputFile as error:
                self.operation.notify_problems((str(error),))

    def _translate(self) -> None:
        self.operation.close()
        self.language = language_of(self.session.settings, self._browser)
        set_language(self.language)
        for part in self._parts:
            part.renew(self.language)
        with self.client.atomic():
            self.client.gui.reset()
            # All pieces at once: the visitor is waiting.
            for _ in self._page(self.operation.whole):
                pass

    def frame(self, now: float, elapsed: float) -> None:
        """Advance and draw; a hidden run is paused. `now`: wall time, `elapsed`: since the last round [s]."""
        workload = self._context.workload
        clients = self.client, *(one.client for one in self.beside)
        pages = [page for one in clients if (page := self._context.server.page_of(one.client_id)) is not None]
        # The run continues while at least one person sees it.
        hidden, heard = bool(pages) and all(page.hidden for page in pages), sum(page.heard for page in pages)
        dirty, self._heard = self.session.dirty or heard != self._heard, heard
        self.session.control.halt.set("hidden", hidden)
        if not self._attention.due(now, hidden, self.session.paused, dirty):
            return
        set_language(self.language)
        outdated = [part for part in self._parts if part.outdated]
        if outdated or language_of(self.session.settings, self._browser) != self.language:
            self._translate()
        for part in outdated:
            part.notify()
        for one in self.beside:
            one.act()
        frame = make_frame(self.session, now, elapsed, workload.budget)
        workload.drew(self.session.control.stepping)
        with self.client.atomic():
            self.view.show(frame)
            self.operation.show(frame, dirty)
            for part in self._parts:
                part.show(frame)
            self._keep_record(now)
        self.client.flush()
        for one in self.beside:
            one.show(frame)
        self._attention.note(now, frame.state)

    def _keep_record(self, now: float) -> None:
        store = self._context.store
        if not store.lasting or self.superseded or tab_id(self.query) is None:
            return
        if now >= self._saved_at + (SAVING_AT_REST if self._attention.rests(now) else SAVING):
            self._saved_at = now
            self.save()
        trouble = store.trouble
        if trouble is not None and trouble != self._trouble:
            self.session.notify(*trouble)
        self._trouble = trouble

    def record(self) -> VisitorRecord:
        return record_of(self.query, self.session)

    def save(self) -> None:
        if not self.superseded:
            self._context.store.save(self.record())

    def leave(self) -> None:
        """Close the page; keep the session for the visitor's return."""
        self.session.posts.drop()
        for reason in NOT_THE_VISITORS:
            self.session.control.halt.set(reason, False)
        self.operation.close()
        if self.superseded:
            self.session.close()
        else:
            self.save()
            self._context.store.park(self.query, self.session)


log = logging.getLogger("duet.hosts")


def record_of(query: Mapping[str, str], session: Session) -> VisitorRecord:
    parts = session.parts
    return VisitorRecord(query, session.settings, state_of(session), parts.saved(), parts.recordings())


def run_again(session: Session, record: VisitorRecord) -> Iterator[None]:
    """Continue a record's run after its settings and parts; yield every few repeated steps."""
    histories = [part.history for part in session.parts]
    if record.state is None or None in histories:
        return
    try:
        yield from go_on_from(
            session, record.state, max((one for one in histories if one is not None), default=0.0)
        )
        for part in session.parts:
            part.run_restored()
    except Exception:
        log.exception("a session could not continue from its record, and starts again")
        session.reset()
