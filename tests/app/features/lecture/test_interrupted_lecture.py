"""A lecture whose server breaks off goes on when it is started again: stage, answers and lead; one that has ended does not."""

from pathlib import Path

import msgspec

from app.features.lecture.class_messages import Reported
from app.features.lecture.lecture_record import _summary_in
from app.features.lecture.teacher_control import Answer
from app.hosting.record_writer import RecordWriter
from app.hosting.session_store import SessionStore
from app.hosting.visitor_record import ClassRecord, VisitorRecord, record_from_bytes, record_to_bytes
from app.lessons.tally import Ballot
from app.settings import Settings
from app.start import App
from tests.app.conftest import Join, OpenHouse, ask, lecture_of
from tests.app.lessons.helpers import our_book

BOOK = our_book()
TEACHER, STUDENT = "a" * 32, "b" * 32
ANSWERED = {("redundancy", "freedom"): {STUDENT: Ballot(1)}}
BROKEN_OFF = VisitorRecord({}, Settings(), None, None, ClassRecord(5.0, ANSWERED, (), True, TEACHER, (STUDENT,)))


def test_a_lecture_that_breaks_off_goes_on_and_one_that_has_ended_does_not(house: OpenHouse, join: Join, tmp_path: Path) -> None:
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
        record = first.context.store.interrupted_lecture()
        return (
            record is not None
            and record.room is not None
            and {q: (*record.room.earlier[q], newest) for q, newest in record.room.ballots.items()} == asked
            and set(record.room.hand_ins) == {STUDENT}
            and record.settings == host.session.settings
        )

    teacher.wait_for(lambda _: stored())
    record = first.context.store.interrupted_lecture()
    first.close()
    ended = house(lecture=True, store=path, key="chalk")
    assert not lecture_of(ended).lessons.open and not lecture_of(ended).classroom.ballots.rounds
    # Its counts and what was handed in are offered to the teacher with the key, also after a lecture in which nothing happened.
    for _ in range(2):
        empty, left = lecture_of(ended)._summaries()
        assert empty.empty and left is not None and [one.name for one in left.hand_ins] == ["Ann"]
        assert [tally.counts[:2] for tally in left.asked[0].rounds] == [(1, 0), (0, 1)] and STUDENT not in str(left)
        ended.close()
        ended = house(lecture=True, store=path, key="chalk")
    ended.close()
    assert lecture_of(house(lecture=True, store=path))._summaries()[1] is None, "a lecture without a key"
    # As a killed server leaves it.
    store = SessionStore(file=RecordWriter(saved, 3600.0, 10**8))
    assert record is not None
    store.save_lecture(record)
    store.close()
    again = lecture_of(house(lecture=True, store=saved))
    assert (again.lessons.walk.lesson.id, again.lessons.walk.step.id) == place and again.lessons.open
    kept = again.classroom.ballots
    assert [len(one) for one in kept.rounds_of(place)] == [1, 1] and set(again.classroom.work.hand_ins) == {STUDENT}
    assert kept.pageless == {STUDENT} and not kept.pages_only
    assert kept.rounds == asked and again.session.settings == record.settings
    assert record.state is not None and again.session.simulation.steps >= record.state.run.snapshot.steps
    # A student who is back first does not lead.
    assert not again._leader.admits(1, {"resume": STUDENT}) and again._leader.admits(2, {"resume": TEACHER})


def test_a_class_that_broke_off_long_ago_is_one_that_has_ended() -> None:
    left = _summary_in(BROKEN_OFF, False, BOOK)
    assert left is not None and left.saved == 5.0 and left.asked[0].rounds[0].counts[1] == 1
    assert _summary_in(BROKEN_OFF, True, BOOK) is None and _summary_in(None, False, BOOK) is None
    ended = VisitorRecord({}, Settings(), None, last_class=left)
    assert _summary_in(record_from_bytes(record_to_bytes(ended), VisitorRecord), False, BOOK) == left


def test_a_record_of_a_class_from_before_the_rounds_is_read() -> None:
    data = msgspec.to_builtins(BROKEN_OFF)
    del data["last_class"]
    for later in ("earlier", "passed", "hand_ins", "pages_only", "pageless", "names", "pace", "groups"):
        del data["room"][later]
    # A ballot without a reason.
    data["room"]["ballots"] = {("redundancy", "freedom"): {STUDENT: (1, ())}}
    assert record_from_bytes(record_to_bytes(data), VisitorRecord) == BROKEN_OFF
