"""One browser in a lecture."""

import viser

from app.features.classroom.classroom import Classroom, Poll
from app.features.lecture.audiences import SCREEN, Audience
from app.features.lecture.class_messages import PostWork, Progressed
from app.features.lecture.overlays import Invitation
from app.features.lecture.page_lines import WATCHING
from app.features.lecture.shared_page import GroupMember, SharedPage
from app.features.lecture.student_page import Answers, Banner, HandInBox
from app.features.lecture.teacher_panel import AssistantPanel, TeacherPanel
from app.features.lessons.panel.lesson_view import LessonView
from app.features.lessons.session.lesson_session import LessonSession
from app.features.lessons.tally import Ballot
from app.hosting.visitor import Visitor
from app.hosting.visitor_record import tab_id
from app.i18n.speaking import tr
from app.page.picture_size import canvas_size
from app.page.view import View
from app.session.session import Session
from app.settings import LOOKS, Settings, from_query
from app.theme import NARROW
from app.web.address import Address
from app.web.request import request_query
from app.web.viser_internals import expand_for
from scenes.settings import values


class Participant:
    """One browser.

    Attributes:
        id: of the tab; of the connection if the tab has none.
        lasting: the id outlives a reload.
        narrow: lesson, 3-D view and controls do not fit side by side.
        group: owner of the breakout session; "" in the shared session.
        mates: present students of the group, with this one.
        visitor: the breakout session; None if this student does not operate one.
        member: page of a watching member, or None.
    """

    def __init__(
        self, client: viser.ClientHandle, teacher: bool, audience: Audience | None, post_work: PostWork
    ) -> None:
        self.client, self.teacher, self.audience, self._post_work = client, teacher, audience, post_work
        self.query = request_query(client)
        tab = tab_id(self.query)
        self.id, self.lasting = tab or f"tab {client.client_id}", tab is not None
        self.screen, self.narrow, self.moved = SCREEN in self.query, canvas_size(client)[0] < NARROW, False
        self.page: SharedPage | None = None
        self.banner: Banner | None = None
        self.answers: Answers | None = None
        self.hand_in: HandInBox | None = None
        self.panel: TeacherPanel | AssistantPanel | None = None
        self.invitation: Invitation | None = None
        self.group, self.mates, self.takes_over = "", 1, False
        self.visitor: Visitor | None = None
        self.member: GroupMember | None = None
        # A change of language makes a new view, without a banner.
        self._view: View | None = None
        self._shown: object = None
        self.worked = False

    def add_banner(self) -> None:
        self.banner = Banner(self.client.gui, self.ask_to_operate)
        self.hand_in = HandInBox(self.client.gui, self._post_work, self.id, self.group)

    def ask_to_operate(self) -> None:
        """Thread-safe."""
        self.takes_over = True

    def dress(self, session: Session, start: Settings) -> None:
        """Give a session the look of this browser's link. `start`: settings that the link omits."""
        for key, value in values(from_query(self.query, start)[0]).items():
            if key in LOOKS:
                session.change(key, value)

    def leave(self) -> None:
        """Post a student's progress, and close a teacher's panel."""
        if self.visitor is not None and not self.visitor.superseded:
            lessons = self.visitor.session.parts.of(LessonSession)
            if lessons.begun:
                self._post_work(Progressed(self.group, lessons.walk.to_json()))
        if isinstance(self.panel, TeacherPanel):
            self.panel.close()

    def invite(self, address: Address | None) -> None:
        if self.invitation is not None:
            with self.client.atomic():
                self.invitation.show(address)

    def show_panel(self, poll: Poll | None) -> None:
        if self.panel is not None:
            with self.client.atomic():
                self.panel.show(poll)

    def show(self, classroom: Classroom, poll: Poll | None, view: View) -> None:
        """Update the student's parts of the page. `poll`: None in a breakout session."""
        seen = view.part(LessonView)
        lessons, panel = seen.lessons, seen.panel
        if self.group and self._view is not view:
            self._view, self._shown = view, None
            self.add_banner()
        if self.banner is None or self.hand_in is None:
            return
        self.hand_in.post(lessons if self.group else None, self.member is None)
        report = classroom.work.hand_ins.get(self.id)
        self.worked = (
            self.worked or report is not None or classroom.has_work(self.id) or classroom.has_work(self.group)
        )
        line, tab = self._line(classroom), panel.tab if lessons.open and self.narrow else None
        mine = Ballot() if poll is None else classroom.ballots.ballot_of(poll.question, self.id)
        answered = None if self.answers is None else (lessons.open, poll, mine, panel.tab)
        offers = self.member is not None
        shown = line, tab, answered, self.worked, report
        # A batch for each of thirty pages in every frame would cost a message each.
        if shown == self._shown:
            return
        self._shown = shown
        with self.client.atomic():
            self.banner.show(*line, tab, offers)
            if offers and tab is not None and panel.panel is not None:
                # The banner is in the panel, which a phone folds.
                self.client.gui.main_panel.minimize()
                expand_for(self.client, panel.panel)
            self.hand_in.show(self.worked, report, tab)
            if self.answers is not None:
                if self.narrow:
                    self.answers.fold(lessons.open)
                first = (
                    Ballot() if poll is None else classroom.ballots.first_ballot_of(poll.question, self.id)
                )
                self.answers.show(poll, mine, first)

    def _line(self, classroom: Classroom) -> tuple[str, str]:
        own = "own" if self.member is None else "own watches"
        if classroom.paused:
            return f"{own} halt" if self.group else "halt", tr("The teacher has paused everybody.")
        if self.group:
            name = classroom.board.name_of(self.group)
            pace = () if classroom.pace is None else (tr(classroom.pace.words),)
            if self.mates == 1:
                begin = (
                    tr(
                        "Explore freely: this is your own session, and its settings are kept for the next time."
                    ),
                )
            else:
                who = tr("You operate it.") if self.member is None else tr(WATCHING)
                begin = (tr("You are {count} at this robot, and answer together.", count=self.mates), who)
            return own, " ".join((*begin, *pace, tr("For the teacher you are {name}.", name=name)))
        if classroom.free and not self.lasting:
            return "wait", tr("Your browser blocks storage for this page, so you can only watch.")
        return "follow", tr("You follow the teacher: everybody sees this shared session.")
