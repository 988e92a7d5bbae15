"""A lecture: one stage that all see and the teacher leads, and sessions of their own for students who are set free to explore."""

import logging
from collections.abc import Callable, Mapping

import viser

from app.classroom.address import Address, find_address
from app.classroom.breakout_sessions import BreakoutSessions
from app.classroom.classroom import Classroom, Poll
from app.classroom.leader import Leader
from app.classroom.participant import Participant
from app.classroom.stage_page import StagePage
from app.classroom.student_answers import Answers, Banner, is_narrow
from app.classroom.teacher_control import TeacherControl
from app.classroom.teacher_panel import ClassState, TeacherPanel
from app.hosting.admission import Admission, Pieces
from app.hosting.resume import open_link, word_of
from app.hosting.teacher_key import is_mistaken, is_teacher
from app.hosting.visitor import Connections
from app.i18n.reader_language import language_of, look_of, preferred
from app.i18n.speaking import set_language
from app.lessons.lesson import NO_LESSONS, LessonBook
from app.lessons.session.lesson_session import LessonSession
from app.lessons.translated_book import in_language
from app.page.operation import Operation
from app.page.panels.key_notice import name_mistake
from app.runtime.job_pool import JobPool
from app.runtime.throttled_log import ThrottledLog
from app.session.frame import Frame, make_frame
from app.session.input_sources import NO_SOURCES, InputSources
from app.session.session import Session
from app.settings import LOOKS, Language, Look, Settings, from_query
from app.web.audience import Audience
from app.web.audiences import Audiences
from app.web.request import browser_language, request_address, request_query
from app.web.server import DuetServer
from scenes.settings import values

log = logging.getLogger("duet.lecture")


