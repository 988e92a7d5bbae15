"""Panels beside an open lesson: right controls, plots, line of contact, boxes for words."""

import re
from unittest.mock import MagicMock

import pytest
import viser

from app.features.lessons.bookmark import Phase
from app.features.lessons.lesson import Step
from app.features.lessons.library import BELIEFS
from app.features.lessons.loading import load_lessons
from app.features.lessons.panel.answer_boxes import takes_reason
from app.features.lessons.panel.lesson_panel import PLOTS, LessonPanel, hidden_beside
from app.features.lessons.session.lesson_session import LessonSession
from app.features.lessons.walkthrough import Walkthrough
from app.session.frame import freeze
from app.session.session import Session
from app.settings import Settings
from app.stage.contact_view import ClosestLine
from app.text.templates import macros
from tests.app.features.lessons.helpers import our_book, to_challenge

BOOK = our_book()


def place_of(name: str, step: str) -> tuple[int, int]:
    number = BOOK.index(name)
    return number, [one.id for one in BOOK.lessons[number].steps].index(step)


def at(name: str, step: str) -> tuple[Session, LessonSession]:
    session = Session(Settings())
    run = LessonSession(session, BOOK)
    run.enter(*place_of(name, step))
    return session, run


@pytest.mark.parametrize("narrow", [False, True])
def test_the_controls_are_folded_until_a_challenge_needs_them(narrow: bool) -> None:
    session, run = at("redundancy", "swing")
    gui = MagicMock()
    panel = LessonPanel(gui, run, 340.0, True, True, narrow)
    panel.show(freeze(session, 0.0))
    assert gui.main_panel.minimize.call_count == 1 and not gui.main_panel.expand.called
    to_challenge(run.walk)
    run.version += 1
    panel.show(freeze(session, 1.0))
    assert gui.main_panel.expand.call_count == 1, "the challenge's settings are only in the right panel"


def test_the_controls_stay_folded_if_the_lesson_has_the_controls() -> None:
    number = BOOK.index("drift")
    index = next(i for i, step in enumerate(BOOK.lessons[number].steps) if step.controls)
    session, run = at("drift", BOOK.lessons[number].steps[index].id)
    to_challenge(run.walk)
    gui = MagicMock()
    LessonPanel(gui, run, 340.0, True, True).show(freeze(session, 0.0))
    assert gui.main_panel.minimize.called and not gui.main_panel.expand.called


def test_plots_are_hidden_in_steps_without_a_run() -> None:
    beliefs = Walkthrough(load_lessons(BELIEFS))
    assert beliefs.step.concept and PLOTS in hidden_beside(beliefs.view())
    walk = Walkthrough(BOOK)
    assert walk.phase is Phase.PREDICT and PLOTS in hidden_beside(walk.view())
    walk.phase = Phase.DO
    assert PLOTS not in hidden_beside(walk.view())


def test_the_line_of_contact_hides_lambda_until_the_run_begins() -> None:
    session, run = at("strict-priority", "always_first")
    assert run.withholds
    assert session.simulation.sample().activation == pytest.approx(1.0), (
        "strict priority avoids at any distance"
    )
    scene = MagicMock(spec=viser.SceneApi)
    line = ClosestLine(scene)
    line.dress(session.settings.page)
    drawn = scene.add_line_segments.return_value
    line.withheld = run.withholds
    line.show(freeze(session, 0.0))
    assert drawn.thickness == 3.0
    run.walk.choose(0)
    assert run.walk.phase is Phase.DO and run.withholds, "λ is hidden after the answer, before the run"
    session.simulation.step(None)
    assert not run.withholds
    line.withheld = run.withholds
    line.show(freeze(session, 0.1))
    assert drawn.thickness == 10.0


def test_at_most_one_box_for_words_is_shown() -> None:
    steps = [step for lesson in BOOK.lessons for step in lesson.steps]
    asked, plain = (
        next(s for s in steps if (s.question is not None) is with_question) for with_question in (True, False)
    )
    phases: dict[bool, list[Phase]] = {True: [Phase.PREDICT, Phase.DO], False: []}
    for step in (asked, plain):
        one: Step = step
        assert [phase for phase in Phase if takes_reason(one, phase)] == phases[one.question is not None]


def test_the_list_has_one_sentence_per_lesson() -> None:
    _, run = at("redundancy", "freedom")
    entries = [*run.walk.entries()]
    for entry in entries:
        assert not re.search(r"[.!?]\s", entry.promise), entry.promise
    made = str(macros("features/lessons/panel/lesson_list.html").lessons(entries, {}))
    words = re.sub(r"<style.*?</style>|<svg.*?</svg>|<[^>]+>", " ", made, flags=re.DOTALL).split()
    assert len(words) <= 330
