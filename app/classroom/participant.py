"""One browser in a lecture: who it belongs to, and what its page has beside the stage."""

import contextlib

import viser

from app.classroom.ballots import Ballot
from app.classroom.classroom import Classroom, Poll
from app.classroom.classroom_html import EXPLORING, FOLLOWING, HALTED, NAMELESS, WATCHING
from app.classroom.presenter import Presenter
from app.classroom.stage_page import StagePage
from app.classroom.student_answers import Answers, Banner, is_narrow
from app.classroom.teacher_panel import TeacherPanel
from app.hosting.visitor import Visitor
from app.hosting.visitor_record import tab_id
from app.i18n.speaking import tr
from app.lessons.session.lesson_session import LessonSession
from app.page.view import View
from app.web.audiences import SCREEN, Audience
from app.web.request import request_query


class Participant:
    """One browser.

    Args:
        teacher: whether it may lead.
        audience: with which it watches the stage; None for a page of its own.

    Attributes:
        id: of its tab, or of its connection if the tab has none.
        lasting: whether the id outlives a reload.
        screen: whether it is a projector, and no student's.
        narrow: whether its window has no room for lesson, stage and controls beside each other.
        page: the stage on a teacher's own page; None for all others.
        banner, answers, panel: what it has beside the stage; None for what it has not.
        visitor: the student's breakout session; None while the student sees the stage.
        moved: whether it was asked to connect again.
    """

    def __init__(self, client: viser.ClientHandle, teacher: bool, audience: Audience | None) -> None:
        self.client, self.teacher, self.audience = client, teacher, audience
        self.query = request_query(client)
        tab = tab_id(self.query)
        self.id, self.lasting = tab or f"tab {client.client_id}", tab is not None
        self.screen, self.narrow, self.moved = SCREEN in self.query, is_narrow(client), False
        self.page: StagePage | None = None
        self.banner: Banner | None = None
        self.answers: Answers | None = None
        self.panel: TeacherPanel | None = None
        self.visitor: Visitor | None = None
        # In another language the view is a new one, and has no banner yet.
        self._view: View | None = None
        self._shown: object = None

    def show_panel(self, presenter: Presenter, room: Classroom, poll: Poll | None, lessons: LessonSession, screens: int) -> None:
        """Update a teacher's panel. `poll`: the question on the stage; `lessons`: the stage's; `screens`: how many projectors there are."""
        if self.panel is not None:
            with contextlib.suppress(Exception), self.client.atomic():
                self.panel.show(presenter, room, poll, lessons, screens)

    def show(self, room: Classroom, poll: Poll | None, mine: Ballot | None, view: View, lessons: LessonSession) -> None:
        """Update what a student's page has beside the stage.

        Args:
            poll: the question on the stage.
            mine: what the student has handed in; None for no question, or no student.
            view, lessons: the stage's, or the student's own ones.
        """
        if self.visitor is not None and self._view is not view:
            self._view, self.banner, self._shown = view, Banner(self.client.gui), None
        if self.banner is None:
            return
        line, tab = self._line(room), view.lesson_panel.tab if lessons.open and self.narrow else None
        shown = line, tab, None if self.answers is None else (lessons.open, poll, mine, view.lesson_panel.tab)
        # Opening a batch for each of thirty pages in every frame would cost a message each.
        if shown == self._shown:
            return
        self._shown = shown
        with contextlib.suppress(Exception), self.client.atomic():
            self.banner.show(*line, tab)
            if self.answers is not None:
                self.answers.fold(lessons.open)
                self.answers.show(poll, mine)

    def _line(self, room: Classroom) -> tuple[str, str]:
        """Return kind and text of the banner."""
        if room.paused:
            return "halt", tr(HALTED)
        if self.visitor is not None:
            return "own", tr(EXPLORING)
        if room.free:
            return "wait", tr(WATCHING, most=room.places.most) if self.lasting else tr(NAMELESS)
        return "follow", tr(FOLLOWING)