class LectureHost(Connections):
    """All tabs see one stage, each in its own language and look; one of them has the controls: the first, or one with the key.

    Args:
        server: viser's.
        start: what the stage shows at first, and how tabs look whose link does not say it.
        key: a word that the teacher's link carries (`?key=…`); None gives the controls to the first tab.
        background: computes for all sessions.
        people: who can be imitated beside the built-in person.
        book: the lessons.
        notes: the teacher's, by the id of their lesson.
        sessions: how many students may explore at once.
        listening: the address that the server is bound to.

    Attributes:
        session, lessons: the stage's.
        room: the class.
    """

    def __init__(
        self,
        server: DuetServer,
        start: Settings,
        key: str | None,
        background: JobPool,
        people: InputSources = NO_SOURCES,
        book: LessonBook = NO_LESSONS,
        notes: Mapping[str, str] | None = None,
        sessions: int = 8,
        listening: str = "127.0.0.1",
    ) -> None:
        self._start, self._key, self._book, self._notes, self._listening = start, key, book, notes or {}, listening
        self.room = Classroom(sessions)
        self._explorers = BreakoutSessions(server, self.room, background, people, book, lambda: self.wake())
        self.session = Session(start, lambda: self.wake(), background, people)
        # The stage's own language is that of the one who has the controls.
        self._browser: Language = "en"
        self._language: Language = language_of(start, self._browser)
        self._seats: dict[int, Participant] = {}
        self._operation: Operation | None = None
        self._operator: int | None = None
        self._leader = ""
        self._address: Address | None = None
        self._mishaps = ThrottledLog(log)
        self.lessons = LessonSession(self.session, in_language(book, self._language))
        self._decisions = TeacherControl(self.room, self.session, self.lessons, self._explorers.hurry)
        self._showings: dict[Audience, StagePage] = {}
        self._lead = Leader(key)
        self._apart = Audiences(server, self._look, self._lead.gone)
        self._entrance = Admission(self._arrive, self._not_built)
        super().__init__(server)
        # Nothing that everybody shares can be operated.
        server.gate.may_share = lambda client_id: False
        # Who leads the class must be able to come back after a lost connection.
        server.always_admits = lambda query: is_teacher(key, query)

    def _look(self, number: int, query: dict[str, str], accept: str) -> Look | None:
        """Return with which look a browser watches; None if it gets a page of its own: to lead, or to explore."""
        if self._lead.admits(number, query) or self._explorers.expects(query):
            return None
        return look_of(query, preferred(accept), self._start)

    @property
    def operator(self) -> int | None:
        """Id of the client that has the controls, None if nobody has."""
        return self._operator

    @property
    def sessions(self) -> dict[int, Session]:
        """The sessions of those who explore, by client id."""
        return {number: seat.stand.session for number, seat in list(self._seats.items()) if seat.stand is not None}

    def close(self) -> None:
        """Close every session."""
        self._entrance.close()
        for session in (self.session, *self.sessions.values()):
            session.close()
        self._explorers.close()

    # ---- frame by frame ----------------------------------------------------------------------------------------------------

    def frame(self, now: float, elapsed: float) -> None:
        """Advance the stage and draw it for all; then those who explore, each for themselves."""
        set_language(self._language)
        arrivals, departures = self.changes()
        for number in departures:
            self._entrance.leave(number)
            self._leave(number)
        self._find_audiences()
        for client in arrivals:
            self._entrance.come(client)
        self._entrance.advance()
        set_language(self._language)
        if self._entrance.busy:
            self.wake()
        heir = next((seat for seat in self._seats.values() if seat.teacher), None)
        if self._operator is None and heir is not None:
            self._build(heir, self._hand_over)
        self._decisions.answers.do()
        if self._operator is not None and language_of(self.session.settings, self._browser) != self._language:
            self._build(self._seats[self._operator], self._seat_leader)
        set_language(self._language)
        frame = make_frame(self.session, self.lessons, now, elapsed)
        if self.room.paused and not self.room.free and not self.session.paused:
            # On the stage the teacher's Run is everybody's.
            self.room.paused = False
        self._explorers.settle(self._seats.values(), self._apart, now)
        self._show_stage(frame)
        for number, seat in list(self._seats.items()):
            if seat.stand is not None:
                set_language(seat.stand.language)
                seat.show(self.room, self._state(None), None, seat.stand.view, seat.stand.lessons)
                self._explorers.frame(number, seat.stand, now, elapsed)

    def _find_audiences(self) -> None:
        """Make the stage for those who watch with a look that was not there before, and forget what has no watcher left."""
        before = self._showings
        self._showings = {one: before[one] if one in before else self._show_to(one) for one in self._apart.audiences}

    def _show_to(self, audience: Audience) -> StagePage:
        def watchers() -> list[viser.ClientHandle]:
            return [seat.client for seat in list(self._seats.values()) if seat.audience is audience]

        look = audience.look
        return StagePage(audience, self.session, self.lessons, self._book, look.language, look, watchers)

    def _show_stage(self, frame: Frame) -> None:
        """Draw the stage, first for the one who leads."""
        seats, inviting = list(self._seats.items()), self._address if self.room.inviting else None
        own = [(number, seat, seat.showing) for number, seat in seats if seat.showing is not None]
        for number, seat, showing in sorted(own, key=lambda one: one[0] != self._operator):
            try:
                set_language(showing.language)
                poll = self._decisions.poll(showing.book)
                showing.show(frame, poll, inviting)
                if number == self._operator and self._operation is not None:
                    with seat.client.atomic():
                        self._operation.show(frame)
                seat.show(self.room, self._state(poll), None, showing.view, self.lessons)
                showing.flush()
            except Exception as error:
                # Where a teacher's tab is just closing, its page has gone before we know of it; the others must not lose a frame.
                if number in self._server.get_clients():
                    self._mishaps.exception("a frame of a teacher's page failed", error, number)
        for audience, showing in self._showings.items():
            set_language(showing.language)
            poll = self._decisions.poll(showing.book)
            showing.show(frame, poll, inviting)
            state = self._state(poll)
            for _, seat in seats:
                if seat.audience is audience:
                    mine = None if poll is None or seat.answers is None else self.room.ballots.answer_of(poll.place, seat.who)
                    seat.show(self.room, state, mine, showing.view, self.lessons)
            showing.flush()

    def _state(self, poll: Poll | None) -> ClassState:
        room = self.room
        return ClassState(room.heads, room.free, room.paused, room.inviting, len(self._explorers.waiting), poll)

    # ---- who comes and goes ------------------------------------------------------------------------------------------------

    def _arrive(self, client: viser.ClientHandle) -> Pieces:
        """Give a newcomer what is theirs; one with a session gets a seat once the page is whole."""
        number, query = client.client_id, request_query(client)
        word = word_of(query)
        who, screen, teacher = word or f"tab {number}", "screen" in query, self._lead.holds(number)
        seat = Participant(
            client, query, who, word is not None, screen, teacher, is_narrow(client), self._apart.audience_of(number)
        )
        if teacher and self._operator is not None and who == self._leader:
            # The connection before is lost, and that may take a while to be noticed.
            self._let_go()
        if not teacher and seat.audience is None and self._explorers.expects(query):
            yield from self._explorers.let_in(seat, self._seats.values(), self.session.settings, self.lessons)
            self._seats[number] = seat
            self.room.enter(number, seat.who)
            return
        self._seats[number] = seat
        if teacher:
            self._build(seat, self._hand_over if self._operator is None else self._seat_teacher)
        elif seat.audience is not None:
            self._build(seat, self._seat_watcher)
        else:
            # What was decided about it when it came no longer holds.
            self._apart.move(client)

    def _build(self, seat: Participant, page: Callable[[Participant], None]) -> None:
        try:
            page(seat)
        except Exception:
            self._not_built(seat.client)

    def _not_built(self, client: viser.ClientHandle) -> None:
        # Who is gone again before the page is there must not cost the others their frame.
        if client.client_id in self._server.get_clients():
            log.exception("a page could not be built")

    def _leave(self, number: int) -> None:
        seat = self._seats.pop(number, None)
        self.room.leave(number)
        if seat is not None:
            self._explorers.leave(seat)
        if number == self._operator:
            self._let_go()

    def _let_go(self) -> None:
        """Take the controls from whoever has them."""
        if self._operation is not None:
            self._operation.close()
        self._operator, self._operation = None, None
        self.session.posts.drop()
        self.session.hold(None)

    def _seat_watcher(self, seat: Participant) -> None:
        """Welcome a student or a screen, and give a student what is theirs beside the stage."""
        number, client, who, audience = seat.client.client_id, seat.client, seat.who, seat.audience
        assert audience is not None
        showing = self._showings[audience]
        set_language(showing.language)
        audience.contain_elements_of(client)
        showing.view.welcome(client)
        if not seat.screen:
            self.room.enter(number, who)
            seat.banner = Banner(client.gui)
            seat.answers = Answers(client, showing.view.lesson_panel, lambda choice: self._decisions.post_answer(who, choice))
        if is_mistaken(self._key, seat.query):
            name_mistake(client)

    def _seat_teacher(self, seat: Participant) -> None:
        """Make a teacher's page, or make it again to lead, or in another language."""
        client, leads = seat.client, seat.client.client_id == self._operator
        look = None if leads else look_of(seat.query, browser_language(client), self._start)
        language = self._language if look is None else look.language
        self._address = find_address(request_address(client), self._listening, self._server.get_port())
        with client.atomic():
            if seat.showing is not None:
                client.gui.reset()
            seat.showing = StagePage(client, self.session, self.lessons, self._book, language, look, lambda: [client])
            if leads:
                self._operation = Operation(client, self.session, seat.showing.view)
            notes = self._notes if self._key is not None else None
            seat.panel = TeacherPanel(client, self._decisions.post, self._address, notes)
            seat.showing.view.welcome(client)

    def _hand_over(self, seat: Participant) -> None:
        """Give a teacher the controls."""
        self._operator, self._browser = seat.client.client_id, browser_language(seat.client)
        back, self._leader = seat.who == self._leader, seat.who
        if not back:
            for key, value in values(from_query(seat.query, self._start)[0]).items():
                if key in LOOKS:
                    self.session.change(key, value)
        self._seat_leader(seat)
        assert self._operation is not None
        if not (back or self.lessons.open):
            self._operation.notify_problems(open_link(self.lessons, seat.query, None))
        self._operation.notify_lessons(self._book)

    def _seat_leader(self, seat: Participant) -> None:
        """Make the page of the one who leads, and have the stage speak its language; everything goes on where it is."""
        self._language = language_of(self.session.settings, self._browser)
        set_language(self._language)
        self.lessons.translate(in_language(self._book, self._language))
        if self._operation is not None:
            self._operation.close()
        self._seat_teacher(seat)
