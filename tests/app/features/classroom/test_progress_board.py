"""The progress board, without a page: invented names, steps, stuck students; and the pace."""

import json
from dataclasses import replace

import pytest

from app.features.classroom.student_work import NAMES, STUCK, Cell, ProgressBoard
from app.features.lessons.bookmark import Bookmark, OpenSteps, open_steps_from_text
from app.features.lessons.lesson import Lesson
from app.features.lessons.session.lesson_actions import Choose, Enter, GoTo, Press
from app.features.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.settings import Settings
from controllers.errors import BadSetting
from tests.app.features.lessons.helpers import our_book
from tests.approved import Approve

BOOK = our_book()
LESSON = BOOK.lessons[0]
BEGIN = Bookmark(BOOK)


def progress(lesson: Lesson, step: int, **done: object) -> str:
    name = lesson.steps[step].id
    entry = {"lesson": lesson.id, "step": name, **done}
    return json.dumps({"version": 1, "lesson": lesson.id, "step": name, "phase": "do", "steps": [entry]})


def test_drawn_names_are_unique_and_stay() -> None:
    board = ProgressBoard()
    students = [f"student {i}" for i in range(2 * len(NAMES) + 5)]
    names = [board.name_of(student) for student in students]
    assert len(set(names)) == len(names) and set(NAMES) <= set(names) and names != sorted(names)
    assert [board.name_of(student) for student in students] == names and board.student_of(
        names[7]
    ) == students[7]
    # A class resumed after a crash keeps its names and draws none of them again.
    later = ProgressBoard()
    later.names = dict(board.names)
    more = [later.name_of(f"late {i}") for i in range(len(NAMES))]
    assert later.names.items() >= board.names.items() and not set(more) & set(names)
    assert later.student_of("nobody") is None


def test_a_row_shows_passed_and_tried_steps_and_the_stuck_one() -> None:
    board = ProgressBoard()

    def row(now: float) -> tuple[Cell, ...]:
        (one,) = board.rows({"ann": 1}, BEGIN, now)
        assert one.name == board.name_of("ann") and one.lesson == 0
        return one.cells

    fresh = (False, 0, False, 0)
    assert row(10.0) == ((False, 0, True, 0), fresh, fresh)
    assert row(10.0 + STUCK)[0] == (False, 0, True, 3)
    board.note("ann", progress(LESSON, 0, attempts=2, choice=1), 200.0)
    assert row(201.0)[0] == (False, 2, True, 0)
    # Another attempt is not progress; a passed challenge is.
    board.note("ann", progress(LESSON, 0, attempts=3, choice=1), 200.0 + STUCK)
    assert row(201.0 + STUCK)[0] == (False, 3, True, 3)
    board.note("ann", progress(LESSON, 0, attempts=4, choice=1, passed=True), 500.0)
    assert row(500.0 + 2 * STUCK)[0] == (True, 4, True, 0)
    board.note("ann", progress(BOOK.lessons[3], 0), 600.0)
    assert board.rows({"ann": 1}, BEGIN, 601.0)[0].lesson == 4
    board.note("ann", "no progress at all", 700.0)
    assert row(701.0)[1:] == (fresh, fresh)


@pytest.mark.parametrize(
    ("text", "steps"),
    [("2", (1, 1)), (" 2 - 3 ", (1, 2)), ("1–3", (0, 2)), ("2-", (1, 1)), ("", None), ("  ", None)],
)
def test_a_pace_is_typed_as_numbers_of_steps(text: str, steps: tuple[int, int] | None) -> None:
    assert open_steps_from_text(text, LESSON) == (None if steps is None else OpenSteps(LESSON.id, 1, *steps))


@pytest.mark.parametrize("text", ["0", "4", "3-2", "2-9", "two", "-2", "2-3-4", "٢", "1" * 1000])
def test_an_invalid_pace_is_refused_with_the_valid_forms(text: str, approve: Approve) -> None:
    said: list[str] = []
    for lesson in (LESSON, replace(LESSON, steps=LESSON.steps[:1])):
        with pytest.raises(BadSetting) as refused:
            open_steps_from_text(text, lesson)
        said.append(str(refused.value))
    approve("refused steps.txt", "\n".join(said) + "\n")


def test_a_closed_step_is_refused_by_every_action(approve: Approve) -> None:
    session = Session(Settings())
    lessons, notices = LessonSession(session, BOOK), session.notices
    lessons.enter(0, 0)
    lessons.pace = OpenSteps(LESSON.id, 1, 1, 2)

    def where() -> tuple[str, int]:
        lessons.decide()
        return lessons.walk.lesson.id, lessons.walk.step_index

    assert where() == (LESSON.id, 1)
    approve("step that is not open.txt", "\n".join(notices.pop()) + "\n")
    for asked in (GoTo(None, 0), Press("back"), GoTo(3, 0), Enter(5)):
        lessons.act(asked)
        # A closed step also takes no answer before the next frame.
        lessons.act(Choose(0))
        assert lessons.walk.done_in(LESSON.id, LESSON.steps[0].id).untouched
        lessons.act(Press("reset"))
        assert where() == (LESSON.id, 1) and notices.pop()[0].startswith("Your teacher"), asked
    lessons.act(GoTo(None, 2))
    assert where() == (LESSON.id, 2) and not notices
    lessons.act(GoTo(None, 0))
    assert where() == (LESSON.id, 2) and notices.pop(), "a student in an open step stays there"
    lessons.pace = OpenSteps(LESSON.id, 1, 1, 1)
    assert where() == (LESSON.id, 1)
    lessons.act(Choose(0))
    lessons.pace = None
    lessons.act(GoTo(3, 0))
    assert where() == (BOOK.lessons[3].id, 0)
