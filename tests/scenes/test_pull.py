"""A pull at any point of any link: the point goes there, inside the stops, no faster than a person, and calm out of reach."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from controllers.kinematics import Array
from scenes.guide import pull
from scenes.settings import RobotName, RunSettings, SceneName
from scenes.simulation import Simulation
from scenes.targets import LinkTarget
from tests.scenes.helpers import scene_settings
from tests.scenes.test_guide import DT, TOP_SPEED, Led

ROBOTS = st.sampled_from(("lwr", "panda", "ur5"))
OFFSETS = st.tuples(*[st.floats(-0.15, 0.15)] * 3).map(np.array)
WAYS = st.tuples(*[st.floats(-2.0, 2.0)] * 3).map(np.array)


def point(led: Led, joint: int, offset: Array) -> Array:
    return led.kinematics.data.oMi[led.arm.joint(joint)].act(offset)


@given(ROBOTS, st.integers(1, 6), OFFSETS, st.integers(0, 2**32 - 1))
def test_the_jacobian_of_the_point_is_that_of_finite_differences(robot: RobotName, joint: int, offset: Array, seed: int) -> None:
    led = Led(robot=robot)
    joints = led.arm.joints
    q = led.lower + (led.upper - led.lower) * np.random.default_rng(seed).random(len(led.lower))
    led.q[joints] = q
    led.kinematics.update(led.q)
    J, way = pull(
        led.kinematics, led.arm, LinkTarget(joint, offset, point(led, joint, offset) + np.array([0.0, 0.0, 1.0])), TOP_SPEED
    )
    assert_allclose(way, [0.0, 0.0, TOP_SPEED], atol=1e-12)
    for i in range(len(q)):
        ends: list[Array] = []
        for step in (1e-6, -1e-6):
            led.q[joints] = q
            led.q[joints.start + i] += step
            led.kinematics.update(led.q)
            ends.append(point(led, joint, offset))
        assert_allclose(J[:, i], (ends[0] - ends[1]) / 2e-6, atol=1e-7)


@settings(max_examples=25)
@given(ROBOTS, st.integers(1, 6), OFFSETS, WAYS, st.sampled_from((0.00125, DT, 0.02)), st.sampled_from((0.05, TOP_SPEED, 1.0)))
def test_any_pull_stays_inside_every_limit_and_comes_nearer(
    robot: RobotName, joint: int, offset: Array, way: Array, dt: float, top_speed: float
) -> None:
    led = Led(robot=robot)
    start = point(led, joint, offset)
    target = LinkTarget(joint, offset, start + way)
    fastest = led.fastest([target] * 400, dt, top_speed)
    assert fastest <= 1.01 * top_speed
    q = led.q[led.arm.joints]
    assert np.isfinite(q).all() and (q >= led.lower).all() and (q <= led.upper).all()
    assert np.linalg.norm(point(led, joint, offset) - target.position) <= np.linalg.norm(way) + 1e-3


@settings(max_examples=25)
@given(ROBOTS, st.integers(2, 6), OFFSETS, st.lists(st.floats(-0.25, 0.25), min_size=7, max_size=7))
def test_a_place_that_can_be_reached_is_reached(robot: RobotName, joint: int, offset: Array, turns: list[float]) -> None:
    led = Led(robot=robot)
    start, q = point(led, joint, offset), led.q.copy()
    goal_q = q.copy()
    goal_q[led.arm.joints] += turns[: len(led.lower)]
    inside = (goal_q[led.arm.joints] > led.lower + 0.05) & (goal_q[led.arm.joints] < led.upper - 0.05)
    goal_q[led.arm.joints] = np.where(inside, goal_q[led.arm.joints], q[led.arm.joints])
    led.kinematics.update(goal_q)
    goal = point(led, joint, offset)
    led.kinematics.update(q)
    for _ in range(900):
        led.step(LinkTarget(joint, offset, goal), 0.01, 1.0)
    assert np.linalg.norm(point(led, joint, offset) - goal) < max(0.05 * float(np.linalg.norm(goal - start)), 2e-3)


@pytest.mark.parametrize("robot", ["lwr", "panda", "ur5"])
def test_out_of_reach_it_comes_to_rest(robot: RobotName) -> None:
    """No joint goes to and fro: in the last second, whether at the edge of the reach or at the stops, all are still."""
    random = np.random.default_rng(5)
    for _ in range(12):
        led, way = Led(robot=robot), random.normal(size=3)
        joint, offset = int(random.integers(3, 7)), random.uniform(-0.1, 0.1, 3)
        target = LinkTarget(joint, offset, point(led, joint, offset) + 1.5 * way / np.linalg.norm(way))
        rates = [led.step(target, 0.01, 1.0) for _ in range(1400)]
        late = np.array(rates[-100:])
        turns = np.count_nonzero(np.diff(np.sign(late), axis=0), axis=0)
        assert np.abs(late - late.mean(axis=0))[:, turns > 2].max(initial=0.0) < 1e-3
        assert np.abs(late).max() < 0.1


def test_the_forearm_is_pulled_and_the_hand_would_rather_stay() -> None:
    led = Led()
    start, hand = point(led, 3, np.zeros(3)), led.hand.translation
    for _ in range(600):
        led.step(LinkTarget(3, np.array([0.0, 0.0, 0.1]), point(led, 3, np.array([0.0, 0.0, 0.1])) + np.array([0.0, 0.0, 0.05])))
    moved = float(np.linalg.norm(point(led, 3, np.zeros(3)) - start))
    assert moved > 0.05 and np.linalg.norm(led.hand.translation - hand) < 2.0 * moved


@pytest.mark.parametrize("scene", ["hold", "master_slave", "solo"])
@pytest.mark.parametrize("joint", [3, 4, 5, 6, 7])
def test_in_every_scene_the_point_goes_there(scene: SceneName, joint: int) -> None:
    simulation = Simulation(scene_settings(scene))
    kinematics, arm, offset = simulation.kinematics, simulation.guided, np.array([0.03, -0.02, 0.05])
    kinematics.update(simulation.positions)
    hand = kinematics.hand_pose(arm).translation.copy()
    start = kinematics.data.oMi[arm.joint(joint)].act(offset)
    across = kinematics.point_jacobian(arm, arm.joint(joint), start)
    # The way in which it can be moved best, so that every link can be.
    q = simulation.positions.copy()
    q[arm.joints] += 0.1 * np.linalg.svd(across)[2][0]
    kinematics.update(q)
    goal = kinematics.data.oMi[arm.joint(joint)].act(offset)
    assert np.linalg.norm(goal - start) > 0.01
    for _ in range(round(4.0 / simulation.settings.dt)):
        simulation.step(LinkTarget(joint, offset, goal))
    missing = np.linalg.norm(kinematics.data.oMi[arm.joint(joint)].act(offset) - goal)
    kept = np.linalg.norm(kinematics.hand_pose(arm).translation - hand)
    if scene == "solo" and joint < 6:
        # The hand's place goes first; the elbow moves as far as that leaves it to.
        assert kept < 2e-3 and missing < 0.95 * np.linalg.norm(goal - start)
    else:
        assert missing < 3e-3
    assert simulation.settings.scene != "solo" or joint < 6 or kept > 0.01


def test_a_pull_does_not_move_what_is_not_the_visitors() -> None:
    for scene in ("ball", "imitation"):
        pulled, left = (Simulation(RunSettings(scene=scene)) for _ in range(2))
        for _ in range(50):
            pulled.step(LinkTarget(4, np.zeros(3), np.ones(3)))
            left.step(None)
        assert (pulled.positions == left.positions).all()
