"""A process with breakout sessions only."""

import logging

import viser

from app.features.classroom.class_summary import HandIn
from app.features.classroom.classroom import Classroom
from app.features.classroom.student_work import clean_name
from app.features.lecture.breakout_sessions import BreakoutSessions, run_of
from app.features.lecture.class_messages import (
    ClassState,
    Exploring,
    Present,
    Progressed,
    Reported,
    WorkAction,
)
from app.features.lecture.participant import Participant
from app.features.workers.worker_messages import Replaced, WorkerLink
from app.hosting.admission import Admission, Pieces
from app.hosting.app_context import AppContext
from app.hosting.visitor_record import tab_id
from app.session.actions import Action, ActionQueue
from app.web.request import request_query

log = logging.getLogger("duet.lecture")


class BreakoutHost:
    """Gives each student sent here a session; the teacher's decisions arrive as messages."""

    def __init__(self, context: AppContext, link: WorkerLink) -> None:
        self._context, self._link = context, link
        link.wake = context.wake
        self.classroom = Classroom(context.workload.places)
        self.participants: dict[int, Participant] = {}
        self._work = ActionQueue(self._take_work)
        self._breakouts = BreakoutSessions(context, self.classroom)
        self._expected: dict[str, Exploring] = {}
        self._early: list[viser.ClientHandle] = []
        self._said: Present | None = None
        self.admission = Admission(
            context, self._admit, lambda _: log.exception("a student's page could not be built")
        )
        context.server.gate.may_share = lambda client_id: False
        context.server.takes_over = lambda query: True

    def close(self, goes_on: bool = False) -> None:
        del goes_on
        self.admission.close()
        self._breakouts.close(self.participants.values())
        self._context.store.close()

    def frame(self, now: float, elapsed: float) -> None:
        self._listen()
        self._connect()
        self._work.do()
        self._context.store.tidy()
        self._breakouts.frames(list(self.participants.values()), now, elapsed)
        if (run := run_of(self.participants.values(), self.classroom.wanted)) is not None:
            self.classroom.wanted = ""
            self._link.to_first(run)
        present = tuple(sorted(one.id for one in self.participants.values()))
        said = Present(self._link.index, present, self._context.workload.report)
        if said != self._said:
            self._said = said
            self._link.to_first(said)

    def _post_work(self, work: WorkAction) -> None:
        """Thread-safe."""
        self._link.to_first(work)
        self._work.put(work)

    def _take_work(self, action: Action) -> None:
        match action:
            case Progressed(student, progress):
                self.classroom.work.note(student, progress)
            case Reported(student, name, progress):
                # The shared session's process makes the report; the student's page shows that it exists.
                self.classroom.work.hand_in(
                    student, None if name is None else HandIn(clean_name(name), progress)
                )
            case _:
                raise TypeError(f"nothing here does {action!r}")

    def _listen(self) -> None:
        for message in self._link.received():
            match message:
                case Exploring(student=student, report=report, name=name, group=group):
                    self._expected[student] = message
                    self.classroom.places.groups[student] = group
                    self.classroom.board.names[group] = name
                    self.classroom.work.hand_in(student, report)
                case ClassState(free, paused, pace, wanted):
                    self.classroom.free, self.classroom.paused = free, paused
                    self.classroom.pace, self.classroom.wanted = pace, wanted
                    if not free:
                        self._expected.clear()
                        self.classroom.places.take_all()
                        for one in self.participants.values():
                            self._context.server.send_elsewhere(one.client)
                case Replaced():
                    self._said = None
                    for one in self.participants.values():
                        if one.hand_in is not None:
                            one.hand_in.post_again()
                case _:
                    raise TypeError(f"a breakout process does not understand {message!r}")

    def _connect(self) -> None:
        arrivals, departures = self.admission.changes()
        for client_id in departures:
            participant = self.participants.pop(client_id, None)
            if participant is not None:
                self._breakouts.leave(participant)
        # The message may come after the student.
        waiting = [client for client in self._early if client.client_id not in departures] + arrivals
        self._early = []
        for client in waiting:
            if tab_id(request_query(client)) in self._expected:
                self.admission.come(client)
            elif self.classroom.free:
                self._early.append(client)
            else:
                self._context.server.send_elsewhere(client)
        self.admission.advance()

    def _admit(self, client: viser.ClientHandle) -> Pieces:
        participant = Participant(client, False, None, self._post_work)
        expected = self._expected.get(participant.id)
        if expected is None:
            # Meanwhile the teacher has called all back.
            self._context.server.send_elsewhere(client)
            return
        participant.worked, participant.group = expected.worked, expected.group
        yield from self._breakouts.admit(participant, self.participants.values(), expected.begin)
        self.participants[client.client_id] = participant
        if participant.id not in self._expected:
            # Called back while the page was being built.
            self._context.server.send_elsewhere(client)
