"""Nothing that a person of a class wrote acts on a page of the lecture."""

import time
from collections.abc import Iterator
from itertools import product

import pytest

from app.features.lecture.class_report import class_report_bytes
from app.features.lecture.class_summary import AskedQuestion, ClassSummary, HandIn
from app.features.lecture.classroom import Poll
from app.features.lecture.classroom_html import join_html, mine_html, overlay_html, poll_html, tied_html
from app.features.lecture.overlays import screen_html
from app.features.lecture.presenter import Station
from app.features.lecture.student_work import BoardRow, Cell
from app.features.lessons.outcomes import AnswerVerdict
from app.features.lessons.progress import Progress, to_json
from app.features.lessons.tally import Ballot, Tally
from app.web.address import Address
from tests.app.features.test_templates import (
    ALL_TEMPLATES,
    NASTY,
    Macros,
    Surfaces,
    assert_harmless,
    filled,
    nasty_lesson,
    views,
)


def poll() -> Poll:
    lesson = nasty_lesson()
    verdict = AnswerVerdict(True, NASTY, NASTY, (NASTY,))
    tally = Tally((1, 1), 1, 2)
    return Poll(
        question=(lesson.id, "a"),
        choices=(NASTY, NASTY),
        tally=tally,
        open=False,
        revealed=True,
        outcome=(NASTY,),
        right=0,
        verdicts=(verdict, verdict),
        staged=(0, 1),
    )


def class_report() -> str:
    lesson, progress = nasty_lesson(), Progress()
    asked = next(step for step in lesson.steps if step.question is not None)
    assert asked.question is not None
    done = progress.at(lesson.id, asked.id)
    done.choice, done.words, done.because = 0, NASTY, NASTY
    tally = Tally((1,) * len(asked.question.choices), 0, 2)
    question = AskedQuestion((lesson.id, asked.id), (tally, tally))
    summary = ClassSummary(time.time(), 2, (question,), {(lesson.id, asked.id): 1}, (HandIn(NASTY, to_json(progress)),))
    return class_report_bytes(summary, (lesson,), "en").decode()


def screens() -> Iterator[str]:
    for station, panels in product(Station, (True, False)):
        yield from (screen_html(station, view, one, 7, panels, (NASTY,), -0.001) for view in views() for one in (poll(), None))


MACROS: Macros = {
    "features/lecture/board.html": [
        ("board", ([BoardRow(NASTY, (Cell(True, 2), Cell(here=True, minutes=3)), 2)], 2)),
        ("run", (NASTY, NASTY)),
        ("work", (NASTY, NASTY, NASTY, [NASTY], 0, "", [NASTY])),
    ],
}

SURFACES: Surfaces = {
    **filled(MACROS),
    "features/lecture/invitation.html": lambda: iter((join_html(Address(NASTY, False)), overlay_html(Address(NASTY, True)))),
    "features/lecture/poll.html": lambda: iter((poll_html(poll()), tied_html(poll()), mine_html(poll(), Ballot(0), Ballot(1)))),
    "features/lecture/screen.html": screens,
    "features/lecture/class_report.html": class_report,
    "features/lecture/tally.html": lambda: poll_html(poll(), live=True),
}
"""Template → pages and pieces that are made with it, of the worst that a name or a lesson may hold."""


def test_every_template_of_the_lecture_is_tried() -> None:
    assert sorted(SURFACES) == [name for name in ALL_TEMPLATES if name.startswith("features/lecture/")]


@pytest.mark.parametrize("name", SURFACES)
def test_nothing_that_a_person_wrote_acts_on_a_page(name: str) -> None:
    assert_harmless(SURFACES[name])
