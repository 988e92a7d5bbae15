"""Breakout sessions of students or groups."""

from collections.abc import Callable, Collection, Iterable
from dataclasses import replace
from math import inf
from time import monotonic
from typing import Final

from app.features.classroom.classroom import Classroom
from app.features.lecture.audiences import SCREEN
from app.features.lecture.class_messages import (
    ClassState,
    Exploring,
    PostWork,
    Present,
    Progressed,
    Ran,
    Reported,
)
from app.features.lecture.participant import Participant
from app.features.lecture.shared_page import GroupMember
from app.features.lessons.progress import SavedLesson
from app.features.lessons.session.lesson_session import LessonSession
from app.features.workers.shared_load import combined
from app.features.workers.worker_messages import ForgetTabs, Replaced, WorkerLink
from app.hosting.admission import Pieces
from app.hosting.app_context import AppContext
from app.hosting.visitor import Visitor
from app.hosting.visitor_record import VisitorRecord, part_of, tab_id
from app.i18n.speaking import set_language
from app.page.panels.server_load import ServerLoad
from app.session.actions import RestoreSettings
from app.settings import LOOKS


class BreakoutWorkers:
    """Sends students to other processes, and tracks them; on the shared session's thread."""

    def __init__(self, link: WorkerLink, classroom: Classroom, post_work: PostWork) -> None:
        self._link, self._classroom, self._post_work = link, classroom, post_work
        self._present: dict[int, Present] = {}
        self._begun: dict[str, VisitorRecord] = {}
        self._said: ClassState | None = None

    def load(self, shared: ServerLoad) -> ServerLoad:
        return combined([shared, *(present.load for present in self._present.values())])

    def send(self, student: str, begin: VisitorRecord) -> None:
        classroom, self._begun[student] = self._classroom, begin
        group = classroom.places.groups[student]
        handed_in, name = classroom.work.hand_ins.get(student), classroom.board.name_of(group)
        self._link.to_tab(
            student, group, Exploring(student, begin, classroom.has_work(student), handed_in, name, group)
        )

    def exchange(self) -> None:
        for message in self._link.received():
            match message:
                case Present(worker):
                    self._present[worker] = message
                case Replaced(worker):
                    before = self._present.pop(worker, None)
                    for student in () if before is None else before.students:
                        # Its first message does not include later hand-ins.
                        if student in self._begun and self._classroom.places.holds(student):
                            self.send(student, self._begun[student])
                case Progressed() | Reported() | Ran():
                    self._post_work(message)
                case _:
                    raise TypeError(f"the shared session does not understand {message!r}")
        self._classroom.elsewhere = tuple(
            student for present in self._present.values() for student in present.students
        )
        state = ClassState(
            self._classroom.free, self._classroom.paused, self._classroom.pace, self._classroom.wanted
        )
        if state != self._said:
            self._said = state
            if not state.free:
                self._begun.clear()
                self._link.send(ForgetTabs())
            self._link.to_all(state)


AWAY: Final = 5.0
"""Absence of a group's operator before another member takes over [s]."""

RELOAD: Final = 30.0
"""Allowed absence of a reconnecting member [s], for slow computers."""

SHOWN: Final = 60.0
"""Longest shown part of a student's run [s]."""


def run_of(participants: Iterable[Participant], student: str) -> Ran | None:
    """None if the session is not here."""
    players = (
        one.visitor.session.player for one in participants if one.group == student and one.visitor is not None
    )
    return next((Ran(student, player.recorded(SHOWN)) for player in players), None)


