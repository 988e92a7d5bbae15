"""An arm on its null-space motions: the hand stays, going back undoes, limits hold, and the simulated arm follows."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from controllers.kinematics import Array
from scenes.null_motions import MOTIONS, NullMotions
from scenes.simulation import Simulation
from scenes.targets import JointTarget
from tests.scenes.helpers import given_settings


def alone(**changes: object) -> Simulation:
    return Simulation(given_settings(scene="solo", path="stay", task="position", **changes), 10)


def at(simulation: Simulation, joints: Array) -> tuple[Array, Array]:
    """Where hand and elbow are with the arm's joints (7,) [rad]."""
    q = simulation.positions.copy()
    q[simulation.guided.joints] = joints
    simulation.kinematics.update(q)
    kinematics, arm = simulation.kinematics, simulation.guided
    return kinematics.hand_pose(arm).translation.copy(), kinematics.joint_point(arm.elbow)


@pytest.mark.parametrize("motion", range(MOTIONS))
@pytest.mark.parametrize("way", [0.9, -0.9])
def test_a_motion_leaves_the_hand_and_going_back_undoes_it(motion: int, way: float) -> None:
    simulation = alone()
    start = simulation.positions[simulation.guided.joints].copy()
    motions = NullMotions(simulation.room, simulation.guided, simulation.positions)
    there = motions.go(motion, way)
    assert np.linalg.norm(there - start) > 0.7
    hand, elbow = at(simulation, there)
    hand_before, elbow_before = at(simulation, start)
    assert np.linalg.norm(hand - hand_before) < 1e-6
    if motion == 0:
        assert np.linalg.norm(elbow - elbow_before) > 0.08
    assert_allclose(motions.go(motion, 0.0), start, atol=1e-6)


def test_a_motion_ends_at_a_joint_limit_and_comes_back_from_there() -> None:
    simulation = alone()
    arm, model = simulation.guided, simulation.room.model
    motions = NullMotions(simulation.room, arm, simulation.positions)
    there = motions.go(2, 30.0)
    low, high = model.lowerPositionLimit[arm.joints], model.upperPositionLimit[arm.joints]
    assert (there >= low).all() and (there <= high).all()
    assert np.minimum(there - low, high - there).min() < 0.02 and motions.gone[2] < 30.0
    assert np.linalg.norm(motions.go(2, 0.0) - simulation.positions[arm.joints]) < 1e-3


@pytest.mark.parametrize(("gain", "dt"), [(2.0, 0.005), (10.0, 0.005), (0.0, 0.02)])
def test_the_arm_follows_a_slider_that_jumps_while_its_hand_stays(gain: float, dt: float) -> None:
    simulation = alone(k=gain, dt=dt)
    hand, _ = at(simulation, simulation.positions[simulation.guided.joints])
    motions = NullMotions(simulation.room, simulation.guided, simulation.positions)
    for motion, way in enumerate((0.9, 0.8, -0.7, 0.8)):
        target = JointTarget(motions.go(motion, way))
        for _ in range(round(3.0 / dt)):
            simulation.step(target)
            assert np.linalg.norm(at(simulation, simulation.positions[simulation.guided.joints])[0] - hand) < 5e-4
    assert_allclose(simulation.positions[simulation.guided.joints], motions.joints, atol=2e-3)
