"""A lecture: one stage that all see and the teacher leads, and sessions of their own for students who are set free to explore."""

import contextlib
import logging
from collections.abc import Mapping

import viser

from app.background import Background
from app.classroom.address import Address, find_address
from app.classroom.classroom import Classroom, Poll
from app.classroom.key import WRONG_KEY, is_mistaken, is_teacher
from app.entrance import Entrance, Pieces
from app.explorers import Explorers
from app.languages.lesson_book import in_language
from app.languages.speaking import say, speak
from app.languages.visitor import browser_language, language_of
from app.lessons.lesson import NO_LESSONS, LessonBook
from app.mishaps import Mishaps
from app.page.lesson_resume import open_link, word_of
from app.page.lesson_run import LessonRun
from app.page.operation import Operation
from app.page.teacher import ClassState, TeacherPanel
from app.page.teacher_answers import Answers, Banner, is_narrow
from app.page.view import View
from app.people import NOBODY_ELSE, People
from app.seat import Seat
from app.server.request import request_address, request_query
from app.server.server import DuetServer
from app.session import Session
from app.settings import Language, Settings
from app.stage_overlays import Overlays
from app.stand import Visitors
from app.teacher_decisions import Decisions

log = logging.getLogger("duet.lecture")


class LectureHost(Visitors):
    """All tabs see one stage; one of them has the controls: the first, or the one that came with the key.

    Args:
        server: viser's.
        start: what the stage shows at first.
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
        background: Background,
        people: People = NOBODY_ELSE,
        book: LessonBook = NO_LESSONS,
        notes: Mapping[str, str] | None = None,
        sessions: int = 8,
        listening: str = "127.0.0.1",
    ) -> None:
        self._key, self._book, self._notes, self._listening = key, book, notes or {}, listening
        self.room = Classroom(sessions)
        self._explorers = Explorers(server, self.room, key, background, people, book, lambda: self.wake())
        self.session = Session(start, lambda: self.wake(), background, people)
        # The stage has one language: the chosen one, or that of whoever has the controls.
        self._browser: Language = "en"
        self._language: Language = language_of(start, self._browser)
        self._seats: dict[int, Seat] = {}
        self._operation: Operation | None = None
        self._operator: int | None = None
        self._address: Address | None = None
        self._mishaps = Mishaps(log)
        speak(self._language)
        self.lessons = LessonRun(self.session, in_language(book, self._language))
        self._decisions = Decisions(self.room, self.session, lambda: self.lessons, self._explorers.hurry)
        self._entrance = Entrance(self._arrive, self._not_built)
        super().__init__(server)
        self._build()
        server.gate.may_share = lambda client_id: client_id == self._operator
        # Who leads the class must be able to come back after a lost connection.
        server.always_admits = lambda query: is_teacher(key, query)

    def _build(self) -> None:
        """Draw the stage, for everybody."""
        self._view = View(self._server, self.session, self._watchers, self.lessons)
        self._overlays = Overlays(self._server.gui, self._view)

    def _watchers(self) -> list[viser.ClientHandle]:
        return [seat.client for seat in list(self._seats.values()) if seat.stand is None]

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
        speak(self._language)
        arrivals, departures = self.changes()
        for number in departures:
            self._entrance.leave(number)
            self._leave(number)
        for client in arrivals:
            self._entrance.come(client)
        self._entrance.advance()
        speak(self._language)
        if self._entrance.busy:
            self.wake()
        if self._operator is None:
            self._hand_over()
        self._decisions.answers.do()
        moved = self.session.advance(elapsed) > 0
        if language_of(self.session.settings, self._browser) != self._language:
            self._translate()
        self.lessons.frame()
        if self.room.paused and not self.room.free and not self.session.paused:
            # On the stage the teacher's Run is everybody's.
            self.room.paused = False
        poll = self._decisions.poll
        with self._server.atomic():
            self._view.show(now, moved)
            self._overlays.show(poll, self._address if self.room.inviting else None)
        self._show_operation()
        self._explorers.settle(self._seats.values(), now)
        self._show_to_each(poll)
        self._server.flush()
        for number, seat in list(self._seats.items()):
            if seat.stand is not None:
                self._explorers.frame(number, seat.stand, now, elapsed)

    def _show_operation(self) -> None:
        if self._operation is None:
            return
        try:
            self._operation.show()
        except Exception as error:
            # Where the lecturer's tab is just closing, its controls have gone before we are told; nobody else may lose a frame.
            if self._operator in self._server.get_clients():
                self._mishaps.tell("a frame of the lecturer's controls failed", error, self._operator)

    def _show_to_each(self, poll: Poll | None) -> None:
        state = ClassState(
            self.room.heads, self.room.free, self.room.paused, self.room.inviting, len(self._explorers.waiting), poll
        )
        for seat in self._seats.values():
            mine = None if poll is None or seat.answers is None else self.room.ballots.answer_of(poll.place, seat.who)
            seat.show(self.room, state, mine, self._view, self.lessons)

    # ---- who comes and goes ------------------------------------------------------------------------------------------------

    def _arrive(self, client: viser.ClientHandle) -> Pieces:
        """Give a newcomer what is theirs; one with a session gets a seat once the page is whole."""
        number, query = client.client_id, request_query(client)
        word = word_of(query)
        who, screen, teacher = word or f"tab {number}", "screen" in query, is_teacher(self._key, query)
        seat = Seat(client, query, who, word is not None, screen, teacher, is_narrow(client))
        if self._explorers.holds(number):
            yield from self._explorers.let_in(seat, self._seats.values(), self.session.settings, self.lessons)
            self._seats[number] = seat
            self.room.enter(number, seat.who)
            return
        self._seats[number] = seat
        speak(self._language)
        self._view.welcome(client)
        if seat.teacher:
            self._give_panel(seat)
        elif not seat.screen and (self._key is not None or self._operator is not None):
            self._give_part(seat)
        if is_mistaken(self._key, query):
            client.add_notification(say("The key is another one"), say(WRONG_KEY), color="orange", auto_close_seconds=12.0)

    def _not_built(self, client: viser.ClientHandle) -> None:
        # Whoever is gone again before being welcomed must not cost the others their frame.
        if client.client_id in self._server.get_clients():
            log.exception("a page could not be built")

    def _leave(self, number: int) -> None:
        seat = self._seats.pop(number, None)
        self.room.leave(number)
        if seat is not None:
            self._explorers.leave(seat)
        if number == self._operator:
            if self._operation is not None:
                self._operation.close()
            self._operator, self._operation = None, None
            self.session.posts.drop()
            self.session.hold(None)

    def _give_part(self, seat: Seat) -> None:
        """Give a student what is theirs beside the stage."""
        number, client, who = seat.client.client_id, seat.client, seat.who
        self.room.enter(number, who)
        seat.banner, seat.shown = Banner(client.gui), None
        seat.answers = Answers(client, self._view.lesson_panel, lambda choice: self._decisions.post_answer(who, choice))

    def _give_panel(self, seat: Seat) -> TeacherPanel:
        notes = self._notes if seat.teacher else None
        self._address = find_address(request_address(seat.client), self._listening, self._server.get_port())
        seat.panel = TeacherPanel(seat.client, self._decisions.post, self._address, notes)
        return seat.panel

    def _take_back(self, seat: Seat) -> None:
        self.room.leave(seat.client.client_id)
        for part in (seat.banner, seat.answers):
            if part is not None:
                part.close()
        seat.banner = seat.answers = None

    def _hand_over(self) -> None:
        for number, seat in self._seats.items():
            if not (seat.teacher if self._key is not None else seat.stand is None and not seat.screen):
                continue
            client = seat.client
            self._operator = number
            self._browser = browser_language(client)
            self._operation = Operation(client, self.session, self._view)
            if not self.lessons.open:
                self._operation.notify_problems(open_link(self.lessons, seat.query, None))
            self._operation.notify_lessons(self._book)
            self._take_back(seat)
            panel = seat.panel or self._give_panel(seat)
            panel.lead()
            break
        for number, seat in self._seats.items():
            # Without a key nobody is a student before somebody leads.
            led = self._operator is not None and number != self._operator
            if led and not (seat.teacher or seat.screen or seat.banner or seat.stand):
                self._give_part(seat)

    def _translate(self) -> None:
        """Make everybody's page anew in another language; the session and the lessons go on where they are."""
        saved = self.lessons.saved()
        self._language = language_of(self.session.settings, self._browser)
        speak(self._language)
        self.lessons = LessonRun(self.session, in_language(self._book, self._language))
        if saved is not None:
            self.lessons.resume(saved, reopen=True)
        if self._operation is not None:
            self._operation.close()
        watching = [seat for seat in self._seats.values() if seat.stand is None]
        with self._server.atomic():
            for seat in watching:
                with contextlib.suppress(Exception):
                    seat.client.gui.reset()
            self._server.gui.reset()
            self._build()
        for number, seat in self._seats.items():
            if seat not in watching:
                continue
            with contextlib.suppress(Exception):
                if number == self._operator:
                    self._operation = Operation(seat.client, self.session, self._view)
                if seat.panel is not None:
                    panel = self._give_panel(seat)
                    if number == self._operator:
                        panel.lead()
                elif seat.banner is not None:
                    self._give_part(seat)
                self._view.welcome(seat.client)
