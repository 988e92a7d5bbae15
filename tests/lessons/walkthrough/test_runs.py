"""The run that a page makes for a step of a lesson."""

import numpy as np
import pytest

from app.lessons.lesson import LessonBook
from app.lessons.phases import Phase
from app.lessons.walkthrough import Walkthrough
from app.settings import PageSettings, Settings
from controllers.errors import BadSetting
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from tests.lessons.helpers import our_book, run_out


def test_the_run_has_the_lessons_settings_and_the_pages_own_look(walk: Walkthrough) -> None:
    before = Settings(RunSettings(scene="hold", gain=7.0), PageSettings(theme="dark"))
    after = walk.settings(before)
    assert after.page.theme == "dark"
    assert after.run.scene == "ball" and after.run.law.order == 2.0 and after.run.gain == RunSettings().gain


def test_every_run_of_every_lesson_can_be_begun_as_a_page_does_it() -> None:
    walk = Walkthrough(our_book())
    for i, lesson in enumerate(walk.book.lessons):
        for j, step in enumerate(lesson.steps):
            walk.go(i, j)
            if step.question:
                walk.choose(0)
            simulation = Simulation(walk.settings().run, 100)
            simulation.reset(walk.start(simulation))
            assert all(value is None or np.isfinite(value) for _, value in walk.live(simulation))
            person = walk.target_source(simulation)
            for _ in range(3):
                simulation.step(person.target(simulation.time))
            live = walk.live(simulation)
            assert len(live) == len(step.numbers) and all(m.text(value) for m, value in live)
            assert all(value is not None for _, value in live)


def test_a_fresh_run_is_asked_for_when_one_has_to_begin(walk: Walkthrough) -> None:
    turn = walk.run_id
    walk.choose(0)
    assert walk.run_id == turn + 1
    run_out(walk)
    assert walk.phase is Phase.OBSERVE and walk.run_id == turn + 1
    walk.next()
    assert walk.phase is Phase.EXPLAIN and walk.run_id == turn + 1
    walk.next()
    assert walk.phase is Phase.CHALLENGE and walk.run_id == turn + 2
    walk.next()
    walk.reset()
    assert walk.run_id == turn + 4


def test_going_to_a_step_that_is_not_there_is_refused(walk: Walkthrough) -> None:
    before = walk.view()
    for lesson, step in (("none", 0), (7, 0), (-1, 0), ("small", 2), ("small", -1)):
        with pytest.raises(BadSetting):
            walk.go(lesson, step)
    assert walk.view() == before
    with pytest.raises(BadSetting, match="no lesson"):
        Walkthrough(LessonBook((), ()))
