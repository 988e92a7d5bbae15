"""A bookmark goes through a whole book, step by step, there and back."""

import pytest

from app.lessons.bookmark import Bookmark
from app.lessons.loading import load_lessons
from controllers.errors import BadSetting

BOOK = load_lessons()
ALL = [(i, j) for i, lesson in enumerate(BOOK.lessons) for j in range(len(lesson.steps))]


def test_there_and_back() -> None:
    way = [Bookmark(BOOK)]
    while (after := way[-1].after()) is not None:
        way.append(after)
    assert [(at.lesson_index, at.step_index) for at in way] == ALL
    assert [at.step for at in way] == [step for lesson in BOOK.lessons for step in lesson.steps]
    assert way[0].before() is None
    assert [at.before() for at in way[1:]] == way[:-1]


def test_a_step_is_found_by_place_and_by_name() -> None:
    at = Bookmark(BOOK)
    for i, j in ALL:
        lesson = BOOK.lessons[i]
        there = Bookmark(BOOK, i, j)
        assert at.at(i, j) == at.at(lesson.id, j) == at.of(lesson.id, lesson.steps[j].id) == there
    assert at.of("no such lesson", "") == at.of(BOOK.lessons[1].id, "no such step") == Bookmark(BOOK)


@pytest.mark.parametrize(("lesson", "step"), [(-1, 0), (len(BOOK.lessons), 0), (0, -1), (0, 99), ("no such lesson", 0)])
def test_what_is_not_there_is_named(lesson: int | str, step: int) -> None:
    with pytest.raises(BadSetting, match="There is no"):
        Bookmark(BOOK).at(lesson, step)
