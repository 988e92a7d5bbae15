"""A lecture: one stage that all see and the teacher leads, and sessions of their own for students who are set free to explore."""

import contextlib
import logging
from collections.abc import Mapping
from dataclasses import dataclass
from time import monotonic
from typing import Final

import viser

from app.apart import Apart
from app.background import Background
from app.classroom.address import Address, find_address
from app.classroom.classroom import Classroom, Poll
from app.classroom.key import WRONG_KEY, is_mistaken, is_teacher
from app.classroom.places import Kept
from app.languages.lesson_book import in_language
from app.languages.speaking import say, speak
from app.languages.visitor import browser_language, language_of
from app.lessons.lesson import LessonBook
from app.lessons.walkthrough import Walkthrough
from app.page.lesson_panel import ORDER
from app.page.lesson_resume import open_link, word_of
from app.page.lesson_run import LessonRun
from app.page.lesson_saved import Saved
from app.page.page import Operation, View
from app.page.teacher import Action, ClassState, TeacherPanel
from app.page.teacher_answers import Answers, Banner
from app.page.teacher_html import EXPLORING, FOLLOWING, HALTED, NAMELESS, WATCHING, overlay_html, poll_html
from app.people import NOBODY_ELSE, People
from app.server import DuetServer, request_query
from app.session import Session
from app.settings import Language, Settings
from app.stand import Stand, Visitors
from scenes.settings import values

log = logging.getLogger("duet.lecture")

NO_LESSONS: Final = LessonBook((), ())

SETTLE: Final = 0.25
"""Time between two looks at who gets a place of their own [s]."""


