"""The host of a lecture."""

import logging
from collections.abc import Callable
from math import inf
from time import time

import viser

from app.features.classroom.class_record import NEW_CLASS, class_of, interrupted
from app.features.classroom.class_summary import ClassSummary
from app.features.classroom.classroom import Classroom
from app.features.lecture.audiences import SCREEN, SMALL, Audiences
from app.features.lecture.breakout_sessions import BreakoutSessions, BreakoutWorkers, run_of
from app.features.lecture.leader import Leader
from app.features.lecture.lecture_options import LectureOptions
from app.features.lecture.lecture_pages import SharedAudiences, SharedControls
from app.features.lecture.lecture_record import LectureRecorder
from app.features.lecture.participant import Participant
from app.features.lecture.presenter import INVITED, InvitedPages
from app.features.lecture.teacher_control import TeacherControl
from app.features.lessons.panel.lesson_visit import LessonServer
from app.features.lessons.progress import SavedLesson
from app.features.lessons.session.lesson_session import LessonSession
from app.features.store.session_store import store_of
from app.features.workers.worker_messages import WorkerLink
from app.hosting.admission import Admission, Pieces
from app.hosting.app_context import AppContext
from app.hosting.frame_loop import Attention
from app.hosting.teacher_key import is_teacher
from app.hosting.visitor_record import VisitorRecord, with_part
from app.i18n.reader_language import language_of, look_of, preferred
from app.i18n.speaking import set_language
from app.session.frame import Frame, make_frame
from app.session.session import Session
from app.settings import Look
from app.web.address import Address

log = logging.getLogger("duet.lecture")


