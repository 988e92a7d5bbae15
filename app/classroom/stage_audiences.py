"""The stage as students and projectors watch it: drawn once for every audience, that is, for every look."""

from collections.abc import Iterator

import viser

from app.classroom.classroom import Classroom
from app.classroom.participant import Participant
from app.classroom.stage_page import StagePage
from app.classroom.student_answers import Answers
from app.classroom.teacher_control import TeacherControl
from app.hosting.app_context import AppContext
from app.hosting.teacher_key import is_mistaken, is_teacher
from app.i18n.speaking import set_language
from app.lessons.session.lesson_session import LessonSession
from app.page.panels.hotkeys import CLICKER_KEYS
from app.page.panels.key_notice import name_mistake
from app.session.session import Session
from app.web.audiences import Audience, Audiences


class StageAudiences:
    """The stage's pages for the audiences.

    Args:
        control: takes the students' answers.
    """

    def __init__(
        self,
        context: AppContext,
        session: Session,
        lessons: LessonSession,
        room: Classroom,
        control: TeacherControl,
        participants: dict[int, Participant],
    ) -> None:
        self._context, self._session, self._lessons, self._control = context, session, lessons, control
        self._room, self._participants = room, participants
        self.pages: dict[Audience, StagePage] = {}

    def update(self, audiences: Audiences) -> None:
        """Build pages for new audiences, and drop those of audiences without a watcher."""
        self.pages = {one: self.pages[one] if one in self.pages else self._build(one) for one in audiences.audiences}

    def watchers(self, audience: Audience) -> Iterator[Participant]:
        """Yield the participants of an audience."""
        return (one for one in list(self._participants.values()) if one.audience is audience)

    def _build(self, audience: Audience) -> StagePage:
        look, book = audience.look, self._context.book

        def clients() -> list[viser.ClientHandle]:
            return [one.client for one in self.watchers(audience)]

        presenter = self._control.presenter if audience.screen else None
        return StagePage(audience, self._session, self._lessons, book, look.language, look, clients, presenter)

    def admit(self, watcher: Participant) -> None:
        """Welcome a student or a projector; a student gets banner and answers, and a projector with the teacher's key a clicker's keys."""
        client, audience, student = watcher.client, watcher.audience, watcher.id
        assert audience is not None
        page = self.pages[audience]
        set_language(page.language)
        audience.contain_elements_of(client)
        page.view.welcome(client)
        if not watcher.screen:
            self._room.enter(client.client_id, student)
            watcher.add_banner()
            watcher.answers = Answers(client, page.view.lesson_panel, self._control, student)
        elif is_teacher(self._context.key, watcher.query):
            for hotkey in CLICKER_KEYS:
                hotkey.add_to(client.gui, self._control.post)
        if is_mistaken(self._context.key, watcher.query):
            name_mistake(client)
