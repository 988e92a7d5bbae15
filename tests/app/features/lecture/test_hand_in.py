"""Hand-ins over real connections: from shared and breakout sessions, from one tab at a time."""

import pytest

from app.features.classroom.class_summary import HandIn
from app.features.lessons.session.lesson_actions import Choose, GoTo
from app.web.pages import TAKEN_OVER
from tests.app.conftest import ask
from tests.app.features.lecture.lecture_room import KEY, WAIT, Class, Come, everything, sees, tab_of
from tests.app.features.lessons.helpers import lessons_of, our_book
from tests.app.page.helpers import buttons, click
from tests.app.web.conftest import ended
from tests.blocking_client import BlockingClient

BOOK = our_book()


def second_tab(classroom: Class, name: str) -> BlockingClient:
    """New tab of a student; it replaces the first tab."""
    first = classroom.students[name]
    (second,) = classroom.come(name)
    assert ended(first)[1] == TAKEN_OVER
    return second


def report(classroom: Class, name: str) -> HandIn:
    return classroom.host.classroom.work.hand_ins[tab_of(name)]


@pytest.fixture
def answered(classroom: Class) -> Class:
    """A class of two students; ann chose answer 2 in lesson 1, step 1."""
    ann, bo = classroom.come("ann", "bo")
    sees(bo, "Your prediction?")
    assert "Hand in" not in buttons(ann), "there is nothing to hand in"
    click(ann, "2 ")
    sees(classroom.teacher, "1 answered · 1 not yet")
    return classroom


def test_a_hand_in_has_a_clean_name_that_only_its_student_sees(answered: Class) -> None:
    ann, bo = answered.students.values()
    sees(ann, "The teacher gets what is in")
    ann.set_value("Name", " Ann\n=1 ")
    click(ann, "Hand in")
    sees(ann, "Handed in as Ann =1.")
    sees(answered.teacher, "reports handed in: 1")
    assert "Hand in" not in buttons(bo) and "Ann =1" not in everything(bo)
    ann = second_tab(answered, "ann")
    sees(ann, "You may change it", "Handed in as Ann =1.")
    sees(answered.teacher, "1 answered · 1 not yet", "students here: 2")


def test_a_breakout_session_shows_the_hand_in_and_can_replace_it(answered: Class) -> None:
    teacher, host, ann = answered.teacher, answered.host, answered.students["ann"]
    click(ann, "Hand in")
    sees(ann, "Handed in without a name.")
    # Her breakout session has the teacher's step, her answer and the hand-in; so does her next tab.
    ask(host.session, lambda _: host.lessons.act(GoTo(2, 1)))
    answered.send("Explore freely", "ann", "bo")
    answered.number("ann")
    ann = second_tab(answered, "ann")
    sees(ann, "this is your own session", "Lesson 2 · step 2", "Handed in without a name.")
    sees(teacher, "students here: 2")
    visitor = host.participants[answered.number("ann")].visitor
    assert visitor is not None
    lessons = lessons_of(visitor)
    assert lessons.walk.done_in(BOOK.lessons[0].id, BOOK.lessons[0].steps[0].id).choice == 1
    ask(visitor.session, lambda _: [lessons.act(GoTo(4, 1)), lessons.act(Choose(1))])
    ann.set_value("Name", "Ann")
    click(ann, "Hand in again")
    sees(ann, "Handed in as Ann.")
    again = report(answered, "ann")
    assert again.name == "Ann" and '"choice": 1' in again.progress and "lambda" in again.progress


def test_breakout_work_is_handed_in_from_the_shared_session_or_withdrawn(answered: Class) -> None:
    teacher, host = answered.teacher, answered.host
    click(answered.students["ann"], "Hand in")
    ann, bo = answered.send("Explore freely", "ann", "bo")
    his = host.participants[answered.number("bo")].visitor
    assert his is not None
    ask(his.session, lambda _: lessons_of(his).act(Choose(0)))
    ann, bo = answered.send("Follow me", "ann", "bo")
    click(bo, "Hand in")
    sees(bo, "Handed in without a name.")
    assert '"choice": 0' in report(answered, "bo").progress
    sees(teacher, "reports handed in: 2")
    click(ann, "Take it back")
    teacher.wait_for(lambda _: set(host.classroom.work.hand_ins) == {tab_of("bo")}, WAIT)
    sees(teacher, "reports handed in: 1")


def test_several_projectors_and_teachers_may_connect(classroom: Class, come: Come) -> None:
    (ann,) = classroom.come("ann")
    screens = [come(classroom.opened, "s", query="screen=1") for _ in range(2)]
    teachers = [come(classroom.opened, "t", key=KEY) for _ in range(2)]
    sees(classroom.teacher, "screens: 2")
    assert all(one.closed is None for one in (ann, *screens, *teachers))
