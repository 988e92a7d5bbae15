"""The check that the contrast run of a wrong answer differs visibly from the question's run."""

import re
from dataclasses import replace

from app.features.lessons.check import Walk, check_lesson
from app.features.lessons.contrasts import contrast_size
from app.features.lessons.lesson import Lesson, LessonBook
from app.features.lessons.reference_runs import simulated
from app.features.lessons.runs import Input, Setup
from tests.app.features.lessons.helpers import our_book
from tests.approved import Approve

BOOK = our_book()


def first_answer(setup: Setup | None = None) -> Walk:
    """Path of the first wrong answer of lesson 1.1; `setup`: replaces its contrast run."""
    lesson = BOOK.lessons[BOOK.index("redundancy")]
    step = lesson.steps[0]
    assert step.question is not None
    first, *others = step.question.choices
    choices = (replace(first, why=setup or first.why), *others)
    changed: Lesson = replace(
        lesson,
        steps=(replace(step, question=replace(step.question, choices=choices), challenge=None, trials=()),),
    )
    walks = check_lesson(LessonBook((changed,), ()), changed)
    return next(walk for walk in walks if walk.kind == "answer")


def test_lesson_one_shows_the_elbow_at_rest_beside_the_swing() -> None:
    step = BOOK.lessons[BOOK.index("redundancy")].steps[0]
    assert step.question is not None
    rest = step.question.choices[0].why
    assert rest is not None and rest.input == Input("none")
    size = contrast_size(simulated(step.setup), simulated(rest), (4.0, 4.0))
    assert size.moves_otherwise and size.turn > 0.5


def test_the_check_refuses_a_contrast_run_like_the_questions_run(approve: Approve) -> None:
    assert first_answer().ok
    step = BOOK.lessons[BOOK.index("redundancy")].steps[0]
    nearly = replace(step.setup, input=Input("script", "elbow_to", (("angle", 0.8), ("period", 8.0))))
    walk = first_answer(nearly)
    assert not walk.ok
    # The last number depends on rounding.
    approve("nearly.txt", re.sub(r"\S+ %$", "… %", walk.text) + "\n")