@dataclass
class _Seat:
    """One browser.

    Attributes:
        client, query: as it came.
        who: the word that its tab keeps, or one of ours if it keeps none.
        lasting: whether the word outlives a reload.
        screen: whether it only shows (a projector), and is no student's.
        teacher: whether it brought the key.
        banner, answers, panel: what it has beside the stage; None for what it has not.
        stand: its own session; None while it sees the stage.
        view: what the banner stands on; another one in another language.
        moved: whether it was asked to come again.
    """

    client: viser.ClientHandle
    query: dict[str, str]
    who: str
    lasting: bool
    screen: bool
    teacher: bool
    banner: Banner | None = None
    answers: Answers | None = None
    panel: TeacherPanel | None = None
    stand: Stand | None = None
    view: View | None = None
    moved: bool = False


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
        self._background, self._people = background, people
        self.room = Classroom(sessions)
        self._apart = Apart(server, self._belongs_apart)
        self.session = Session(start, lambda: self.wake(), background, people)
        # The stage has one language: the chosen one, or that of whoever has the controls.
        self._browser: Language = "en"
        self._language: Language = language_of(start, self._browser)
        self._seats: dict[int, _Seat] = {}
        self._operation: Operation | None = None
        self._operator: int | None = None
        self._next = 0.0
        self._waiting: tuple[str, ...] = ()
        self._ran = False
        speak(self._language)
        self.lessons = LessonRun(self.session, in_language(book, self._language))
        super().__init__(server)
        self._build()
        server.gate.may_share = lambda client_id: client_id == self._operator

    def _build(self) -> None:
        """Draw the stage, for everybody."""
        gui = self._server.gui
        self._view = View(self._server, self.session, self._watchers, self.lessons)
        self._overlay, self._poll = gui.add_html(""), None
        self._texts: dict[str, str] = {}

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
        for session in (self.session, *self.sessions.values()):
            session.close()
        self._apart.close()

    # ---- frame by frame ----------------------------------------------------------------------------------------------------

    def frame(self, now: float, elapsed: float) -> None:
        """Advance the stage and draw it for all; then those who explore, each for themselves."""
        speak(self._language)
        arrivals, departures = self.changes()
        for number in departures:
            self._leave(number)
        for client in arrivals:
            self._arrive(client)
        if self._operator is None:
            self._hand_over()
        moved = self.session.advance(elapsed) > 0
        if language_of(self.session.settings, self._browser) != self._language:
            self._translate()
        self.lessons.frame()
        if self.room.paused and not self.room.free and not self.session.paused:
            # On the stage the teacher's Run is everybody's.
            self.room.paused = False
        poll = self.room.poll(self._walk)
        with self._server.atomic():
            self._view.show(now, moved)
            self._show_to_all(poll)
        if self._operation is not None:
            self._operation.show()
        self._settle(now)
        self._show_to_each(poll)
        self._server.flush()
        for number, seat in list(self._seats.items()):
            if seat.stand is not None:
                self._frame_apart(number, seat.stand, now, elapsed)

    @property
    def _walk(self) -> Walkthrough | None:
        return self.lessons.walk if self.lessons.open else None

    def _frame_apart(self, number: int, stand: Stand, now: float, elapsed: float) -> None:
        try:
            stand.halt(self.room.paused)
            stand.frame(now, elapsed)
        except Exception:
            # One broken page must not stop the others; a tab that is just closing ends up here too.
            if number in self._server.get_clients():
                log.exception("a frame of a student's page failed")

    def _show_to_all(self, poll: Poll | None) -> None:
        tab = self._view.lesson_panel.tab
        if self._poll is None and tab is not None:
            with tab:
                self._poll = self._server.gui.add_html("", order=ORDER["verdict"] - 0.5)
        if self._poll is not None:
            self._write("poll", self._poll, poll_html(poll) if poll is not None and poll.revealed else "")
        inviting = self.room.inviting and self._address is not None
        self._write("overlay", self._overlay, overlay_html(self._address) if inviting and self._address is not None else "")

    def _write(self, name: str, handle: viser.GuiHtmlHandle, text: str) -> None:
        if self._texts.get(name, "") != text:
            self._texts[name] = handle.content = text

    def _show_to_each(self, poll: Poll | None) -> None:
        state = ClassState(self.room.heads, self.room.free, self.room.paused, self.room.inviting, len(self._waiting), poll)
        for seat in self._seats.values():
            if seat.panel is not None:
                with contextlib.suppress(Exception), seat.client.atomic():
                    seat.panel.show(state, self.lessons)
            if seat.stand is not None and seat.view is not seat.stand.view:
                seat.view, seat.banner = seat.stand.view, Banner(seat.client.gui)
            if seat.banner is not None:
                with contextlib.suppress(Exception), seat.client.atomic():
                    inside = seat.answers is not None and seat.answers.narrow and self.lessons.open
                    seat.banner.show(*self._line(seat), self._view.lesson_panel.tab if inside else None)
                    if seat.answers is not None:
                        seat.answers.fold(self.lessons.open)
                        seat.answers.show(poll, None if poll is None else self.room.ballots.answer_of(poll.place, seat.who))

    def _line(self, seat: _Seat) -> tuple[str, str]:
        """Return what stands at the top of a student's page."""
        if self.room.paused:
            return "halt", say(HALTED)
        if seat.stand is not None:
            return "own", say(EXPLORING)
        if self.room.free:
            if not seat.lasting:
                return "wait", say(NAMELESS)
            return "wait", say(WATCHING, most=self.room.places.most)
        return "follow", say(FOLLOWING)

    # ---- who comes and goes ------------------------------------------------------------------------------------------------

    def _belongs_apart(self, query: dict[str, str]) -> bool:
        """Return whether the browser that comes with a query is to have its own session; asked on the network's thread."""
        word = word_of(query)
        if word is None or is_teacher(self._key, query) or "screen" in query:
            return False
        return self.room.free and self.room.places.holds(word)

    def _arrive(self, client: viser.ClientHandle) -> None:
        number, query = client.client_id, request_query(client)
        word = word_of(query)
        seat = _Seat(client, query, word or f"tab {number}", word is not None, "screen" in query, is_teacher(self._key, query))
        self._seats[number] = seat
        try:
            if self._apart.holds(number):
                self._stand_up(seat)
                self.room.enter(number, seat.who)
                return
            self._view.welcome(client)
            if seat.teacher:
                self._give_panel(seat)
            elif not seat.screen and (self._key is not None or self._operator is not None):
                self._give_part(seat)
            if is_mistaken(self._key, query):
                client.add_notification(say("The key is another one"), say(WRONG_KEY), color="orange", auto_close_seconds=12.0)
        except Exception:
            # Whoever is gone again before being welcomed must not cost the others their frame.
            if number in self._server.get_clients():
                log.exception("a page could not be built")

    def _leave(self, number: int) -> None:
        seat = self._seats.pop(number, None)
        self.room.leave(number)
        if seat is not None and seat.stand is not None:
            self._keep(seat)
            seat.stand.operation.close()
            seat.stand.session.close()
        if number == self._operator:
            if self._operation is not None:
                self._operation.close()
            self._operator, self._operation = None, None
            self.session.hold(None)

    def _give_part(self, seat: _Seat) -> None:
        """Give a student what is theirs beside the stage."""
        number, client, who = seat.client.client_id, seat.client, seat.who
        self.room.enter(number, who)
        seat.banner = Banner(client.gui)
        seat.answers = Answers(client, self._view.lesson_panel, lambda choice: self._post_answer(who, choice))

    def _give_panel(self, seat: _Seat) -> TeacherPanel:
        notes = self._notes if seat.teacher else None
        seat.panel = TeacherPanel(seat.client, self._post, self._find_address(seat), notes)
        return seat.panel

    def _take_back(self, seat: _Seat) -> None:
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
            if number != self._operator and not (seat.teacher or seat.screen or seat.banner or seat.stand) and self._operator:
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

    # ---- the teacher decides -----------------------------------------------------------------------------------------------

    def _post(self, action: Action) -> None:
        self.session.post(lambda: self._act(action))

    def _act(self, action: Action) -> None:
        room = self.room
        match action:
            case "follow":
                room.follow()
            case "free":
                room.free = True
            case "pause":
                self._pause(not room.paused)
            case "reveal":
                self._reveal()
            case "again":
                self._ask_again()
            case "invite":
                room.inviting = not room.inviting
        self._next = 0.0

    def _pause(self, paused: bool) -> None:
        room, session = self.room, self.session
        if paused:
            self._ran = not session.paused
        room.paused = paused
        if paused or self._ran:
            session.paused = paused

    def _reveal(self) -> None:
        poll = self.room.poll(self._walk)
        if poll is None or poll.revealed or not poll.tally.answered:
            return
        self.room.ballots.reveal(poll.place)
        favourite = poll.tally.favourite
        if self.lessons.locked and favourite is not None:
            # The prediction that the run is compared with is the class's.
            self.lessons.act("choose", favourite)

    def _ask_again(self) -> None:
        poll = self.room.poll(self._walk)
        if poll is not None:
            self.room.ballots.ask_again(poll.place)
            self.lessons.act("reset")

    def _post_answer(self, who: str, choice: int) -> None:
        self.session.post(lambda: self._answer(who, choice))

    def _answer(self, who: str, choice: int) -> None:
        self.room.answer(self._walk, who, choice)

    @property
    def _address(self) -> Address | None:
        seat = next((seat for seat in self._seats.values() if seat.panel is not None), None)
        return None if seat is None else self._find_address(seat)

    def _find_address(self, seat: _Seat) -> Address:
        return find_address(origin_of(seat.client), self._listening, self._server.get_port())

    # ---- those who explore -------------------------------------------------------------------------------------------------

    def _settle(self, now: float) -> None:
        """Now and then: give places, and call those elsewhere who are not where they belong."""
        if now < self._next:
            return
        self._next = now + SETTLE
        room = self.room
        students = [seat for seat in self._seats.values() if seat.banner is not None or seat.stand is not None]
        room.settle(tuple(seat.who for seat in students if seat.lasting), monotonic())
        for seat in students:
            wanted = room.free and seat.lasting and room.places.holds(seat.who)
            if wanted != (seat.stand is not None) and not seat.moved:
                seat.moved = True
                self._apart.move(seat.client)
        self._waiting = tuple(who for who in room.here if room.free and not room.places.holds(who))

    def _stand_up(self, seat: _Seat) -> None:
        """Give a student a session: as they left theirs, or as the teacher's is."""
        for other in self._seats.values():
            if other is not seat and other.who == seat.who and other.stand is not None:
                # A connection that is gone may not have been noticed yet.
                self._keep(other)
        kept = self.room.places.kept(seat.who)
        settings = self.session.settings if kept is None else kept.settings
        saved = self._from_stage(seat.who) if kept is None else kept.saved
        found = None if saved is None else (saved, True)
        stand = Stand(seat.client, settings, (), lambda: self.wake(), self._background, self._people, self._book, found)
        if kept is not None and saved is not None and saved.open:
            stand.session.post(lambda: _restore(stand.session, kept.settings))
        seat.stand = stand

    def _from_stage(self, who: str) -> Saved | None:
        """Return the teacher's lesson and step as a place to begin at, with the student's own answers; None outside the lessons."""
        saved = self.lessons.saved()
        if saved is None or not saved.open:
            return None
        return Saved(self.room.progress_of(who, self.lessons.walk), saved.own, True)

    def _keep(self, seat: _Seat) -> None:
        assert seat.stand is not None
        self.room.places.keep(seat.who, Kept(seat.stand.session.settings, seat.stand.lessons.saved()))


def _restore(session: Session, settings: Settings) -> None:
    """Take on the settings that a student had changed within a step."""
    for key, value in values(settings).items():
        if values(session.settings)[key] != value:
            session.change(key, value)


def origin_of(client: viser.ClientHandle) -> str:
    """Return the page's own address as a visitor's browser reached it; "" if it did not say."""
    connection = client._viser_server._websock_server._live_connections.get(client.client_id)
    if connection is None or connection.request is None:
        return ""
    return str(connection.request.headers.get("Origin", ""))[:300]
