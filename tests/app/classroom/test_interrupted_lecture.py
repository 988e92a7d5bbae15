"""A lecture whose server breaks off goes on when it is started again: stage, answers and lead; one that has ended does not."""

from pathlib import Path

from app.hosting.record_writer import RecordWriter
from app.hosting.session_store import SessionStore
from app.start import App
from tests.app.conftest import Join, OpenHouse, ask, lecture_of

TEACHER, STUDENT = "a" * 32, "b" * 32


def test_a_lecture_that_breaks_off_goes_on_and_one_that_has_ended_does_not(house: OpenHouse, join: Join, tmp_path: Path) -> None:
    path, saved = tmp_path / "store", tmp_path / "saved"
    first: App = house(lecture=True, store=path)
    host = lecture_of(first)
    teacher = join(first, f"lesson=3&step=2&resume={TEACHER}")
    student = join(first, f"resume={STUDENT}")
    student.wait_for(lambda _: host.operator is not None and STUDENT in host.room.here)
    host.control.post_answer(STUDENT, 1)
    teacher.wait_for(lambda _: any(host.room.ballots.everything[0].values()))
    asked, _ = host.room.ballots.everything
    place = ask(host.session, lambda _: (host.lessons.walk.lesson.id, host.lessons.walk.step.id))
    ask(host.session, lambda s: s.change("dm", 0.12))

    def stored() -> bool:
        record = first.context.store.interrupted_lecture()
        return (
            record is not None
            and record.room is not None
            and record.room.ballots == asked
            and record.settings == host.session.settings
        )

    teacher.wait_for(lambda _: stored())
    record = first.context.store.interrupted_lecture()
    first.close()
    ended = house(lecture=True, store=path)
    assert not lecture_of(ended).lessons.open and lecture_of(ended).room.ballots.everything == ({}, ())
    ended.close()
    # As a killed server leaves it.
    store = SessionStore(file=RecordWriter(saved, 3600.0, 10**8))
    assert record is not None
    store.save_lecture(record)
    store.close()
    again = lecture_of(house(lecture=True, store=saved))
    assert (again.lessons.walk.lesson.id, again.lessons.walk.step.id) == place and again.lessons.open
    assert again.room.ballots.everything[0] == asked and again.session.settings == record.settings
    assert record.state is not None and again.session.simulation.steps >= record.state.run.snapshot.steps
    # A student who is back first does not lead.
    assert not again._leader.admits(1, {"resume": STUDENT}) and again._leader.admits(2, {"resume": TEACHER})
