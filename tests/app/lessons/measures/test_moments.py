"""When a measure of a run stands as it does, and which moment a step of a lesson is about."""

import numpy as np
import pytest

from app.lessons.evidence import Evidence
from app.lessons.lesson import Step
from app.lessons.measures.quantity import QUANTITIES, At, measure, moment
from app.lessons.outcomes import AT_END, decisive_moment
from app.lessons.reference_runs import simulated
from scenes.history import COLUMN
from tests.app.lessons.helpers import our_book

AT_THE_END = {
    *("drift.open_loop", "drift.closed_loop", "strict-priority.always_first", "lambda.tail", "smooth.rest", "smooth.stand_off"),
    *("stability.elbow_or_hand", "stability.needed", "stability.without", "limits.fast", "limits.tie"),
}
"""Steps whose question is about how a run ends; and the other steps have a moment, unless the student moves in them."""


def steps() -> dict[str, Step]:
    return {f"{lesson.id}.{step.id}": step for lesson in our_book().lessons for step in lesson.steps}


@pytest.mark.parametrize("name", steps())
def test_every_step_has_its_moment_or_is_about_its_end(name: str) -> None:
    step = steps()[name]
    if step.setup.input.kind in ("yours", "kept"):
        return
    evidence = Evidence(simulated(step.setup), step.setup.seconds)
    mark = decisive_moment(step.measurements, evidence)
    assert (mark is None) == (name in AT_THE_END), mark
    if mark is None:
        return
    assert 0.0 < mark.time < step.setup.seconds - AT_END
    # A run that is cut off right after the moment has the same value, if that is one of extremes or of crossings.
    named = next(m for m in step.measurements if moment(evidence, m.name, m.parameters) is not None)
    if named.name in ("smallest_distance", "distance_margin", "velocity_step", "first_jump", "switch_pull", "loss_rate"):
        half = 1.5 * evidence.settings.dt
        cut = Evidence(simulated(step.setup), mark.time + half)
        before = Evidence(simulated(step.setup), mark.time - half)
        assert measure(cut, named.name, named.parameters) == measure(evidence, named.name, named.parameters)
        assert measure(before, named.name, named.parameters) != measure(evidence, named.name, named.parameters)


def test_a_moment_is_the_time_after_the_step_that_decides() -> None:
    step = steps()["hold.push"]
    evidence = Evidence(simulated(step.setup), step.setup.seconds)
    row = int(evidence.column("d").argmin())
    assert moment(evidence, "smallest_distance") == pytest.approx(evidence.table[row, COLUMN["t"]] + evidence.settings.dt)
    assert moment(evidence, "distance_at", (("time", 1.5),)) == pytest.approx(1.5 + evidence.settings.dt)
    # What no run tells, or only the whole run, has none.
    assert moment(evidence, "pair_switches") is None and moment(evidence, "distance_at", (("time", 50.0),)) is None


def test_the_row_of_a_measure_holds_its_value() -> None:
    evidence = Evidence(simulated(steps()["master-slave.copy"].setup), 12.0)
    speeds = np.abs(evidence.velocities)
    names = ("reached_speed", "speed_share", "largest_joint_error", "largest_approach")
    found = {name: at.row for name in names if isinstance(at := QUANTITIES[name].function(evidence), At)}
    assert speeds[found["reached_speed"]].max() == measure(evidence, "reached_speed")
    assert (speeds / evidence.room.model.velocityLimit[evidence.arm.joints])[found["speed_share"]].max() == measure(
        evidence, "speed_share"
    )
    errors = np.linalg.norm(evidence.desired - evidence.positions[:, evidence.arm.joints], axis=1)
    assert errors[found["largest_joint_error"]] == measure(evidence, "largest_joint_error")
    assert evidence.column("w")[found["largest_approach"]] == measure(evidence, "largest_approach")
