"""Breakout sessions start in the teacher's state, are independent, and survive a recall."""

import pytest

from app.session.session import Session
from scenes.settings import values
from tests.app.conftest import ask
from tests.app.features.lecture.lecture_room import WAIT, Class, command, leave_lessons, sees, sessions_of
from tests.app.page.helpers import bodies, click, open_lessons
from tests.blocking_client import BlockingClient

D_M = "critical distance d_m [mm]"


@pytest.fixture
def exploring(classroom: Class) -> Class:
    """Ann and bo explore; the teacher is outside the lessons, at another critical distance."""
    leave_lessons(classroom.teacher)
    classroom.teacher.wait_for(lambda _: not classroom.host.lessons.open, WAIT)
    ask(classroom.host.session, lambda s: s.change("dm", 0.12))
    classroom.explore("ann", "bo")
    classroom.come("ann", "bo")
    for name in ("ann", "bo"):
        classroom.number(name)
    return classroom


def state(session: Session) -> tuple[object, ...]:
    return ask(session, lambda s: (s.settings, s.paused, s.held))


def set_critical_distance(student: BlockingClient, session: Session, millimetres: float) -> None:
    student.set_value(D_M, millimetres)
    student.wait_for(
        lambda _: session.settings.run.law.critical_distance == pytest.approx(millimetres / 1000.0), WAIT
    )


def test_breakout_sessions_start_in_the_teachers_state(classroom: Class) -> None:
    ask(classroom.host.session, lambda s: s.change("dm", 0.12))
    classroom.come("ann", "bo")
    ann, _ = classroom.send("Explore freely", "ann", "bo")
    number = classroom.number("ann")
    sees(classroom.teacher, "exploring: 2")
    sees(ann, "this is your own session", "Lesson 1 · step 1")
    assert number != classroom.number("bo")
    arms = [node for name, node in list(ann.mirror.nodes.items()) if name.startswith("/arms/")]
    assert arms and all(node.get("owner") == str(number) for node in arms), (
        "the page has no arm of the shared session"
    )


def test_a_students_changes_reach_neither_other_students_nor_the_teacher(exploring: Class) -> None:
    host, (ann, bo) = exploring.host, exploring.students.values()
    hers, his = exploring.session_of("ann"), exploring.session_of("bo")
    assert exploring.critical_distance("ann") == exploring.critical_distance("bo") == 0.12
    shared, before = state(host.session), state(his)
    set_critical_distance(ann, hers, 70.0)
    command(ann, "Pause or continue")
    ann.wait_for(lambda _: hers.paused, WAIT)
    assert state(his) == before and state(host.session) == shared
    open_lessons(bo)
    bo.wait_for(lambda _: values(his.settings)["scene"] == "solo", WAIT)
    assert exploring.critical_distance("ann") == 0.07 and state(host.session) == shared
    ask(host.session, lambda s: s.change("dm", 0.25))
    assert exploring.critical_distance("ann") == 0.07


def test_a_breakout_session_survives_a_lost_connection_and_a_recall(exploring: Class) -> None:
    ann, bo = exploring.students.values()
    set_critical_distance(ann, exploring.session_of("ann"), 70.0)
    set_critical_distance(bo, exploring.session_of("bo"), 200.0)
    open_lessons(bo)
    sees(bo, "Lesson 1 · step 1")
    ann.close()
    exploring.come("ann")
    assert exploring.critical_distance("ann") == 0.07
    ann, bo = exploring.send("Follow me", "ann", "bo")
    sees(ann, "You follow the teacher")
    # Bo's earlier connection may end later than ann's.
    ann.wait_for(lambda _: sessions_of(exploring.host) == {}, WAIT)
    assert not bodies(ann, "GuiSliderMessage")
    # After the next release both have their earlier settings, and bo is in his lesson.
    ann, bo = exploring.send("Explore freely", "ann", "bo")
    assert exploring.critical_distance("ann") == 0.07
    sees(bo, "Lesson 1 · step 1")
    session = exploring.session_of("bo")
    click(bo, "Leave the lessons")
    bo.wait_for(lambda _: session.settings.run.law.critical_distance == 0.2, WAIT)
