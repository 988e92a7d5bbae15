"""Lesson cases of the core's `test_camera_follow.py`."""

import pytest

from app.features.lessons.lesson import Step
from app.features.lessons.outcomes import decisive_moment
from app.features.lessons.panel.lesson_camera import lesson_view
from app.features.lessons.reference_runs import begin_reference_run, person_of
from app.features.measures.evidence import Evidence
from scenes.simulation import Simulation
from tests.app.features.lessons.helpers import our_book
from tests.app.page.test_camera_follow import watch

pytestmark = pytest.mark.slow


LESSONS = our_book().lessons


@pytest.mark.parametrize(
    "step",
    [pytest.param(step, id=f"{lesson.number}-{step.id}") for lesson in LESSONS for step in lesson.steps],
)
def test_every_step_of_a_lesson(step: Step) -> None:
    simulation = Simulation(step.setup.run)
    begin_reference_run(simulation, step.setup)
    source = simulation.source() if step.yours else person_of(simulation, step.setup)
    view = lambda: lesson_view(simulation, step.camera)  # noqa: E731
    moment = lambda: decisive_moment(step.measurements, Evidence(simulation))  # noqa: E731
    assert watch(simulation, source, step.setup.seconds, view, True, moment) == []