class BreakoutSessions:
    """The students' own sessions. `workers`: None to run the sessions in this process."""

    def __init__(
        self, context: AppContext, classroom: Classroom, workers: BreakoutWorkers | None = None
    ) -> None:
        self._context, self._classroom, self._workers = context, classroom, workers
        self._operators: dict[str, str] = {}
        self._left: dict[str, float] = {}
        self._coming: dict[str, float] = {}

    def expects(self, query: dict[str, str]) -> bool:
        """True if this browser gets a breakout session; thread-safe."""
        tab = None if self._workers is not None else tab_id(query)
        return (
            tab is not None
            and SCREEN not in query
            and self._classroom.free
            and self._classroom.places.holds(tab)
        )

    def load(self, here: ServerLoad) -> ServerLoad:
        return here if self._workers is None else self._workers.load(here)

    def settle(self, participants: Collection[Participant], begin: Callable[[str], VisitorRecord]) -> None:
        """Assign places, and move students to their own sessions or back.

        `begin`: initial record if none is saved.
        """
        self._context.store.tidy()
        if self._workers is not None:
            self._workers.exchange()
        classroom = self._classroom
        students = [one for one in participants if one.banner is not None or one.group]
        classroom.settle((*(one.id for one in students if one.lasting), *classroom.elsewhere), monotonic())
        for one in students:
            wanted = classroom.free and one.lasting and classroom.places.holds(one.id)
            if wanted != bool(one.group) and not one.moved:
                if wanted and self._workers is not None:
                    self._workers.send(one.id, begin(one.id))
                self._move(one)

    def admit(
        self, participant: Participant, participants: Collection[Participant], begin: VisitorRecord
    ) -> Pieces:
        """Open a group's saved or new session; its first member operates."""
        if self._operators.setdefault(participant.group, participant.id) != participant.id:
            return
        # Keep other members from operating it meanwhile.
        self._left[participant.group] = inf
        try:
            for other in participants:
                if (
                    other is not participant
                    and other.group == participant.group
                    and other.visitor is not None
                ):
                    # The server may not have noticed a lost connection yet.
                    other.visitor.save()
                    other.visitor.superseded = True
            # All members find the session again.
            query = {key: text for key, text in participant.query.items() if key not in LOOKS} | {
                "resume": participant.group
            }
            found = yield from self._context.store.recall(query)
            # Any link reopens a student's lesson.
            record = replace(begin if found is None else found, query=query)
            visitor = Visitor(self._context, participant.client, record.settings, record=record, query=query)
            yield from visitor.build()
            of_many = (
                len(self._classroom.places.members(participant.group)) > 1
                or participant.group != participant.id
            )
            if of_many or (found is None and not visitor.is_back):
                # Choices of the teacher, or of the previous operator, for their own page do not hold here.
                participant.dress(visitor.session, self._context.options.settings)
            left = (
                None if visitor.is_back or found is None else part_of(found, LessonSession.name, SavedLesson)
            )
            if found is not None and left is not None and left.open:
                visitor.session.post(RestoreSettings(found.settings))
            participant.visitor = visitor
        finally:
            self._left.pop(participant.group, None)
            self._coming.pop(participant.group, None)

    def close(self, participants: Iterable[Participant]) -> None:
        for visitor in [one.visitor for one in participants if one.visitor is not None]:
            visitor.save()
            visitor.session.close()

    def leave(self, participant: Participant) -> None:
        participant.leave()
        self._context.errors.forget(participant.client.client_id)
        if participant.visitor is not None:
            participant.visitor.leave()

    def frames(self, participants: Collection[Participant], now: float, elapsed: float) -> None:
        """Advance and draw every session for all members.

        `now`: wall time [s]; `elapsed`: since the last frame [s].
        """
        groups: dict[str, list[Participant]] = {}
        for one in participants:
            if one.group:
                groups.setdefault(one.group, []).append(one)
        self._operators = {
            group: student
            for group, student in self._operators.items()
            if self._classroom.free or group in groups
        }
        self._left = {group: since for group, since in self._left.items() if group in groups}
        for group, members in groups.items():
            lead = self._seat(group, members, now)
            for one in members:
                one.mates = len({other.id for other in members})
                page = one.visitor or one.member
                if page is not None:
                    set_language(page.language)
                    with self._context.guarded("a frame of a student's page failed", one.client.client_id):
                        one.show(self._classroom, None, page.view)
            if lead is not None and lead.visitor is not None:
                lead.visitor.beside = tuple(one.member for one in members if one.member is not None)
                with self._context.guarded("a frame of a student's page failed", lead.client.client_id):
                    lead.visitor.session.control.halt.set("teacher", self._classroom.paused)
                    lead.visitor.session.parts.of(LessonSession).pace = self._classroom.pace
                    lead.visitor.frame(now, elapsed)

    def _seat(self, group: str, members: list[Participant], now: float) -> Participant | None:
        for one in members:
            if one.takes_over:
                one.takes_over, self._operators[group] = False, one.id
        lead = next(
            (one for one in reversed(members) if one.visitor is not None and not one.visitor.superseded), None
        )
        if any(one.id == self._operators.get(group) for one in members):
            self._left.pop(group, None)
        elif now > max(self._left.setdefault(group, now) + AWAY, self._coming.get(group, 0.0)):
            self._operators[group] = members[0].id
        operator = self._operators.get(group)
        for one in members:
            operates = one.id == operator
            # The new operator reconnects once the page before has saved the session.
            if (not operates and one.visitor is not None) or (operates and lead is None):
                if operates and not one.moved:
                    self._coming[group] = now + RELOAD
                self._move(one)
            elif lead is None or lead.visitor is None or one.visitor is not None:
                continue
            elif one.member is None or not one.member.watches(lead.visitor):
                one.member = GroupMember(self._context, one.client, lead.visitor)
        return lead

    def _move(self, one: Participant) -> None:
        if not one.moved:
            one.moved = True
            self._context.server.send_elsewhere(one.client)
