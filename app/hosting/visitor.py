"""One visitor with a private session: the session, the page that shows it, the controls, and what a link or a record asks for."""

import logging
from collections.abc import Iterator, Mapping
from math import inf
from time import perf_counter
from typing import Final, Protocol

import viser

from app.hosting.admission import Pieces
from app.hosting.app_context import AppContext
from app.hosting.frame_loop import Attention
from app.hosting.teacher_key import is_teacher
from app.hosting.visitor_record import VisitorRecord, lesson_link, same_tab, tab_id
from app.i18n.reader_language import language_of
from app.i18n.speaking import set_language, tr
from app.lessons.runs import LONGEST
from app.lessons.session.lesson_session import LessonSession
from app.page.operation import Operation
from app.page.panels.teachers_tab import TeachersTab
from app.page.panels.welcome import Welcome, is_for_newcomers
from app.page.view import View
from app.session.clock import NOT_THE_VISITORS
from app.session.frame import Frame, freeze, make_frame
from app.session.session import Session
from app.settings import MOTION, OPENED, PANEL, PUSH, WHOLE, Language, Settings
from app.web.request import browser_language, request_query
from controllers.errors import BadInputFile, LazyText
from scenes.run_text import run_of_text

SAVING: Final = 1.0
"""Time from one record to the next [s]; the file follows at once."""

SAVING_AT_REST: Final = 30.0
"""The same where nothing happens [s]: the record is kept for a while after the tab was last there."""


class Beside(Protocol):
    """The page of another person, who sees the same session."""

    client: viser.ClientHandle

    def act(self) -> None:
        """Do what this person's browser has asked for."""

    def show(self, frame: Frame) -> None:
        """Draw a frame; it raises nothing."""


class Visitor:
    """A session with its page: the visitor's own one, claimed from the store, or a new one. The page is there once `build` has come to
    its end.

    Args:
        problems: what is wrong with the visitor's link.
        private: whether this is no student's session: newcomers are greeted, a teacher has the notes, and others may join.
        query: under which the store has session and lessons; None for that of the page.

    Attributes:
        is_back: whether the session was claimed from the store.
        superseded: whether the same tab has connected again meanwhile.
        beside: the pages of others who see it.
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
        # A law is a program: only the person who started the server writes one here.
        self._edited = context.options.edited_law if private and context.server.is_owners(client.client_id) else None
        self._browser: Language = browser_language(client)
        self.beside: tuple[Beside, ...] = ()
        self._reloaded = context.store.is_reload(self.query)
        parked = context.store.claim(self.query)
        self._welcomes = private and parked is None and record is None and is_for_newcomers(self.query)
        self._welcome: Welcome | None = None
        self._teaches = private and is_teacher(context.options.key, self.query)
        self._notes: TeachersTab | None = None
        self.is_back, self.superseded = parked is not None, False
        self._saved_at, self._trouble = -inf, None
        self._attention, self._heard = Attention(), 0
        self.session = parked[0] if parked else Session(settings, context.wake, context.jobs, context.sources)
        if parked is None and record is not None:
            self.session.parts.restore(record.parts)
        self.language: Language = language_of(self.session.settings, self._browser)
        set_language(self.language)
        self.lessons = parked[1] if parked else LessonSession(self.session, context.book.in_language(self.language))
        self.view: View
        self.operation: Operation

    def build(self) -> Pieces:
        """Build the page piece by piece; the browser is sent the whole of it at once. If it does not become whole, a session that was
        claimed goes back to the store, and a new one is closed."""
        try:
            yield
            yield from self._pieces()
        except BaseException:
            # Also of a tab that is closed before its page is whole.
            if self.is_back:
                self._context.store.park(self.query, self.session, self.lessons)
            else:
                self.session.close()
            raise

    def _pieces(self) -> Pieces:
        with self.client.atomic():
            yield from self._page(self.query.get(PANEL) != "small")
            if not self.is_back:
                self.operation.notify_problems((*self._problems, *open_link(self.lessons, self.query, self._record)))
                self.operation.notify_lessons(self._context.book)
        if self.is_back:
            if self._reloaded:
                self._replay_link()
            return
        if self._record is not None and same_tab(self._record.query, self.query):
            yield from run_again(self.session, self.lessons, self._record)
            if self._record.query.get(OPENED) != self.query.get(OPENED):
                self._replay_link()
        else:
            self._begin_run()

    def _page(self, whole: bool) -> Pieces:
        """Draw the page in the present language. `whole`: see `Operation`."""
        client = self.client
        self.view = View(client, self.session, lambda: [client], self.lessons, overlays=self._context.overlays)
        yield
        self.view.show(freeze(self.session, perf_counter()))
        yield
        self.operation = Operation(
            client,
            self.session,
            self.view,
            whole=whole,
            private=self._private,
            edited=self._edited,
            panels=self._context.panels,
        )
        if self._welcomes and self.lessons.book.lessons:
            self._welcome = Welcome(client.gui, self.session, self.lessons)
        if self._teaches:
            self._notes = TeachersTab(client.gui, self._context.library.notes)
        yield
        self.view.welcome(client)

    def _begin_run(self) -> None:
        """Do what a link asks of a run that begins, besides settings and lesson."""
        if MOTION in self.query and not self.lessons.open:
            self.session.halt.set("visitor")
        self._replay_link()

    def _replay_link(self) -> None:
        """Replay the run that a link holds; the visitor's own run stands meanwhile, and goes on when the replay is left."""
        for part in self.session.parts:
            self.operation.notify_problems(part.open_link(self.query))
        if PUSH in self.query:
            try:
                # In place of a file's name.
                self.session.player.watch_file(run_of_text(self.query[PUSH]), tr("a push from a link"))
            except BadInputFile as error:
                self.operation.notify_problems((str(error),))

    def _translate(self) -> None:
        """Build the page again in another language, or with lessons that were read again; the session goes on where it is."""
        saved = self.lessons.saved()
        self.operation.close()
        self.language = language_of(self.session.settings, self._browser)
        set_language(self.language)
        self.lessons = LessonSession(self.session, self._context.book.in_language(self.language))
        if saved is not None:
            self.lessons.resume(saved, reopen=True)
        with self.client.atomic():
            self.client.gui.reset()
            # At once: the visitor looks on.
            for _ in self._page(self.operation.whole):
                pass

    def frame(self, now: float, elapsed: float) -> None:
        """Advance and draw, but for a page that rests or is out of sight only now and then; a run that is out of sight stands still.

        Args:
            now: wall time [s].
            elapsed: wall time since the last round [s].
        """
        workload = self._context.workload
        clients = self.client, *(one.client for one in self.beside)
        pages = [page for one in clients if (page := self._context.server.page_of(one.client_id)) is not None]
        # The run goes on as long as one person sees it.
        hidden, heard = bool(pages) and all(page.hidden for page in pages), sum(page.heard for page in pages)
        stirred, self._heard = self.session.stirred or heard != self._heard, heard
        self.session.halt.set("hidden", hidden)
        if not self._attention.due(now, hidden, self.session.paused, stirred):
            return
        set_language(self.language)
        reread = self._context.book.in_language(self.language) is not self.lessons.book
        if reread or language_of(self.session.settings, self._browser) != self.language:
            self._translate()
        if reread:
            self.operation.notify_lessons(self._context.book)
        for one in self.beside:
            one.act()
        frame = make_frame(self.session, self.lessons.decide, now, elapsed, workload.budget)
        workload.drew(self.session.stepping)
        with self.client.atomic():
            self.view.show(frame)
            self.operation.show(frame, stirred)
            if self._welcome is not None:
                self._welcome.show(frame)
            if self._notes is not None:
                self._notes.show(self.lessons, workload.report)
            self._keep_record(now)
        self.client.flush()
        for one in self.beside:
            one.show(frame)
        self._attention.note(now, frame.state)

    def _keep_record(self, now: float) -> None:
        """Hand over the record every `SAVING`, after a rest at once, and say once what is wrong with the store. `now`: wall time [s]."""
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
        """What this visitor can come back to."""
        session = self.session
        return VisitorRecord(self.query, session.settings, self.lessons.saved(), session.state(), session.parts.saved())

    def save(self) -> None:
        """Keep settings and progress in the store, unless they have gone on at a later connection of the same tab."""
        if not self.superseded:
            self._context.store.save(self.record())

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


