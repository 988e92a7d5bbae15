"""Watchers' pages of the shared session or a group's."""

from collections.abc import Callable

import viser

from app.features.classroom.classroom import Poll
from app.features.classroom.classroom_html import poll_html, tied_html
from app.features.lecture.audiences import Audience
from app.features.lecture.overlays import ScreenView
from app.features.lecture.page_lines import WATCHING
from app.features.lecture.teacher_control import TeacherControl
from app.features.lessons.panel.lesson_html import record_html
from app.features.lessons.panel.lesson_panel import ORDER
from app.features.lessons.panel.lesson_view import LessonView
from app.features.lessons.session.lesson_session import LessonSession
from app.hosting.app_context import AppContext
from app.hosting.visitor import Visitor
from app.i18n.reader_language import look_of
from app.i18n.speaking import set_language, tr
from app.page.view import View
from app.session.frame import Frame
from app.settings import Language, Look
from app.web.address import Address
from app.web.request import browser_language, request_query


class SharedPage:
    """A page of the shared session, on the frame loop's thread. `look`: None for the operator's."""

    def __init__(
        self,
        host: Audience | viser.ClientHandle,
        control: TeacherControl,
        context: AppContext,
        language: Language,
        look: Look | None,
        clients: Callable[[], list[viser.ClientHandle]],
    ) -> None:
        self._host, self._control, self.book = host, control, control.lessons.english.in_language(language)
        self._clients, self._drawn = clients, False
        self.language: Language = language
        set_language(language)
        projects = isinstance(host, Audience) and host.screen
        with host.atomic():
            self.view = View(
                host, control.session, clients, look, language, folds=False, overlays=context.overlays
            )
            self._screen = ScreenView(host.gui, control, self.book) if projects else None
        self._poll: viser.GuiHtmlHandle | None = None
        self._shown: tuple[Poll | None, float | None] = None, None

    def show(self, frame: Frame, address: Address | None = None) -> Poll | None:
        """Returns the question in this language; None on a frozen projector, which keeps its picture."""
        set_language(self.language)
        presenter = self._control.presenter
        if self._screen is not None:
            self._screen.cover(address)
            if presenter.frozen and self._drawn:
                return None
        self._drawn = True
        poll, record = self._control.poll(self.book), self._control.record
        with self._host.atomic():
            if self._screen is not None:
                if self.view.bare == presenter.panels:
                    self.view.bare = not self.view.bare
                    for client in self._clients():
                        # The panels reduce the canvas, so the view has to be fitted again.
                        self.view.welcome(client)
                self._screen.show(poll)
            self.view.show(frame)
            tab, gui = self.view.part(LessonView).panel.tab, self._host.gui
            if self._poll is None and tab is not None:
                with tab:
                    self._poll = gui.add_html("", order=ORDER["verdict"] - 0.5)
            # A class's curves are too slow to draw in every frame.
            if self._poll is not None and (poll, record) != self._shown:
                self._shown = poll, record
                answers = poll_html(poll) + tied_html(poll) if poll is not None and poll.revealed else ""
                self._poll.content = answers + record_html(record)
        return poll

    def flush(self) -> None:
        self._host.flush()


class GroupMember:
    """A group's session in a member's language and look, on the frame loop's thread."""

    def __init__(self, context: AppContext, client: viser.ClientHandle, lead: Visitor) -> None:
        self.client, self._context = client, context
        self.session, self._book = lead.session, lead.session.parts.of(LessonSession).book
        look = look_of(request_query(client), browser_language(client), context.options.settings)
        self.language = look.language
        set_language(self.language)
        with client.atomic():
            # After a page of an earlier session.
            client.gui.reset()
            self.view = View(
                client,
                lead.session,
                lambda: [client],
                look,
                look.language,
                folds=False,
                tip=lambda _: tr(WATCHING),
                overlays=context.overlays,
            )
            self.view.welcome(client)

    def watches(self, lead: Visitor) -> bool:
        """True for the operator's session and lessons; a change of language makes new ones."""
        return self.session is lead.session and self._book is lead.session.parts.of(LessonSession).book

    def act(self) -> None:
        """Do nothing: the page has nothing to operate."""

    def show(self, frame: Frame) -> None:
        set_language(self.language)
        with self._context.guarded("a frame of a member's page failed", self.client.client_id):
            with self.client.atomic():
                self.view.show(frame)
            self.client.flush()
