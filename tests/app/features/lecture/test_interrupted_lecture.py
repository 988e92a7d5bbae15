"""A lecture whose server breaks off goes on when it is started again: stage, answers and lead; one that has ended does not."""

import shutil
from dataclasses import replace
from pathlib import Path
from time import time

import msgspec
import pytest

from app.features.classroom.class_record import (
    NAME,
    ClassRecord,
    class_of,
    interrupted,
    last_class_of,
    with_class,
)
from app.features.classroom.class_summary import HandIn
from app.features.lecture.class_messages import Reported
from app.features.lecture.lecture_record import _summary_in
from app.features.lecture.teacher_control import Answer
from app.features.lessons.bookmark import OpenSteps
from app.features.lessons.progress import Progress, StepProgress, to_json
from app.features.lessons.tally import Ballot
from app.features.store.record_bytes import record_to_bytes, visitor_from_bytes
from app.features.store.record_writer import RecordWriter
from app.features.store.session_store import SessionStore, store_of
from app.hosting.visitor_record import VisitorRecord, with_part
from app.settings import Settings
from app.start import App
from tests.app.conftest import Join, OpenHouse, ask
from tests.app.features.lecture.lecture_room import lecture_of
from tests.app.features.lessons.helpers import opens_lesson, our_book

BOOK = our_book()
TEACHER, STUDENT = "a" * 32, "b" * 32
ANSWERED = {("redundancy", "freedom"): {STUDENT: Ballot(1)}}
CLASS = ClassRecord(saved=5.0, ballots=ANSWERED, free=True, leader=TEACHER, students=(STUDENT,))
BROKEN_OFF = with_class(VisitorRecord({}, Settings()), CLASS, None)


def test_a_lecture_that_breaks_off_goes_on_and_one_that_has_ended_does_not(
    house: OpenHouse, join: Join, tmp_path: Path
) -> None:
    path, saved = tmp_path / "store", tmp_path / "saved"
    first: App = house(lecture=True, store=path)
    host = lecture_of(first)
    teacher = join(first, f"lesson=3&step=2&resume={TEACHER}")
    student = join(first, f"resume={STUDENT}")
    student.wait_for(lambda _: host.controls.operator is not None and STUDENT in host.classroom.here)
    host.control.answers.put(Answer(STUDENT, 0))
    ballots = host.classroom.ballots
    teacher.wait_for(lambda _: ballots.questions)
    host.control.post("again")
    teacher.wait_for(lambda _: len(ballots.rounds_of(ballots.questions[0])) == 2)
    host.control.answers.put(Answer(STUDENT, 1))
    host.control.answers.put(Reported(STUDENT, "Ann"))
    teacher.wait_for(lambda _: host.classroom.work.hand_ins and ballots.rounds_of(ballots.questions[0])[-1])
    asked = ballots.rounds
    place = ask(host.session, lambda _: (host.lessons.walk.lesson.id, host.lessons.walk.step.id))
    ask(host.session, lambda s: s.change("dm", 0.12))

    def stored() -> bool:
        record = interrupted(store_of(first.context))
        room = None if record is None else class_of(record)
        return (
            record is not None
            and room is not None
            and {q: (*room.earlier[q], newest) for q, newest in room.ballots.items()} == asked
            and set(room.hand_ins) == {STUDENT}
            and record.settings == host.session.settings
        )

    teacher.wait_for(lambda _: stored())
    record = interrupted(store_of(first.context))
    first.close()
    ended = house(lecture=True, store=path, key="chalk")
    assert not lecture_of(ended).lessons.open and not lecture_of(ended).classroom.ballots.rounds
    # Its counts and what was handed in are offered to the teacher with the key, also after a lecture in which nothing happened.
    for _ in range(2):
        empty, left = lecture_of(ended).summaries()
        assert empty.empty and left is not None and [one.name for one in left.hand_ins] == ["Ann"]
        assert [tally.counts[:2] for tally in left.asked[0].rounds] == [
            (1, 0),
            (0, 1),
        ] and STUDENT not in str(left)
        ended.close()
        ended = house(lecture=True, store=path, key="chalk")
    ended.close()
    assert lecture_of(house(lecture=True, store=path)).summaries()[1] is None, "a lecture without a key"
    # As a killed server leaves it.
    store = SessionStore(file=RecordWriter(saved, 3600.0, 10**8))
    assert record is not None
    store.save_named(NAME, record)
    store.close()
    again = lecture_of(house(lecture=True, store=saved))
    assert (again.lessons.walk.lesson.id, again.lessons.walk.step.id) == place and again.lessons.open
    kept = again.classroom.ballots
    assert [len(one) for one in kept.rounds_of(place)] == [1, 1] and set(again.classroom.work.hand_ins) == {
        STUDENT
    }
    assert kept.pageless == {STUDENT} and not kept.pages_only
    assert kept.rounds == asked and again.session.settings == record.settings
    assert record.state is not None and again.session.simulation.steps >= record.state.run.snapshot.steps
    # A student who is back first does not lead.
    assert not again.leader.admits(1, {"resume": STUDENT}) and again.leader.admits(2, {"resume": TEACHER})