log = logging.getLogger("duet.hosts")


def open_link(run: LessonSession, query: Mapping[str, str], record: VisitorRecord | None) -> tuple[str, ...]:
    """Open the lesson of a link, or resume a visitor's record; return a message for every part of the link that is not possible.

    Args:
        record: of the visitor; by the same lesson link its lesson is open again, by another one only its progress counts.
    """
    lesson, step = lesson_link(query)
    if record is not None and record.lessons is not None:
        same = lesson_link(record.query) == (lesson, step)
        run.resume(record.lessons, reopen=same)
        if same:
            return ()
    if not lesson:
        return (LazyText("step = {step} needs lesson = … beside it.", step=step),) if step else ()
    index, problem = step_of(step)
    by_number = lesson.isascii() and lesson.isdecimal()
    known = [str(one.number) if by_number else one.id for one in run.book.lessons]
    # 03 is lesson 3.
    name = str(int(lesson)) if by_number else lesson
    if name not in known:
        names = ", ".join(known) or LazyText("none: the folder holds no lesson")
        return (LazyText("There is no lesson {id}; choose from {names}.", id=lesson, names=names),)
    run.enter(known.index(name), index)
    if query.get(WHOLE) == "1":
        run.vary(query)
    return (problem,) if problem else ()


def run_again(session: Session, lessons: LessonSession, record: VisitorRecord) -> Iterator[None]:
    """Go on with the run of a record, after its settings and its lesson; yield every few steps that are made again for it."""
    saved = record.lessons if lessons.open else None
    if record.state is None or (saved is not None and saved.now is None):
        # The run that shows why an answer is wrong begins again.
        return
    try:
        yield from session.go_on_from(record.state, LONGEST if saved is not None else 0.0)
        lessons.run_goes_on(saved is not None and saved.measured)
    except Exception:
        log.exception("a session could not go on from its record, and begins again")
        session.reset()


def step_of(text: str) -> tuple[int, str]:
    """Return the step of a link, from 0, and the message if its text is not valid, else ""."""
    if not text:
        return 0, ""
    if text.isascii() and text.isdecimal() and int(text) >= 1:
        return int(text) - 1, ""
    return 0, LazyText("step = {step} is not a number from 1.", step=text)
