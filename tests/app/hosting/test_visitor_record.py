"""What a visitor comes back to by a link."""

import pytest

from app.features.lessons.loading import load_lessons
from app.features.lessons.session.lesson_session import LessonSession
from app.hosting.visitor import open_link
from app.hosting.visitor_record import VisitorRecord
from app.session.session import Session
from app.settings import Settings


@pytest.mark.parametrize(("lesson", "open"), [("3", True), ("4", False)])
def test_by_the_same_lesson_link_a_tab_is_where_it_was_and_by_another_one_keeps_its_progress(lesson: str, open: bool) -> None:
    book = load_lessons()
    run = LessonSession(Session(Settings()), book)
    run.enter(2)
    run.walk.choose(1)
    place = run.walk.lesson.id, run.walk.step.id
    back = LessonSession(Session(Settings()), book)
    assert open_link(back, {"lesson": lesson}, VisitorRecord({"lesson": "3"}, Settings(), run.saved())) == ()
    assert back.walk.done_in(*place).choice == 1 and ((back.walk.lesson.id, back.walk.step.id) == place) == open
