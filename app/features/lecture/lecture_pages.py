"""Pages of teachers and audiences."""

from collections.abc import Iterator
from contextlib import suppress

import viser

from app.features.classroom.class_downloads import ClassDownloads, Summaries
from app.features.lecture.audiences import Audience, Audiences
from app.features.lecture.overlays import Invitation
from app.features.lecture.participant import Participant
from app.features.lecture.presenter_keys import CLICKER_KEYS, PRESENTER_KEYS
from app.features.lecture.shared_page import SharedPage
from app.features.lecture.student_page import Answers
from app.features.lecture.teacher_control import TeacherControl
from app.features.lecture.teacher_panel import AssistantPanel, TeacherPanel
from app.features.lessons.panel.lesson_view import LessonView
from app.features.lessons.panel.lesson_visit import LessonServer, name_faults, open_link
from app.hosting.app_context import AppContext
from app.hosting.teacher_key import is_mistaken, is_teacher
from app.i18n.reader_language import language_of, look_of
from app.i18n.speaking import set_language
from app.page.operation import Operation
from app.page.panels.key_notice import name_mistake
from app.settings import ALONE, Language
from app.web.address import Address, find_address
from app.web.request import browser_language, request_address


class SharedControls:
    """Builds the teachers' pages; the operator's has the controls and sets the shared session's language.

    `address`: for the students; None before a teacher connects.
    """

    def __init__(self, context: AppContext, control: TeacherControl, summaries: Summaries) -> None:
        self._context, self._control, self._summaries = context, control, summaries
        self._library = context.part(LessonServer).library
        self._session, self._lessons = control.session, control.lessons
        self.operator: Participant | None = None
        self.operation: Operation | None = None
        self._browser: Language = "en"
        self.language: Language = language_of(context.options.settings, self._browser)
        self._last_operator = ""
        self.address: Address | None = None

    def release(self) -> None:
        if self.operation is not None:
            self.operation.close()
        self.operator, self.operation = None, None
        self._session.posts.drop()
        self._session.hand.hold(None)

    def admit(self, teacher: Participant) -> None:
        """With the controls, if they are free or this tab had them."""
        if self.operator is None:
            self.hand_over(teacher)
        elif teacher.id == self._last_operator:
            # The old connection is lost (which may be noticed later), or the tab was duplicated.
            self.take_over(teacher)
        else:
            self._build_page(teacher)

    def take_over(self, teacher: Participant) -> None:
        before = self.operator
        if before is teacher:
            return
        self.release()
        self.hand_over(teacher)
        if before is not None:
            with suppress(Exception):
                self._build_page(before)

    def hand_over(self, teacher: Participant) -> None:
        self.operator, self._browser = teacher, browser_language(teacher.client)
        is_back, self._last_operator = teacher.id == self._last_operator, teacher.id
        if not is_back:
            teacher.dress(self._session, self._context.options.settings)
        self.build_operator_page(teacher)
        assert self.operation is not None
        if not (is_back or self._lessons.open):
            self.operation.notify_problems(open_link(self._lessons, teacher.query, None))
        name_faults(self._session, self._library.book)

    @property
    def language_changed(self) -> bool:
        return language_of(self._session.settings, self._browser) != self.language

    def build_operator_page(self, operator: Participant) -> None:
        """Also translates the shared session."""
        self.language = language_of(self._session.settings, self._browser)
        set_language(self.language)
        self._lessons.translate(self._library.book.in_language(self.language))
        if self.operation is not None:
            self.operation.close()
        self._build_page(operator)

    def _build_page(self, teacher: Participant) -> None:
        client, leads, context = teacher.client, teacher is self.operator, self._context
        look = None if leads else look_of(teacher.query, browser_language(client), context.options.settings)
        language = self.language if look is None else look.language
        self.address = find_address(request_address(client), context.options.host, context.server.get_port())
        with client.atomic():
            if teacher.page is not None:
                client.gui.reset()
            teacher.page = SharedPage(client, self._control, context, language, look, lambda: [client])
            operation = None
            if leads:
                keys = () if ALONE in teacher.query else PRESENTER_KEYS
                operation = Operation(
                    client,
                    self._session,
                    teacher.page.view,
                    instead=keys,
                    panels=context.panels,
                    key_help=context.key_help,
                )
                self.operation = operation
            if isinstance(teacher.panel, TeacherPanel):
                teacher.panel.close()
            notes = self._library.notes if context.options.key is not None else None
            if operation is None:
                teacher.panel = AssistantPanel(client.gui, self._control, notes, teacher.ask_to_operate)
            elif ALONE not in teacher.query:
                downloads = ClassDownloads(
                    client,
                    self._session,
                    operation.handlers,
                    context.jobs,
                    self._summaries,
                    teacher.page.book,
                    language,
                )
                teacher.panel = TeacherPanel(client, self._control, self.address, notes, downloads)
            teacher.invitation = Invitation(client.gui, teacher.page.view)
            teacher.page.view.welcome(client)


class SharedAudiences:
    """Pages of the audiences."""

    def __init__(
        self, context: AppContext, control: TeacherControl, participants: dict[int, Participant]
    ) -> None:
        self._context, self._control, self._participants = context, control, participants
        self.pages: dict[Audience, SharedPage] = {}

    def update(self, audiences: Audiences) -> None:
        self.pages = {
            one: self.pages[one] if one in self.pages else self._build(one) for one in audiences.audiences
        }

    def watchers(self, audience: Audience) -> Iterator[Participant]:
        return (one for one in list(self._participants.values()) if one.audience is audience)

    def _build(self, audience: Audience) -> SharedPage:
        look = audience.look

        def clients() -> list[viser.ClientHandle]:
            return [one.client for one in self.watchers(audience)]

        return SharedPage(audience, self._control, self._context, look.language, look, clients)

    def admit(self, watcher: Participant) -> None:
        client, audience, student = watcher.client, watcher.audience, watcher.id
        assert audience is not None
        page = self.pages[audience]
        set_language(page.language)
        audience.contain_elements_of(client)
        page.view.welcome(client)
        if not watcher.screen:
            self._control.classroom.enter(
                client.client_id, student, self._context.server.page_of(client.client_id)
            )
            watcher.add_banner()
            watcher.invitation = Invitation(client.gui, page.view)
            watcher.answers = Answers(client, page.view.part(LessonView).panel, self._control, student)
        elif is_teacher(self._context.options.key, watcher.query):
            for hotkey in CLICKER_KEYS:
                hotkey.add_to(client.gui, self._control.post)
        if is_mistaken(self._context.options.key, watcher.query):
            name_mistake(client)