class LectureHost:
    """Shows the shared session in all tabs, each in its language and look.

    `link`: to the processes of the breakout sessions; None for this one.
    """

    def __init__(self, context: AppContext, link: WorkerLink | None = None) -> None:
        self._context = context
        record = interrupted(store_of(context))
        room = (None if record is None else class_of(record)) or NEW_CLASS
        self.classroom = Classroom(context.workload.places, room)
        start = context.options.settings if record is None or record.state is None else record.settings
        self.session = Session(start, context.wake, context.jobs, context.law)
        self._book = context.part(LessonServer).book
        self.lessons = self.session.parts.of(LessonSession)
        self.lessons.begin_with(self._book, language_of(context.options.settings, "en"))
        self.control, workers = TeacherControl(self.classroom, self.session, self.lessons), None
        if link is not None:
            link.wake = context.wake
            workers = BreakoutWorkers(link, self.classroom, self.control.answers.put)
        self._breakouts = BreakoutSessions(context, self.classroom, workers)
        self.control.presenter.expected = context.options.of(LectureOptions).students
        self.leader = Leader(context.options.key, room)
        self._recorder = LectureRecorder(context, record, self.control, self.leader)
        self.controls = SharedControls(context, self.control, self.summaries)
        self.participants: dict[int, Participant] = {}
        self.shared = SharedAudiences(context, self.control, self.participants)
        self._attention, self._heard, self._told = Attention(), (0, 0), (None, None)
        self.audiences = Audiences(context.server, self._look, self.leader.gone)
        self.admission = Admission(context, self._admit, self._not_built)
        # Watchers operate nothing in the shared session.
        context.server.gate.may_share = lambda client_id: False
        # A teacher must be able to reconnect.
        context.server.always_admits = lambda query: is_teacher(context.options.key, query)
        # A student counts once, however many tabs are open; a teacher may have several.
        context.server.takes_over = lambda query: (
            SCREEN not in query and not is_teacher(context.options.key, query)
        )

    def _look(self, client_id: int, query: dict[str, str], accept: str) -> Look | None:
        if self.leader.admits(client_id, query) or self._breakouts.expects(query):
            return None
        return look_of(query, preferred(accept), self._context.options.settings)

    def close(self, goes_on: bool = False) -> None:
        """Save and close every session. `goes_on`: the next server resumes the lecture."""
        self.admission.close()
        if goes_on:
            self._recorder.save(inf)
        else:
            self._recorder.close()
        self._breakouts.close(self.participants.values())
        self.session.close()
        self._context.store.close()

    # ---- frame by frame ----------------------------------------------------------------------------------------------------

    def frame(self, now: float, elapsed: float) -> None:
        """Advance and draw the shared session, then every breakout session."""
        set_language(self.controls.language)
        self._connect()
        set_language(self.controls.language)
        teachers = [one for one in self.participants.values() if one.teacher]
        if self.controls.operator is None and teachers:
            self._build(teachers[0], self.controls.hand_over)
        for one in teachers:
            if one.takes_over:
                one.takes_over = False
                self._build(one, self.controls.take_over)
        self.control.answers.do()
        if self.controls.operator is not None and self.controls.language_changed:
            self._build(self.controls.operator, self.controls.build_operator_page)
        set_language(self.controls.language)
        due = self._attention.due(now, False, self.session.paused, self._is_dirty())
        workload = self._context.workload
        self.classroom.places.most = workload.places
        # The shared session runs beside those of the students.
        self.classroom.load = self._breakouts.load(workload.report)._replace(places=workload.places + 1)
        frame = make_frame(self.session, now, elapsed, workload.budget)
        workload.drew(self.session.control.stepping)
        if self.classroom.paused and not self.classroom.free and not self.session.paused:
            # The teacher has pressed Run in the shared session.
            self.classroom.paused = False
        self._breakouts.settle(self.participants.values(), self._begin)
        self.control.presenter.screens = sum(
            one.screen and one.query[SCREEN] != SMALL for one in self.participants.values()
        )
        self.control.present()
        if due:
            self._show_shared(frame)
            self._attention.note(now, frame.state)
        self._recorder.save(now)
        self._tell_trouble()
        if (run := run_of(self.participants.values(), self.classroom.wanted)) is not None:
            self.control.answers.put(run)
        self._breakouts.frames(list(self.participants.values()), now, elapsed)

    def _tell_trouble(self) -> None:
        operation, trouble = self.controls.operation, self._context.store.trouble
        if operation is not None and trouble is not None and (operation, trouble) != self._told:
            set_language(self.controls.language)
            self.session.notify(*trouble)
        self._told = operation, trouble

    def _is_dirty(self) -> bool:
        pages = [self._context.server.page_of(client_id) for client_id in self.participants]
        heard, self._heard = self._heard, (len(pages), sum(page.heard for page in pages if page is not None))
        return self.session.dirty or heard != self._heard

    def _show_shared(self, frame: Frame) -> None:
        operator = self.controls.operator
        teachers = [one for one in self.participants.values() if one.page is not None]
        for teacher in sorted(teachers, key=lambda one: one is not operator):
            with self._context.guarded("a frame of a teacher's page failed", teacher.client.client_id):
                self._show_teacher(teacher, frame)
        for audience, page in self.shared.pages.items():
            poll = page.show(frame, self._address("screens"))
            for one in self.shared.watchers(audience):
                with self._context.guarded("a frame of a student's page failed", one.client.client_id):
                    one.show(self.classroom, poll, page.view)
                    one.invite(self._address("all"))
            page.flush()

    def _show_teacher(self, teacher: Participant, frame: Frame) -> None:
        page, operation = teacher.page, self.controls.operation
        assert page is not None
        poll = page.show(frame)
        teacher.invite(self._address("teachers"))
        if teacher is self.controls.operator and operation is not None:
            with teacher.client.atomic():
                operation.show(frame)
        teacher.show_panel(poll)
        page.flush()

    def summaries(self) -> tuple[ClassSummary, ClassSummary | None]:
        """Reports of this class and, with a key, of the last one."""
        last = None if self._context.options.key is None else self._recorder.last_class
        return self.classroom.summary(self._book, time()), last

    def _address(self, pages: InvitedPages) -> Address | None:
        shown = INVITED.index(self.control.presenter.inviting) >= INVITED.index(pages)
        return self.controls.address if shown else None

    # ---- connections -------------------------------------------------------------------------------------------------------

    def _connect(self) -> None:
        arrivals, departures = self.admission.changes()
        for client_id in departures:
            participant = self.participants.pop(client_id, None)
            self.classroom.leave(client_id)
            if participant is not None:
                self._breakouts.leave(participant)
                if participant is self.controls.operator:
                    self.controls.release()
        self.shared.update(self.audiences)
        for client in arrivals:
            self.admission.come(client)
        self.admission.advance()

    def _admit(self, client: viser.ClientHandle) -> Pieces:
        """A breakout session takes part once its page is complete."""
        client_id = client.client_id
        audience = self.audiences.audience_of(client_id)
        participant = Participant(client, self.leader.holds(client_id), audience, self.control.answers.put)
        if (
            not participant.teacher
            and participant.audience is None
            and self._breakouts.expects(participant.query)
        ):
            begin = self._begin(participant.id)
            participant.group = self.classroom.places.groups[participant.id]
            yield from self._breakouts.admit(participant, self.participants.values(), begin)
            self.participants[client_id] = participant
            self.classroom.enter(client_id, participant.id)
            return
        self.participants[client_id] = participant
        if participant.teacher:
            self._build(participant, self.controls.admit)
        elif participant.audience is not None:
            self._build(participant, self.shared.admit)
        else:
            # Its place was taken since it connected.
            self._context.server.send_elsewhere(client)

    def _begin(self, student: str) -> VisitorRecord:
        record, saved = VisitorRecord({}, self.session.settings), self.lessons.saved_lesson()
        if saved is None or not saved.open:
            return record
        own = SavedLesson(self.classroom.progress_of(student, self.lessons.walk), saved.own, True)
        return with_part(record, LessonSession.name, own)

    def _build(self, participant: Participant, build: Callable[[Participant], None]) -> None:
        try:
            build(participant)
        except Exception:
            self._not_built(participant.client)

    def _not_built(self, client: viser.ClientHandle) -> None:
        # A browser that disconnects before its page is complete is not an error.
        if client.client_id in self._context.server.get_clients():
            log.exception("a page could not be built")
