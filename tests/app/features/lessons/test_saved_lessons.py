"""Work in lessons, restored from a visitor's record, also of the previous release."""

from collections.abc import Callable
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.features.lessons.bookmark import Phase
from app.features.lessons.loading import load_lessons
from app.features.lessons.panel.lesson_visit import open_link
from app.features.lessons.progress import SavedLesson
from app.features.lessons.session.lesson_actions import Choose, Press
from app.features.lessons.session.lesson_session import LessonSession
from app.features.store.record_bytes import joined_record, record_to_bytes, visitor_from_bytes
from app.hosting.visitor import record_of, run_again
from app.hosting.visitor_record import VisitorRecord
from app.session.frame import make_frame
from app.session.session import Session
from app.session.session_state import state_of
from app.settings import Settings
from scenes.inputs import RecordedPerson
from scenes.settings import changed
from tests.app.features.lessons.helpers import lesson_in, lessons_in
from tests.app.features.store.test_session_store import TAB, WORDS, again, session_of, tab


@pytest.fixture(scope="module")
def short() -> Session:
    return session_of(0.6, ghost="unprotected")


@pytest.mark.parametrize(("lesson", "open"), [("3", True), ("4", False)])
def test_the_same_link_restores_the_step_and_another_link_the_progress(lesson: str, open: bool) -> None:
    book = load_lessons()
    run = lessons_in(Session(Settings()), book)
    run.enter(2)
    run.walk.choose(1)
    place = run.walk.lesson.id, run.walk.step.id
    session = Session(Settings())
    session.parts.restore({run.name: run.saved()})
    back = lessons_in(session, book)
    assert open_link(back, {"lesson": lesson}, VisitorRecord({"lesson": "3"}, Settings())) == ()
    assert (
        back.walk.done_in(*place).choice == 1 and ((back.walk.lesson.id, back.walk.step.id) == place) == open
    )


NAMES = st.from_regex(r"[a-z0-9-]{1,12}", fullmatch=True)


STEPS = st.tuples(NAMES, NAMES)


@given(
    progress=WORDS,
    said=st.dictionaries(
        STEPS, st.lists(st.none() | st.floats(allow_nan=False), max_size=3).map(tuple), max_size=3
    ),
    names=st.lists(STEPS, max_size=2, unique=True),
    dm=st.floats(0.03, 0.3),
    flags=st.tuples(*[st.booleans()] * 3),
)
@settings(max_examples=25, deadline=None)
def test_work_in_lessons_is_restored_unchanged(short: Session, progress, said, names, dm, flags) -> None:
    own, piece = changed(Settings(), "dm", dm), state_of(short).run.pieces[0]
    hands, people = dict.fromkeys(names, piece), {name: RecordedPerson(piece) for name, _ in names}
    lessons = SavedLesson(progress, own, flags[0], hands, own if flags[1] else None, people, said, flags[2])
    session = Session(own)
    run = session.parts.of(LessonSession)
    run.left = lessons
    other = Session(own)
    record = again(record_of({"resume": TAB}, session))
    other.parts.restore(record.parts, record.recordings)
    back = other.parts.of(LessonSession)
    assert back.left is not None and replace(back.left, seen={}, kept={}) == replace(
        lessons, seen={}, kept={}
    )
    assert back.left.seen.keys() == set(names) and back.left.kept.keys() == people.keys()
    assert (
        back.saved() == run.saved()
        and back.recordings().keys() == run.recordings().keys() == record.recordings.keys()
    )
    # The previous release stored it as a field of the record.
    stored = {
        "query": {"resume": TAB},
        "settings": own,
        "lessons": replace(lessons, seen={}, kept={}),
        "state": None,
    }
    earlier = joined_record(visitor_from_bytes(record_to_bytes(stored)), record.recordings)
    assert earlier.parts == record.parts and earlier.recordings == record.recordings


@pytest.mark.parametrize("ghost", ["off", "unprotected"])
def test_an_interrupted_run_of_a_lesson_has_the_same_outcome(ghost: str) -> None:
    book, link = load_lessons(), {"resume": tab(1), "lesson": "3", "step": "2"}

    def run(session: Session, until: Callable[[], bool]) -> None:
        while not until():
            make_frame(session, 0.0, 0.05, 60.0)

    session = Session(Settings())
    lessons = lessons_in(session, book)
    open_link(lessons, link, None)
    lessons.act(Choose(1))
    session.change("ghost", ghost)
    lessons.act(Press("run"))
    run(session, lambda: session.simulation.time > 1.0)
    record = again(record_of(link, session))
    other = Session(record.settings)
    other.parts.restore(record.parts, record.recordings)
    back = lessons_in(other, book)
    assert open_link(back, link, record) == ()
    list(run_again(other, record))
    assert other.simulation.time == session.simulation.time and not other.paused
    for one, way in ((session, lessons), (other, back)):
        run(one, lambda way=way: way.walk.phase is Phase.OBSERVE)
    assert back.walk.done.outcome == lessons.walk.done.outcome is not None
    assert other.simulation.positions.tobytes() == session.simulation.positions.tobytes()
    # A measured run is not measured again.
    record = again(record_of(link, other))
    third = Session(record.settings)
    third.parts.restore(record.parts, record.recordings)
    last = lessons_in(third, book)
    open_link(last, link, record)
    list(run_again(third, record))
    saved = lesson_in(record)
    assert saved is not None and saved.measured and third.paused
    assert (last.walk.phase, last.walk.to_json()) == (Phase.OBSERVE, back.walk.to_json())
