"""One student's work on the projector."""

from app.features.lecture.overlays import work_html
from app.features.lecture.presenter import ShownWork
from app.features.lessons.progress import StepProgress
from app.plots.curve_chart import COLUMNS
from tests.app.features.lessons.helpers import our_book

BOOK = our_book()


def test_one_students_work_is_shown_without_a_name() -> None:
    lesson = BOOK.lessons[3]
    index, step = next((i, step) for i, step in enumerate(lesson.steps) if step.drawing is not None)
    place = lesson.id, step.id
    curve = (0.5,) * COLUMNS
    shown = work_html(ShownWork(place, StepProgress(choice=1, drawing=curve)), BOOK)
    assert (
        "One of you" in shown
        and f"Lesson 4 · step {index + 1}" in shown
        and "<figure" in shown
        and shown.count('class="mine"') == 1
    )
    assert "<figure" not in work_html(ShownWork(place, StepProgress(choice=1)), BOOK)
    works = [
        ShownWork(place, done)
        for done in (StepProgress(), StepProgress(choice=1), StepProgress(drawing=curve))
    ]
    assert ["Not answered yet." in work_html(work, BOOK) for work in works] == [True, False, False]
    run = work_html(ShownWork(place, StepProgress(), run=True), BOOK)
    assert "at-run" in run and step.title in run
    assert "Lesson" not in work_html(ShownWork(("no", "lesson"), StepProgress(), run=True), BOOK)