def test_a_class_that_broke_off_long_ago_is_one_that_has_ended() -> None:
    left = _summary_in(BROKEN_OFF, False, BOOK)
    assert left is not None and left.saved == 5.0 and left.asked[0].rounds[0].counts[1] == 1
    assert _summary_in(BROKEN_OFF, True, BOOK) is None and _summary_in(None, False, BOOK) is None
    ended = with_class(VisitorRecord({}, Settings()), None, left)
    assert _summary_in(visitor_from_bytes(record_to_bytes(ended)), False, BOOK) == left


def test_a_record_of_a_class_from_before_the_rounds_is_read() -> None:
    data = msgspec.to_builtins(VisitorRecord({}, Settings()))
    del data["parts"]
    data["room"] = msgspec.to_builtins(CLASS)
    for later in ("earlier", "passed", "hand_ins", "pages_only", "pageless", "names", "pace", "groups"):
        del data["room"][later]
    # A ballot without a reason.
    data["room"]["ballots"] = {("redundancy", "freedom"): {STUDENT: (1, ())}}
    record = visitor_from_bytes(record_to_bytes(data))
    assert class_of(record) == CLASS and replace(record, parts={}) == VisitorRecord({}, Settings())


EARLIER = Path(__file__).parent / "earlier_class.store"
"""Store of the release before: a shared session in lesson 2 with its class, and the summary of the class before."""

FREEDOM, CURVE, OTHER = ("redundancy", "freedom"), ("lambda", "curve"), "c" * 32


def test_a_store_of_the_release_before_is_read_whole_and_goes_on(house: OpenHouse, tmp_path: Path) -> None:
    path = tmp_path / "store"
    shutil.copyfile(EARLIER, path)
    store = SessionStore(file=RecordWriter(path, 1e12, 10**8))
    record = store.named(NAME)
    assert record is not None and record.state is not None and opens_lesson(record)
    room, last = class_of(record), last_class_of(record)
    assert room is not None and room == ClassRecord(
        saved=1.7e9,
        ballots={
            FREEDOM: {STUDENT: Ballot(1, (), "because"), OTHER: Ballot(0)},
            CURVE: {STUDENT: Ballot(None, (0.1, None, 0.3))},
        },
        revealed=(FREEDOM,),
        free=True,
        leader=TEACHER,
        students=(STUDENT, OTHER),
        earlier={FREEDOM: ({STUDENT: Ballot(0), OTHER: Ballot(0)},)},
        passed={FREEDOM: (OTHER,)},
        hand_ins={
            STUDENT: HandIn(
                "Ann", to_json(Progress(steps={FREEDOM: StepProgress(choice=1)})), {FREEDOM: (0, 1)}
            )
        },
        pages_only=True,
        pageless=(OTHER,),
        names={STUDENT: "Euler", OTHER: "Gauss"},
        pace=OpenSteps("redundancy", 1, 0, 1),
        nearest={("duel", "push"): 0.031},
        groups={STUDENT: STUDENT, OTHER: STUDENT},
    )
    assert last is not None and (last.saved, last.students, last.asked[0].rounds[0].counts) == (
        1.699e9,
        1,
        (0, 0, 1, 0),
    )
    assert record.state.run.snapshot.steps == 40 and len(record.state.run.pieces) > 0
    assert interrupted(store) is None, "it broke off years ago"
    # What another visitor has left, with no class: its one part is the word of an invitation.
    (other,) = [one for one in [store.named("d" * 32)] if one is not None]
    assert (
        other.parts == {"invitation": msgspec.msgpack.encode("word")}
        and other.settings.run.law.critical_distance == 0.2
    )
    store.save_named(NAME, with_class(record, replace(room, saved=time()), last))
    store.close()
    again = lecture_of(house(lecture=True, store=path, keep=1e12, key="chalk"))
    assert (
        again.lessons.open
        and again.lessons.walk.lesson.id == "drift"
        and again.session.simulation.steps >= 40
    )
    assert again.classroom.ballots.rounds_of(FREEDOM)[-1] == room.ballots[FREEDOM] and again.classroom.free
    assert again.classroom.board.names == room.names and again.classroom.places.groups == room.groups
    assert again.classroom.pace == room.pace and again.classroom.work.nearest == room.nearest
    assert again.summaries()[1] is not None


def test_a_part_that_cannot_be_read_costs_the_rest_of_a_record_nothing(
    caplog: pytest.LogCaptureFixture,
) -> None:
    damaged = with_part(BROKEN_OFF, "room", {"saved": "five"})
    record = visitor_from_bytes(record_to_bytes(damaged))
    assert class_of(record) is None and "room" in caplog.text and record.settings == Settings()
