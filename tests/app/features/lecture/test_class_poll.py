"""The question of a class over real connections: one answer per student, hidden until the reveal."""

import pytest

from app.features.lessons.session.lesson_actions import Press
from app.web.pages import HELLO
from app.web.server import MOVED_CODE
from tests.app.conftest import ask
from tests.app.features.lecture.lecture_room import (
    BY_KEY,
    WAIT,
    Class,
    banner,
    command,
    everything,
    leave_lessons,
    sees,
    sessions_of,
)
from tests.app.features.lessons.helpers import our_book
from tests.app.page.helpers import buttons, click, shown
from tests.app.web.conftest import ended
from tests.approved import Approve
from tests.blocking_client import BlockingClient

QUESTION = our_book().lessons[0].steps[0].question
assert QUESTION is not None
RIGHT, WRONG = QUESTION.right, (QUESTION.right + 1) % len(QUESTION.choices)


def answer(student: BlockingClient, choice: int) -> None:
    click(student, f"{choice + 1} ")


@pytest.fixture
def asked(classroom: Class) -> Class:
    """A class of three students before the first answer."""
    (ann, _, _) = classroom.come("ann", "bo", "cy")
    sees(ann, "Your prediction?")
    sees(classroom.teacher, "0 answered · 3 not yet", "students here: 3")
    return classroom


def answer_all(classroom: Class, **choices: int) -> None:
    for name, choice in choices.items():
        answer(classroom.students[name], choice)
    sees(classroom.teacher, f"{len(choices)} answered · 0 not yet")


def test_an_answer_counts_once_after_any_number_of_reconnections(asked: Class) -> None:
    ann, bo, teacher = asked.students["ann"], asked.students["bo"], asked.teacher
    answer(ann, WRONG)
    sees(ann, "You may change it")
    command(bo, f"Answer {WRONG + 1}")
    sees(teacher, "2 answered · 1 not yet")
    # Ann changes her answer and reconnects; bo loses the connection.
    answer(ann, RIGHT)
    ann.close()
    (ann,) = asked.come("ann")
    sees(ann, "You may change it")
    bo.close()
    sees(teacher, "2 answered · 1 not yet", "students here: 2")
    asked.come("bo")
    sees(teacher, "2 answered · 1 not yet", "students here: 3")


def test_before_the_reveal_no_student_and_no_screen_gets_the_answers(asked: Class, approve: Approve) -> None:
    screen, students = asked.screen(), asked.students.values()
    # There is nothing to reveal yet; the later commands confirm that this one was handled.
    command(asked.teacher, BY_KEY["reveal"])
    said: list[str] = []
    for text in ("paused everybody", "You follow the teacher"):
        command(asked.teacher, BY_KEY["pause"])
        sees(asked.students["ann"], text)
        said.append(banner(asked.students["ann"]))
    approve("banners of a class.txt", "".join(said))
    answer_all(asked, ann=RIGHT, bo=WRONG, cy=RIGHT)
    assert not any("The class sa" in everything(one) for one in (*students, screen))
    assert not any(label.startswith("1 ") for label in buttons(screen))
    session = asked.host.session
    assert not session.paused or ask(session, lambda s: s.simulation.steps) == 0


def test_the_reveal_closes_the_question_and_selects_the_favourite(asked: Class) -> None:
    host, teacher, bo, screen = asked.host, asked.teacher, asked.students["bo"], asked.screen()
    answer_all(asked, ann=RIGHT, bo=WRONG, cy=RIGHT)
    click(teacher, "Reveal to everybody")
    for one in (*asked.students.values(), screen, teacher):
        sees(one, "The class said", "3 answered")
    sees(bo, "Answers are closed.")
    assert host.lessons.walk.done.choice == RIGHT and not host.lessons.locked
    sent = ask(host.session, lambda _: host.classroom.answer(host.lessons.walk, "bo", RIGHT))
    assert not sent and not [label for label in buttons(bo) if label.startswith(f"{RIGHT + 1} ")]


