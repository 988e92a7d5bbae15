"""Students' reasons, without a page: given after an answer, picked by the teacher, gone with the question."""

import pytest

from app.features.lecture.overlays import screen_html
from app.features.lecture.presenter import Station
from app.features.lecture.teacher_control import Because
from app.features.lessons.session.lesson_actions import GoTo
from tests.app.features.lecture.presenter_stage import BOOK, Stage

FIRST = (BOOK.lessons[0].id, BOOK.lessons[0].steps[0].id)
EVIL = "<img src=x onerror=alert(1)>"


def test_a_reason_needs_an_answer_of_its_student_to_its_question(stage: Stage) -> None:
    walk, classroom = stage.lessons.walk, stage.classroom
    classroom.give_reason(walk, "student 0", FIRST, "before the vote")
    stage.answer(0, 2, 2)
    classroom.give_reason(walk, "student 9", FIRST, "without a vote")
    classroom.give_reason(walk, "student 0", ("other", "question"), "of another question")
    assert not classroom.ballots.reasons(FIRST)
    classroom.give_reason(walk, "student 0", FIRST, "after it")
    assert [*classroom.ballots.reasons(FIRST).values()] == [(0, "after it")]


@pytest.fixture
def reasoned(stage: Stage) -> Stage:
    """Three answers: the third has an overlong reason with markup; the first replaces its reason."""
    stage.answer(0, 2, 2)
    for student, reason in (
        ("student 2", f" {EVIL}\n\u202e" + "x" * 500),
        ("student 0", "first"),
        ("student 0", "second thoughts"),
    ):
        stage.control.answers.put(Because(student, FIRST, reason))
        stage.control.answers.do()
    return stage


def test_an_answer_keeps_its_number_and_reason_when_it_changes(reasoned: Stage) -> None:
    ballots = reasoned.classroom.ballots
    assert ballots.reasons(FIRST) == {1: (0, "second thoughts"), 3: (2, f"{EVIL} {'x' * 171}")}
    assert reasoned.classroom.answer(reasoned.lessons.walk, "student 0", 1)
    assert ballots.reasons(FIRST)[1] == (1, "second thoughts")


def test_picked_reasons_are_shown_in_order_and_escaped(reasoned: Stage) -> None:
    walk, classroom, presenter = reasoned.lessons.walk, reasoned.classroom, reasoned.presenter
    reasoned.control.post("quote", "3, 1, 2, 77, no")
    reasoned.frame()
    assert presenter.quotes == (f"{EVIL} {'x' * 171}", "second thoughts")
    made = screen_html(Station.QUESTION, walk.view(), reasoned.control.poll(), None, False, presenter.quotes)
    assert "second thoughts" in made and "<img" not in made and "&lt;img" in made and "student" not in made
    # A later text of the author does not change the shown one.
    classroom.give_reason(walk, "student 0", FIRST, "something rude")
    assert presenter.quotes[1] == "second thoughts"
    assert classroom.hand_in(walk, "student 0", "", "")
    assert "something rude" in classroom.work.hand_ins["student 0"].progress


def test_no_reason_is_accepted_after_the_reveal(reasoned: Stage) -> None:
    reasoned.act("reveal")
    reasoned.classroom.give_reason(reasoned.lessons.walk, "student 0", FIRST, "too late")
    assert reasoned.classroom.ballots.reasons(FIRST)[1][1] == "second thoughts"


@pytest.mark.parametrize("ends", ["again", "another step"])
def test_quoted_reasons_disappear_with_their_question(stage: Stage, ends: str) -> None:
    stage.answer(0, 2, 2)
    stage.act("reveal")
    stage.presenter.quotes = ("first",)
    if ends == "again":
        stage.act("again")
    else:
        stage.lessons.act(GoTo(3, 0))
    stage.frame()
    assert stage.presenter.quotes == ()
