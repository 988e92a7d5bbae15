"""A lecture continues after a server crash, with session, answers and leader; an ended lecture does not."""

import shutil
from collections.abc import Iterator
from dataclasses import dataclass, replace
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
from app.features.lecture.lecture import LectureHost
from app.features.lecture.lecture_record import _summary_in
from app.features.lecture.teacher_control import Answer
from app.features.lessons.bookmark import OpenSteps
from app.features.lessons.progress import Progress, StepProgress, to_json
from app.features.lessons.tally import Ballot, QuestionId
from app.features.store.record_bytes import record_to_bytes, visitor_from_bytes
from app.features.store.record_writer import RecordWriter
from app.features.store.session_store import SessionStore, store_of
from app.hosting.visitor_record import VisitorRecord, with_part
from app.settings import Settings
from app.start import App
from tests.app.conftest import Join, OpenHouse, ask
from tests.app.features.lecture.lecture_room import lecture_of
from tests.app.features.lessons.helpers import opens_lesson, our_book
from tests.blocking_client import BlockingClient

BOOK = our_book()
TEACHER, STUDENT = "a" * 32, "b" * 32
ANSWERED = {("redundancy", "freedom"): {STUDENT: Ballot(1)}}
CLASS = ClassRecord(saved=5.0, ballots=ANSWERED, free=True, leader=TEACHER, students=(STUDENT,))
BROKEN_OFF = with_class(VisitorRecord({}, Settings()), CLASS, None)


@dataclass(frozen=True)
class Held:
    """A lecture with a student's two answers and hand-in, and its stored record."""

    opened: App
    store: Path
    record: VisitorRecord
    asked: dict[QuestionId, tuple[dict[str, Ballot], ...]]
    place: tuple[str, str]


def answered_twice(host: LectureHost, teacher: BlockingClient) -> None:
    """Answer the open question twice, with a new round between, and hand in."""
    ballots = host.classroom.ballots
    host.control.answers.put(Answer(STUDENT, 0))
    teacher.wait_for(lambda _: ballots.questions)
    host.control.post("again")
    teacher.wait_for(lambda _: len(ballots.rounds_of(ballots.questions[0])) == 2)
    host.control.answers.put(Answer(STUDENT, 1))
    host.control.answers.put(Reported(STUDENT, "Ann"))
    teacher.wait_for(lambda _: host.classroom.work.hand_ins and ballots.rounds_of(ballots.questions[0])[-1])


@pytest.fixture
def held(house: OpenHouse, join: Join, tmp_path: Path) -> Held:
    opened: App = house(lecture=True, store=tmp_path / "store")
    host = lecture_of(opened)
    teacher = join(opened, f"lesson=3&step=2&resume={TEACHER}")
    student = join(opened, f"resume={STUDENT}")
    student.wait_for(lambda _: host.controls.operator is not None and STUDENT in host.classroom.here)
    answered_twice(host, teacher)
    asked = host.classroom.ballots.rounds
    place = ask(host.session, lambda _: (host.lessons.walk.lesson.id, host.lessons.walk.step.id))
    ask(host.session, lambda s: s.change("dm", 0.12))

    def is_stored() -> bool:
        record = interrupted(store_of(opened.context))
        room = None if record is None else class_of(record)
        return (
            record is not None
            and room is not None
            and {q: (*room.earlier[q], newest) for q, newest in room.ballots.items()} == asked
            and set(room.hand_ins) == {STUDENT}
            and record.settings == host.session.settings
        )

    teacher.wait_for(lambda _: is_stored())
    record = interrupted(store_of(opened.context))
    assert record is not None
    return Held(opened, tmp_path / "store", record, asked, place)


def test_an_ended_lecture_leaves_its_counts_to_a_teacher_with_the_key(held: Held, house: OpenHouse) -> None:
    held.opened.close()
    # The second time, after a lecture without any activity.
    for _ in range(2):
        ended = house(lecture=True, store=held.store, key="chalk")
        assert not lecture_of(ended).lessons.open and not lecture_of(ended).classroom.ballots.rounds
        empty, left = lecture_of(ended).summaries()
        assert empty.empty and left is not None and [one.name for one in left.hand_ins] == ["Ann"]
        assert [tally.counts[:2] for tally in left.asked[0].rounds] == [(1, 0), (0, 1)]
        assert STUDENT not in str(left)
        ended.close()
    assert lecture_of(house(lecture=True, store=held.store)).summaries()[1] is None, (
        "a lecture without a key has no summary"
    )