def test_with_the_outcome_each_student_gets_a_verdict(asked: Class) -> None:
    host, (ann, bo, cy) = asked.host, asked.students.values()
    answer_all(asked, ann=RIGHT, bo=WRONG, cy=RIGHT)
    click(asked.teacher, "Reveal to everybody")
    sees(bo, "The class said")
    ask(host.session, lambda _: host.lessons.act(Press("next")))
    for one in (ann, bo, cy):
        sees(one, "The class said", "Measured", "You said")
    sees(bo, "card wrong duet-say")
    # One verdict is the class's, in the shared session; the other is ann's.
    ann.wait_for(lambda _: shown(ann).count("card right duet-say") == 2, WAIT)


def test_a_question_asked_again_takes_new_answers_and_shows_both_rounds(asked: Class) -> None:
    teacher, bo, screen = asked.teacher, asked.students["bo"], asked.screen()
    answer_all(asked, ann=RIGHT, bo=WRONG, cy=RIGHT)
    click(teacher, "Reveal to everybody")
    click(teacher, "Ask again")
    sees(teacher, "0 answered · 3 not yet", "Round 1", "Round 2")
    command(teacher, BY_KEY["reveal"])
    sees(bo, "Asked again", "Your first answer:")
    assert "Round 1" not in everything(bo)
    answer_all(asked, ann=RIGHT, bo=RIGHT, cy=RIGHT)
    sees(teacher, "the second time: 1.")
    command(teacher, BY_KEY["reveal"])
    for one in (bo, screen):
        sees(one, "Round 1", "Round 2", "the second time: 1.")
    command(teacher, BY_KEY["again"])
    sees(bo, "Asked again", "Your first answer:")


def test_the_question_disappears_when_the_teacher_leaves_the_lessons(asked: Class) -> None:
    bo = asked.students["bo"]
    command(bo, f"Answer {WRONG + 1}")
    sees(asked.teacher, "1 answered · 2 not yet")
    leave_lessons(asked.teacher)
    bo.wait_for(
        lambda v: not [c for c in list(v.mirror.commands.values()) if str(c["label"]).startswith("Answer")],
        WAIT,
    )


def test_keys_pause_the_class_and_start_exploring_in_each_links_look(
    classroom: Class,
) -> None:
    host, teacher, (di,) = classroom.host, classroom.teacher, classroom.come("di", query="lang=sl")
    for text in ("Učitelj je ustavil vse.", "Sledite učitelju"):
        command(teacher, BY_KEY["pause"])
        sees(di, text)
    ask(host.session, lambda s: s.change("theme", "dark"))
    command(teacher, BY_KEY["free"])
    assert ended(di)[0] == MOVED_CODE
    classroom.come("di", query="lang=sl")
    page = sessions_of(host)[classroom.number("di")].settings.page
    assert (page.language, page.theme) == ("sl", "light")
    command(teacher, BY_KEY["free"])
    teacher.wait_for(lambda _: not host.classroom.free, WAIT)


def test_answers_of_programs_are_counted_separately_and_can_be_excluded(classroom: Class) -> None:
    host, teacher, pages = classroom.host, classroom.teacher, classroom.come("ann", "bo")
    for page in pages:
        page.send({"type": HELLO})
        click(page, "1 ")
    programs = classroom.come(*(f"program {number}" for number in range(3)))
    for program in programs:
        click(program, "2 ")
    sees(teacher, "5 answered · 0 not yet", "votes: 5", "addresses: 1", "votes without a page: 3")
    click(teacher, "Leave out votes without a page")
    sees(teacher, "2 answered · 0 not yet", "votes without a page: 3")
    # A later answer from a program that disconnects at once is excluded, too.
    (late,) = classroom.come("late")
    click(late, "2 ")
    late.close()
    sees(teacher, "2 answered · 0 not yet", "votes without a page: 4")
    assert ask(host.session, lambda _: host.summaries()[0].asked[0].rounds[0].counts[:2]) == (2, 0)
    click(teacher, "Count votes without a page")
    sees(teacher, "6 answered · 0 not yet")
    click(teacher, "Leave out votes without a page")
    sees(teacher, "2 answered · 0 not yet")
    click(teacher, "Reveal to everybody")
    sees(pages[0], "The class said", "2 answered")
    assert host.lessons.walk.done.choice == 0
    # Neither a program nor a student's page is told about this.
    assert not any("without a page" in everything(one) for one in (*pages, *programs))
