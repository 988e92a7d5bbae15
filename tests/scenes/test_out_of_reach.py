"""A hand with a target out of reach comes to rest: every arm, gain and time step, with one or two persons."""

import numpy as np
import pytest

from controllers.kinematics import LONGEST_STEP, Array
from scenes.robots.start_search import arm_reach
from scenes.settings import RunSettings, changed, specs
from scenes.simulation import Simulation
from scenes.targets import HandTarget, LinkTarget, PairTarget, Target

SECONDS = 6.0
QUIET = 0.02
"""Largest step of q̇ of an arm at rest [rad/s]; a trembling arm has twice its top speed."""


def trembling(simulation: Simulation, target: Target, seconds: float = SECONDS) -> tuple[float, float]:
    """Largest steps of q̇ in the last third and in all of a run [rad/s]."""
    joints, steps = simulation.avoiding.joints, []
    before = simulation.velocities[joints].copy()
    for _ in range(round(seconds / simulation.settings.dt)):
        simulation.step(target)
        now = simulation.velocities[joints].copy()
        steps.append(float(np.abs(now - before).max()))
        before = now
    return max(steps[-len(steps) // 3 :]), max(steps[1:])


def beyond(simulation: Simulation, way: float, direction: Array) -> Array:
    """Place at `way` beyond the reach of the avoiding arm (3,) [m]."""
    simulation.kinematics.update(simulation.positions)
    arm = simulation.avoiding
    made = simulation.room.robots[simulation.room.arms.index(arm)]
    return simulation.kinematics.joint_point(arm.shoulder) + direction / np.linalg.norm(direction) * (
        arm_reach(made) + way
    )


def test_the_longest_step_is_that_of_the_settings() -> None:
    assert specs()["dt"].high == LONGEST_STEP


@pytest.mark.parametrize("robot", ["lwr", "panda", "ur5"])
@pytest.mark.parametrize(("gain", "dt"), [(2.0, 0.005), (10.0, 0.01), (20.0, 0.02)])
@pytest.mark.parametrize("way", [0.0, 0.3])
def test_the_hand_comes_to_rest(robot: str, gain: float, dt: float, way: float) -> None:
    settings = RunSettings(scene="solo", robot=robot, gain=gain, dt=dt, hand_speed=1.0)
    simulation = Simulation(settings, 1)
    late, _ = trembling(simulation, HandTarget(beyond(simulation, way, np.array([1.0, 0.1, 0.2]))))
    assert late < QUIET


def test_a_pose_out_of_reach_comes_to_rest() -> None:
    settings = RunSettings(scene="solo", task="pose", gain=10.0, hand_speed=1.0)
    simulation = Simulation(settings, 1)
    place = beyond(simulation, 0.15, np.array([1.0, 0.3, 0.4]))
    assert (
        trembling(
            simulation,
            HandTarget(place, simulation.kinematics.hand_pose(simulation.avoiding).rotation.copy()),
        )[0]
        < QUIET
    )


def test_the_largest_velocity_step_falls_with_dt() -> None:
    largest = []
    for dt in (0.005, 0.00125):
        simulation = Simulation(changed(RunSettings(scene="solo", hand_speed=1.0), "dt", dt), 1)
        largest.append(
            trembling(simulation, HandTarget(beyond(simulation, 0.3, np.array([1.0, 0.0, 0.2]))), 4.0)[1]
        )
    assert largest[0] < 0.5
    assert largest[1] < 0.4 * largest[0]


@pytest.mark.parametrize("link", [False, True])
def test_an_arm_pulled_out_of_reach_by_a_second_person_comes_to_rest(link: bool) -> None:
    """By its place, or by a pull at its forearm."""
    simulation = Simulation(RunSettings(hand_speed=1.0, gain=10.0), 1)
    away = beyond(simulation, 0.3, np.array([1.0, 1.0, 0.3]))
    held = LinkTarget(4, np.zeros(3), away) if link else HandTarget(away)
    assert trembling(simulation, PairTarget(None, held))[0] < QUIET