def test_a_crashed_lecture_continues_with_its_answers_and_its_leader(
    held: Held, house: OpenHouse, tmp_path: Path
) -> None:
    # The store of a killed server.
    store = SessionStore(file=RecordWriter(tmp_path / "saved", 3600.0, 10**8))
    store.save_named(NAME, held.record)
    store.close()
    again = lecture_of(house(lecture=True, store=tmp_path / "saved"))
    walk, kept, state = again.lessons.walk, again.classroom.ballots, held.record.state
    assert (walk.lesson.id, walk.step.id) == held.place and again.lessons.open
    assert [len(one) for one in kept.rounds_of(held.place)] == [1, 1] and kept.rounds == held.asked
    assert set(again.classroom.work.hand_ins) == {STUDENT}
    assert kept.pageless == {STUDENT} and not kept.pages_only
    assert again.session.settings == held.record.settings
    assert state is not None and again.session.simulation.steps >= state.run.snapshot.steps
    # A student who reconnects first does not lead.
    assert not again.leader.admits(1, {"resume": STUDENT}) and again.leader.admits(2, {"resume": TEACHER})


def test_a_class_that_crashed_long_ago_has_ended() -> None:
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
    # An answer without a reason.
    data["room"]["ballots"] = {("redundancy", "freedom"): {STUDENT: (1, ())}}
    record = visitor_from_bytes(record_to_bytes(data))
    assert class_of(record) == CLASS and replace(record, parts={}) == VisitorRecord({}, Settings())


EARLIER = Path(__file__).parent / "earlier_class.store"
"""Store of the previous release: a class in lesson 2, and the summary of the class before."""

FREEDOM, CURVE, OTHER = ("redundancy", "freedom"), ("lambda", "curve"), "c" * 32


EARLIER_CLASS = ClassRecord(
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
        STUDENT: HandIn("Ann", to_json(Progress(steps={FREEDOM: StepProgress(choice=1)})), {FREEDOM: (0, 1)})
    },
    pages_only=True,
    pageless=(OTHER,),
    names={STUDENT: "Euler", OTHER: "Gauss"},
    pace=OpenSteps("redundancy", 1, 0, 1),
    nearest={("duel", "push"): 0.031},
    groups={STUDENT: STUDENT, OTHER: STUDENT},
)


@pytest.fixture
def earlier_store(tmp_path: Path) -> Iterator[SessionStore]:
    """Store of the previous release, in the file `store` of the test's folder."""
    shutil.copyfile(EARLIER, tmp_path / "store")
    store = SessionStore(file=RecordWriter(tmp_path / "store", 1e12, 10**8))
    yield store
    store.close()


def test_a_store_of_the_previous_release_is_read_completely(earlier_store: SessionStore) -> None:
    record = earlier_store.named(NAME)
    assert record is not None and record.state is not None and opens_lesson(record)
    last = last_class_of(record)
    assert class_of(record) == EARLIER_CLASS and last is not None
    counts = last.asked[0].rounds[0].counts
    assert (last.saved, last.students, counts) == (1.699e9, 1, (0, 0, 1, 0))
    assert record.state.run.snapshot.steps == 40 and len(record.state.run.pieces) > 0
    assert interrupted(earlier_store) is None, "the class crashed years ago"


def test_a_private_record_of_the_previous_release_is_read(
    earlier_store: SessionStore,
) -> None:
    other = earlier_store.named("d" * 32)
    assert other is not None and other.parts == {"invitation": msgspec.msgpack.encode("word")}
    assert other.settings.run.law.critical_distance == 0.2


def test_a_class_of_the_previous_release_continues(
    earlier_store: SessionStore, house: OpenHouse, tmp_path: Path
) -> None:
    record = earlier_store.named(NAME)
    assert record is not None
    # A record whose class crashed a moment ago.
    recent = with_class(record, replace(EARLIER_CLASS, saved=time()), last_class_of(record))
    earlier_store.save_named(NAME, recent)
    earlier_store.close()
    again = lecture_of(house(lecture=True, store=tmp_path / "store", keep=1e12, key="chalk"))
    room, walk = again.classroom, again.lessons.walk
    assert again.lessons.open and walk.lesson.id == "drift" and again.session.simulation.steps >= 40
    assert room.ballots.rounds_of(FREEDOM)[-1] == EARLIER_CLASS.ballots[FREEDOM] and room.free
    assert room.board.names == EARLIER_CLASS.names and room.places.groups == EARLIER_CLASS.groups
    assert room.pace == EARLIER_CLASS.pace and room.work.nearest == EARLIER_CLASS.nearest
    assert again.summaries()[1] is not None


def test_an_unreadable_part_does_not_affect_the_rest_of_a_record(
    caplog: pytest.LogCaptureFixture,
) -> None:
    damaged = with_part(BROKEN_OFF, "room", {"saved": "five"})
    record = visitor_from_bytes(record_to_bytes(damaged))
    assert class_of(record) is None and "room" in caplog.text and record.settings == Settings()
