"""The class's templates escape texts of lessons and students."""

import time

import pytest

from app.features.classroom.class_report import class_report_bytes
from app.features.classroom.class_summary import AskedQuestion, ClassSummary, HandIn
from app.features.classroom.classroom_html import mine_html, poll_html, tied_html
from app.features.lessons.progress import Progress, to_json
from app.features.lessons.tally import Ballot, Tally
from tests.app.features.classroom.nasty_poll import poll
from tests.app.features.test_templates import ALL_TEMPLATES, NASTY, Surfaces, assert_harmless, nasty_lesson


def class_report() -> str:
    lesson, progress = nasty_lesson(), Progress()
    asked = next(step for step in lesson.steps if step.question is not None)
    assert asked.question is not None
    done = progress.at(lesson.id, asked.id)
    done.choice, done.words, done.because = 0, NASTY, NASTY
    tally = Tally((1,) * len(asked.question.choices), 0, 2)
    question = AskedQuestion((lesson.id, asked.id), (tally, tally))
    summary = ClassSummary(
        time.time(), 2, (question,), {(lesson.id, asked.id): 1}, (HandIn(NASTY, to_json(progress)),)
    )
    return class_report_bytes(summary, (lesson,), "en").decode()


SURFACES: Surfaces = {
    "features/classroom/poll.html": lambda: iter(
        (poll_html(poll()), tied_html(poll()), mine_html(poll(), Ballot(0), Ballot(1)))
    ),
    "features/classroom/class_report.html": class_report,
    "features/classroom/tally.html": lambda: poll_html(poll(), live=True),
}
"""Template → pages and fragments made from it with hostile names and lesson texts."""


def test_every_template_of_the_class_is_listed() -> None:
    assert sorted(SURFACES) == [name for name in ALL_TEMPLATES if name.startswith("features/classroom/")]


@pytest.mark.parametrize("name", SURFACES)
def test_nothing_that_a_person_wrote_acts_on_a_page(name: str) -> None:
    assert_harmless(SURFACES[name])
