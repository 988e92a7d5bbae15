"""One browser in a lecture: whose it is, and what it has beside the stage."""

import contextlib
from dataclasses import dataclass

import viser

from app.classroom.classroom import Classroom
from app.classroom.classroom_html import EXPLORING, FOLLOWING, HALTED, NAMELESS, WATCHING
from app.classroom.stage_page import StagePage
from app.classroom.student_answers import Answers, Banner
from app.classroom.teacher_panel import ClassState, TeacherPanel
from app.hosting.visitor import Visitor
from app.i18n.speaking import tr
from app.lessons.session.lesson_session import LessonSession
from app.page.view import View
from app.web.audience import Audience


@dataclass
class Participant:
    """One browser.

    Attributes:
        client, query: as it came.
        who: the word that its tab keeps, or one of ours if it keeps none.
        lasting: whether the word outlives a reload.
        screen: whether it only shows (a projector), and is no student's.
        teacher: whether it may lead.
        narrow: whether its window has no room for everything beside each other.
        audience: with whom it watches the stage; None for a page of its own.
        showing: the stage on a teacher's own page; None for everybody else.
        banner, answers, panel: what it has beside the stage; None for what it has not.
        stand: its own session; None while it sees the stage.
        view: what the banner stands on; another one in another language.
        moved: whether it was asked to come again.
        shown: what the banner and the answers were made of.
    """

    client: viser.ClientHandle
    query: dict[str, str]
    who: str
    lasting: bool
    screen: bool
    teacher: bool
    narrow: bool
    audience: Audience | None = None
    showing: StagePage | None = None
    banner: Banner | None = None
    answers: Answers | None = None
    panel: TeacherPanel | None = None
    stand: Visitor | None = None
    view: View | None = None
    moved: bool = False
    shown: object = None

    def show(self, room: Classroom, state: ClassState, mine: int | None, view: View, lessons: LessonSession) -> None:
        """Bring up to date what it has beside the stage; only what has changed is sent.

        Args:
            room: the class.
            state: of the class, for a teacher.
            mine: the student's own answer to the question on the stage.
            view, lessons: the stage's.
        """
        stand, poll = self.stand, state.poll
        if stand is not None and self.view is not stand.view:
            self.view, self.banner, self.shown = stand.view, Banner(self.client.gui), None
        line, place = self._line(room), self._place(view, lessons)
        shown = line, place, None if self.answers is None else (lessons.open, poll, mine, view.lesson_panel.tab)
        if self.panel is not None:
            with contextlib.suppress(Exception), self.client.atomic():
                self.panel.show(state, lessons)
        # Thirty pages that change once a minute must not cost thirty messages a frame.
        if self.banner is None or shown == self.shown:
            return
        self.shown = shown
        with contextlib.suppress(Exception), self.client.atomic():
            self.banner.show(*line, place)
            if self.answers is not None:
                self.answers.fold(lessons.open)
                self.answers.show(poll, mine)

    def _place(self, view: View, lessons: LessonSession) -> viser.GuiTabHandle | None:
        """Return where the banner's line stands if the controls are folded up."""
        if self.stand is not None:
            view, lessons = self.stand.view, self.stand.lessons
        return view.lesson_panel.tab if lessons.open and self.narrow else None

    def _line(self, room: Classroom) -> tuple[str, str]:
        """Return what stands at the top of a student's page."""
        if room.paused:
            return "halt", tr(HALTED)
        if self.stand is not None:
            return "own", tr(EXPLORING)
        if room.free:
            if not self.lasting:
                return "wait", tr(NAMELESS)
            return "wait", tr(WATCHING, most=room.places.most)
        return "follow", tr(FOLLOWING)
