"""Random far drags by every handle: with `world` nothing moved by a person enters an obstacle."""

import numpy as np
import pinocchio as pin
import pytest

from controllers import compiled
from scenes.settings import RigName
from scenes.simulation import Simulation
from scenes.surroundings import ball_surroundings, surroundings
from scenes.targets import BallTarget, HandTarget, JointTarget, LinkTarget, PairTarget, Target
from tests.scenes.helpers import given_settings, inside_limits

HANDLES = ("hand", "link", "elbow", "joints", "pose", "both")
"""Dragged handles: "joints" as by keys, "both" by two persons."""


@pytest.fixture(autouse=True, scope="module")
def machine_code() -> None:
    compiled.load_now()


def drawn_target(simulation: Simulation, handle: str, random: np.random.Generator) -> Target:
    arm = simulation.guided
    place, far = random.uniform([-0.9, -0.7, 0.0], [0.9, 0.7, 1.5], (2, 3))
    if handle == "hand":
        return HandTarget(place)
    if handle == "pose":
        return HandTarget(place, rotation=pin.exp3(random.normal(size=3)))
    if handle == "elbow":
        hand = simulation.kinematics.hand_pose(arm).translation.copy()
        return HandTarget(hand, elbow=place)
    if handle == "link":
        return LinkTarget(int(random.integers(2, arm.joints.stop - arm.joints.start)), np.zeros(3), place)
    if handle == "joints":
        model, j = simulation.room.model, arm.joints
        return JointTarget(random.uniform(model.lowerPositionLimit[j], model.upperPositionLimit[j]))
    return PairTarget(HandTarget(place), HandTarget(far))


def least_of_drag(scene: str, rig: RigName, robot: str, handle: str, seed: int, steps: int) -> float:
    """Least margin of both arms in a drag to two places [m]."""
    random = np.random.default_rng(seed)
    simulation = Simulation(
        given_settings(scene=scene, rig=rig, robot=robot, world=True, wmax=0.2 + 0.3 * random.random())
    )
    tasks = [surroundings(simulation.world, arm) for arm in simulation.room.arms]
    least = np.inf
    for _ in range(2):
        target = drawn_target(simulation, handle, random)
        for _ in range(steps // 2):
            simulation.step(target)
            simulation.kinematics.update(simulation.positions)
            least = min(least, *(task.margin().value for task in tasks if task))
            assert inside_limits(simulation)
    return least


@pytest.mark.parametrize("handle", HANDLES)
@pytest.mark.parametrize("rig", ["torso", "table"])
def test_no_handle_moves_an_arm_into_an_obstacle(rig: RigName, handle: str) -> None:
    scene = "hold" if handle == "both" or rig == "torso" else "master_slave"
    assert least_of_drag(scene, rig, "lwr", handle, 5, 800) > 0.0


@pytest.mark.thorough
@pytest.mark.parametrize("robot", ["lwr", "panda", "ur5"])
@pytest.mark.parametrize("scene", ["hold", "master_slave"])
@pytest.mark.parametrize("rig", ["torso", "table"])
def test_400_far_drags_never_enter_an_obstacle(rig: RigName, scene: str, robot: str) -> None:
    least = [least_of_drag(scene, rig, robot, HANDLES[i % len(HANDLES)], 100 + i, 1200) for i in range(34)]
    assert min(least) > 0.0


def least_of_ball(world: bool) -> float:
    simulation = Simulation(given_settings(scene="ball", world=world, wmax=0.5))
    task = ball_surroundings(simulation.world)
    assert task is not None
    base, least = simulation.room.rig.bases[0].translation, np.inf
    for _ in range(800):
        simulation.step(BallTarget(base + np.array([0.0, 0.0, 0.15])))
        simulation.kinematics.update(simulation.positions)
        least = min(least, task.margin().value)
        assert inside_limits(simulation)
    return least


def test_a_ball_stops_at_the_pedestal() -> None:
    assert least_of_ball(world=False) < -0.02
    assert least_of_ball(world=True) > 0.02
