"""Joints that hardly move the closest point do not oscillate while the others are at their bounds."""

from dataclasses import replace

import numpy as np
import pytest

from controllers.kinematics import Array
from scenes.headless import run
from scenes.settings import RunSettings, changed
from scenes.smoothness import ECHO

BEGUN = (
    -1.944, -0.922, 0.919, 0.709, -0.13, 1.506, 0.778, -1.363, -1.229, -0.19, -1.87, 0.829, 1.274, 0.471,
)  # fmt: skip
CROSSED = (
    1.721, -2.041, -0.206, -0.749, -2.165, -1.489, 0.468, 1.118, 1.136, 2.187, -1.226, 2.728, 1.264, 2.905,
)  # fmt: skip


def largest_steps(settings: RunSettings, seconds: float, start: Array | None, first: int = 0) -> list[float]:
    """Largest steps of q̇ of the avoiding arms, from step `first`, at dt and dt/4 [rad/s]."""
    largest = []
    for substeps in (1, 4):
        done = run(replace(settings, dt=settings.dt / substeps), seconds, start=start)
        tasks = done.simulation.roles.avoiders(settings.avoid)
        columns = np.r_[tuple(task.joints for task in tasks)]
        velocities = done.simulation.history.velocities(done.table)[:, columns]
        largest.append(float(np.abs(np.diff(velocities, axis=0))[first:].max()))
    return largest


def test_strict_priority_begins_without_a_jump() -> None:
    """It wants the full rate at once, far from the other arm; joint 4 has a lever of 1.2e-6 m/rad."""
    settings = changed(RunSettings(), "law", "strict_priority")
    done = run(settings, 0.02)
    assert abs(done.simulation.history.velocities(done.table)[0, 3]) < 1e-3
    assert largest_steps(settings, 0.3, None)[0] < 0.2


@pytest.mark.parametrize(
    ("changes", "start"),
    [
        ({"guided": "left", "avoid": "guided", "clip": "reach", "seed": 334, "one_sided": True}, BEGUN),
        (
            {"avoid": "free", "clip": "wave", "k": 20.0, "g": 20.14, "seed": 164, "n": 1.0, "v": 0.5727},
            CROSSED,
        ),
    ],
)
def test_velocity_steps_shrink_with_the_time_step(
    changes: dict[str, object], start: tuple[float, ...]
) -> None:
    """Two runs that once jumped by over 1 rad/s at every dt."""
    settings = RunSettings(scene="imitation")
    for key, value in changes.items():
        settings = changed(settings, key, value)
    coarse, fine = largest_steps(settings, 2.0, np.array(start), ECHO)
    assert coarse < 0.5
    assert fine < 0.5 * coarse
