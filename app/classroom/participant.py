"""One browser in a lecture: who it belongs to, and what its page has beside the stage."""

import contextlib
from dataclasses import dataclass

import viser

from app.classroom.classroom import Classroom, Poll
from app.classroom.classroom_html import EXPLORING, FOLLOWING, HALTED, NAMELESS, WATCHING
from app.classroom.stage_page import StagePage
from app.classroom.student_answers import Answers, Banner
from app.classroom.teacher_panel import TeacherPanel
from app.hosting.visitor import Visitor
from app.i18n.speaking import tr
from app.lessons.session.lesson_session import LessonSession
from app.page.view import View
from app.web.audiences import Audience


@dataclass
class Participant:
    """One browser.

    Attributes:
        id: of its tab, or of its connection if the tab has none.
        lasting: whether the id outlives a reload.
        screen: whether it is a projector, and no student's.
        teacher: whether it may lead.
        narrow: whether its window has no room for lesson, stage and controls beside each other.
        audience: with which it watches the stage; None for a page of its own.
        page: the stage on a teacher's own page; None for all others.
        banner, answers, panel: what it has beside the stage; None for what it has not.
        visitor: the student's breakout session; None while the student sees the stage.
        view: in which the banner was made; a new one in another language.
        moved: whether it was asked to connect again.
        shown: what the banner and the answers show.
    """

    client: viser.ClientHandle
    query: dict[str, str]
    id: str
    lasting: bool
    screen: bool
    teacher: bool
    narrow: bool
    audience: Audience | None = None
    page: StagePage | None = None
    banner: Banner | None = None
    answers: Answers | None = None
    panel: TeacherPanel | None = None
    visitor: Visitor | None = None
    view: View | None = None
    moved: bool = False
    shown: object = None

    def show(self, room: Classroom, poll: Poll | None, mine: int | None, view: View, lessons: LessonSession) -> None:
        """Update what the page has beside the stage.

        Args:
            poll: the question on the stage.
            mine: the student's own answer to it.
            view, lessons: the stage's, or the student's own ones.
        """
        if self.visitor is not None and self.view is not view:
            self.view, self.banner, self.shown = view, Banner(self.client.gui), None
        if self.panel is not None:
            with contextlib.suppress(Exception), self.client.atomic():
                self.panel.show(room, poll, lessons)
        if self.banner is None:
            return
        line, tab = self._line(room), view.lesson_panel.tab if lessons.open and self.narrow else None
        shown = line, tab, None if self.answers is None else (lessons.open, poll, mine, view.lesson_panel.tab)
        # Opening a batch for each of thirty pages in every frame would cost a message each.
        if shown == self.shown:
            return
        self.shown = shown
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
