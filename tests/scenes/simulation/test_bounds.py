"""How the bounds are met in a whole run: whatever is chosen they hold, and what it keeps is kept."""

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from controllers.choices import BoundsTreatment
from scenes.history import COLUMN
from scenes.settings import LawSettings, RunSettings, SceneName
from scenes.simulation import Simulation
from scenes.targets import HandTarget

FAST = RunSettings(gain=20.0, hand_speed=1.0, limit_gain=2.0, law=LawSettings(nominal_velocity=1.0, critical_distance=0.3))
TREATMENTS: tuple[BoundsTreatment, ...] = get_args(BoundsTreatment)


def pushed(treatment: BoundsTreatment, steps: int = 500, scene: SceneName = "hold") -> Simulation:
    """A run in which the guided hand goes to the other one, at once and fast."""
    simulation = Simulation(replace(FAST, bounds=treatment, scene=scene))
    place = simulation.kinematics.hand_pose(simulation.avoiding).translation.copy()
    for _ in range(steps):
        simulation.step(HandTarget(place))
    return simulation


@pytest.mark.parametrize("scene", ["hold", "master_slave"])
@pytest.mark.parametrize("treatment", TREATMENTS)
def test_no_treatment_exceeds_a_bound(treatment: BoundsTreatment, scene: SceneName) -> None:
    simulation = pushed(treatment, scene=scene)
    table, model = simulation.history.table(), simulation.room.model
    q, dq = simulation.history.positions(table), simulation.history.velocities(table)
    assert (q >= model.lowerPositionLimit - 1e-9).all() and (q <= model.upperPositionLimit + 1e-9).all()
    assert (np.abs(dq) <= model.velocityLimit + 1e-9).all()


def test_what_each_treatment_keeps_of_a_laws_velocity() -> None:
    """The distance rate; the direction; the distance rate and, as far as the joints go, the hand's velocity."""
    simulation = pushed("distance", 60)
    group = simulation._groups[0]
    row = simulation.detector.detect("soft", 100.0).row[group.joints]
    J = simulation.roles.task.task_jacobian
    assert J is not None
    rng = np.random.default_rng(0)
    better = 0
    for _ in range(40):
        wanted = rng.uniform(-1.3, 1.3, 7) * simulation.room.model.velocityLimit[group.joints]
        kept, short, both = (group.bounded(row, wanted, treatment) for treatment in TREATMENTS)
        assert all(group.box.contains(bounded.velocities) for bounded in (kept, short, both))
        assert float(row @ both.velocities) == pytest.approx(float(row @ kept.velocities), abs=1e-7)
        assert_parallel(short.velocities, wanted)
        lost = [float(np.linalg.norm(J @ (bounded.velocities - wanted))) for bounded in (kept, both)]
        assert lost[1] <= lost[0] + 1e-7
        better += lost[1] < 1e-7 < 1e-3 < lost[0]
    assert better > 4


def assert_parallel(one: np.ndarray, other: np.ndarray) -> None:
    """The same direction."""
    assert float(one @ other) == pytest.approx(float(np.linalg.norm(one) * np.linalg.norm(other)), rel=1e-12)


def test_the_same_distance_is_kept_whatever_becomes_of_the_hand() -> None:
    """Saturation in the null space comes after the distance rate: no nearer than by default, and the hand is no farther off."""
    default, saturating = (pushed(treatment, 800).history.table() for treatment in ("distance", "null_space"))
    d, e = COLUMN["d"], COLUMN["e2"]
    assert saturating[:, d].min() > default[:, d].min() - 1e-3
    assert saturating[:, e].mean() < default[:, e].mean()
