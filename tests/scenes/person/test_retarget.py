"""From a person to the robots: an exact low-pass filter, and arms with the same directions, no jumps."""

import math

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from controllers.kinematics import Array, Kinematics
from controllers.proximity import ProximityDetector
from scenes.lwr.facts import JOINTS
from scenes.person.angles import arm_directions
from scenes.person.clips import REST, Clip, ClipName
from scenes.person.retarget import LIMIT_MARGIN, AngleFilter, Retargeter, fill_joints
from scenes.rigs import MIRROR, RIGS
from scenes.room import build_room
from scenes.settings import RigName
from tests.scenes.person.strategies import SIDES, arms, bodies

ZERO = np.zeros((2, 4))


def test_steps_rates_and_inputs() -> None:
    # Below the top speed, y = 1 − exp(−2π f t).
    low_pass = AngleFilter(np.zeros((1, 1)), cutoff_hz=0.5, top_rate=20.0)
    found = [float(low_pass.step(np.ones((1, 1)), 0.01)[0, 0]) for _ in range(100)]
    assert_allclose(found, 1.0 - np.exp(-math.tau * 0.5 * 0.01 * np.arange(1, 101)), atol=1e-12)
    # A far goal is approached at top speed, then exponentially; both by closed form, without overshoot.
    rate, omega = 0.5, math.tau * 2.0
    slow = AngleFilter(np.zeros((1, 1)), cutoff_hz=2.0, top_rate=rate)
    knee = rate / omega
    reached = (2.0 - knee) / rate
    for k in range(1, 800):
        y = float(slow.step(np.array([[2.0]]), 0.01)[0, 0])
        t = 0.01 * k
        assert math.isclose(
            y, rate * t if t < reached else 2.0 - knee * math.exp(-omega * (t - reached)), abs_tol=1e-9
        )
        assert slow.rates[0, 0] <= rate + 1e-12
    low_pass = AngleFilter(ZERO)
    wanted = np.linspace(-1.0, 1.0, 8).reshape(2, 4)
    a = low_pass.step(wanted, 0.005)
    b = low_pass.step(wanted, 0.005)
    assert_allclose(low_pass.rates, (b - a) / 0.005, atol=1e-12)
    low_pass = AngleFilter(np.full((2, 4), 0.3))
    assert_allclose(low_pass.step(None, 0.1), 0.3)
    assert low_pass.lost_for == 0.1
    start, wanted = np.zeros((2, 4)), np.ones((2, 4))
    low_pass, twin = AngleFilter(start), AngleFilter(ZERO)
    start[:] = 9.0
    low_pass.step(wanted, 0.01)[:] = 9.0
    wanted[:] = 9.0
    twin.step(np.ones((2, 4)), 0.01)
    assert_allclose(low_pass.step(None, 0.01), twin.step(None, 0.01), atol=0.0)


@given(
    st.lists(st.floats(-10.0, 10.0), min_size=1, max_size=6), st.floats(0.1, 50.0), st.floats(0.05, 20.0), st.floats(1e-4, 0.5),
    st.integers(2, 9),
)  # fmt: skip
def test_the_result_does_not_depend_on_the_time_step(
    inputs: list[float], cutoff: float, rate: float, dt: float, parts: int
) -> None:
    one, many = (AngleFilter(np.zeros((1, 1)), cutoff, rate) for _ in range(2))
    for x in inputs:
        before = one.values.copy()
        a = one.step(np.array([[x]]), dt)
        for _ in range(parts):
            many.step(np.array([[x]]), dt / parts)
        assert_allclose(a, many.values, atol=1e-9)
        assert abs(a[0, 0] - before[0, 0]) <= rate * dt * (1.0 + 1e-9) + 1e-12
        assert abs(x - a[0, 0]) <= abs(x - before[0, 0]) + 1e-12


@pytest.mark.parametrize(
    "missing", [None, np.full((2, 4), np.nan), np.array([[0, 0, 0, np.inf], [0, 0, 0, 0.0]])]
)
def test_lost(missing: np.ndarray | None) -> None:
    low_pass = AngleFilter(ZERO)
    seen = np.full((2, 4), 0.4)
    for _ in range(20):
        low_pass.step(seen, 0.01)
    assert low_pass.lost_for == 0.0
    for _ in range(300):
        low_pass.step(missing, 0.01)
    assert math.isclose(low_pass.lost_for, 3.0)
    assert_allclose(low_pass.values, seen, atol=1e-9)
    low_pass.step(seen, 0.01)
    assert low_pass.lost_for == 0.0


ROOM = build_room("torso")
LIMITS = np.array([joint.position_limit for joint in JOINTS[:4]]) - LIMIT_MARGIN
REACHABLE = float(LIMITS[1])
"""Largest angle between a bone and the axis of its carrier [rad]."""


def bases(rig: RigName = "torso") -> tuple[pin.SE3, ...]:
    return RIGS[rig].bases


def pointed(q: Array, arm: int, rig: RigName = "torso") -> tuple[Array, Array]:
    robot = ROOM.robots[arm]
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, np.concatenate([q, np.zeros(3)]))
    base = bases(rig)[arm]
    shoulder, elbow, wrist = (
        base.act(data.oMi[j].translation) for j in (robot.shoulder, robot.elbow, robot.wrist)
    )
    upper, forearm = elbow - shoulder, wrist - elbow
    return upper / np.linalg.norm(upper), forearm / np.linalg.norm(forearm)


def reachable(angles: Array, arm: int, rig: RigName = "torso") -> bool:
    """True if an arm's posture is within all limits."""
    upper, _ = arm_directions(angles[arm], SIDES[arm])
    axis = bases(rig)[arm].rotation[:, 2]
    return (
        float(np.arccos(np.clip(upper @ axis, -1.0, 1.0))) < REACHABLE - 1e-6
        and angles[arm, 3] < REACHABLE - 1e-6
    )


def arm_joints(upper: Array, forearm: Array, base: Array, before: Array | None) -> Array:
    joints = np.empty(4)
    fill_joints(
        upper, forearm, base, LIMITS, before is not None, joints if before is None else before, joints
    )
    return joints


def natural_pose(angles: Array, rig: RigName = "torso") -> Array:
    return Retargeter(RIGS[rig]).joints(angles)


def joint_distance(q: Array) -> float:
    kinematics = Kinematics(ROOM.model, ROOM.arms)
    posture = ROOM.start.copy()
    for arm, joints in zip(ROOM.arms, q, strict=True):
        posture[arm.joints.start : arm.joints.start + 4] = joints
    kinematics.update(posture)
    return ProximityDetector(kinematics, ROOM.geometry).detect().distance


@pytest.mark.parametrize("rig", ["torso", "table"])
@given(bodies(arms))
def test_directions_match(rig: RigName, angles: Array) -> None:
    q = natural_pose(angles, rig)
    assert (np.abs(q) <= LIMITS + 1e-12).all()
    for arm, side in enumerate(SIDES):
        if reachable(angles, arm, rig):
            for found, wanted in zip(
                pointed(q[arm], arm, rig), arm_directions(angles[arm], side), strict=True
            ):
                assert_allclose(found, wanted, atol=1e-6)


@given(bodies(arms), st.integers(0, 10_000))
def test_directions_match_from_any_posture(angles: Array, seed: int) -> None:
    before = np.random.default_rng(seed).uniform(-LIMITS, LIMITS, (2, 4))
    retargeter = Retargeter(RIGS["torso"])
    retargeter.reset(before)
    q = retargeter.joints(angles)
    assert (np.abs(q) <= LIMITS + 1e-12).all()
    for arm, side in enumerate(SIDES):
        directions = arm_directions(angles[arm], side)
        base = bases()[arm].rotation
        seen = np.linalg.norm(np.cross(directions[0], base[:, 2])) > 0.06 and np.sin(angles[arm, 3]) > 0.06
        if seen and reachable(angles, arm):
            for found, wanted in zip(pointed(q[arm], arm), directions, strict=True):
                assert_allclose(found, wanted, atol=1e-6)


@settings(max_examples=300)
@given(arms, st.integers(0, 10_000))
def test_the_nearest_branch(angles: Array, seed: int) -> None:
    before = np.random.default_rng(seed).uniform(-LIMITS, LIMITS)
    base = RIGS["torso"].bases[0].rotation
    directions = arm_directions(angles, "left")
    u, f = (base.T @ d for d in directions)
    if np.hypot(u[0], u[1]) < 0.06 or np.sin(angles[3]) < 0.06:
        return
    nearest = np.inf
    for sigma in (1.0, -1.0):
        q1, q2 = np.arctan2(-sigma * u[1], -sigma * u[0]), sigma * np.arccos(u[2])
        w = (pin.utils.rotate("z", q1) @ pin.utils.rotate("y", -q2)).T @ f
        for epsilon in (1.0, -1.0):
            q = np.array([q1, q2, np.arctan2(epsilon * w[1], epsilon * w[0]), epsilon * np.arccos(w[2])])
            if (np.abs(q) < LIMITS).all():
                nearest = min(nearest, float(np.linalg.norm(q - before)))
    if nearest < np.inf:
        assert np.linalg.norm(arm_joints(*directions, base, before) - before) < nearest + 1e-6


@given(bodies(arms))
def test_mirror_images_and_bones_out_of_reach(angles: Array) -> None:
    # The upper arm misses by its angle beyond q2's limit only, if q1 is free.
    q = natural_pose(angles)
    for arm, side in enumerate(SIDES):
        upper = arm_directions(angles[arm], side)[0]
        axis = bases()[arm].rotation[:, 2]
        beyond = max(float(np.arccos(np.clip(upper @ axis, -1.0, 1.0))) - REACHABLE, 0.0)
        miss = float(np.arccos(np.clip(pointed(q[arm], arm)[0] @ upper, -1.0, 1.0)))
        assert miss > beyond - 1e-6
        if abs(q[arm, 0]) < LIMITS[0] - 1e-9:
            assert miss < beyond + 1e-6
    # Swapped arms of the person give the mirrored posture of the robots.
    assert_allclose(natural_pose(angles[::-1])[::-1] * MIRROR[:4], q, atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_clips_have_no_jumps(seed: int) -> None:
    """The medley contains all clips."""
    clip, dt = Clip("medley", seed), 0.02
    retargeter = Retargeter(RIGS["torso"])
    q = np.array([retargeter.joints(clip.angles(k * dt)) for k in range(int(clip.duration / dt) + 2)])
    assert np.abs(np.diff(q, axis=0)).max() / dt < np.radians(110.0)
    assert (q[:, :, [1, 3]] > 0.0).all() and (np.abs(q) < LIMITS - np.radians(2.0)).all()
    assert_allclose(q[0], natural_pose(REST), atol=1e-9)


@pytest.mark.parametrize(
    ("name", "seed"),
    [*((name, seed) for name in ("clap", "cross") for seed in range(6)), ("wave", 1), ("reach", 1)],
)
def test_without_avoidance_two_clips_collide_and_two_do_not(name: ClipName, seed: int) -> None:
    clip, retargeter = Clip(name, seed), Retargeter(RIGS["torso"])
    distances = [
        joint_distance(retargeter.joints(clip.angles(t))) for t in np.arange(0.0, clip.duration, 0.1)
    ]
    assert distances[0] > 0.2
    assert min(distances) < -0.02 if name in ("clap", "cross") else min(distances) > 0.2


def test_special_postures_and_reset() -> None:
    # An upper arm that crosses the axis of the robot's base, where q1 is undefined, moves no joint suddenly.
    base = RIGS["torso"].bases[0].rotation
    bend = pin.exp3(0.9 * base[:, 1])
    before, steps, misses = None, [], []
    for tilt in np.linspace(-0.4, 0.4, 401):
        upper = base @ np.array([np.sin(tilt), 1e-4, np.cos(tilt)])
        upper /= np.linalg.norm(upper)
        q = arm_joints(upper, bend @ upper, base, before)
        if before is not None:
            steps.append(np.abs(q - before).max())
        misses.append(np.abs(pointed(q, 0)[0] - upper).max())
        before = q
    assert max(steps) < 0.05
    assert max(misses) < 0.02
    # With a straight elbow the roll of the robot's upper arm is kept.
    retargeter = Retargeter(RIGS["torso"])
    bent = np.radians([[40.0, 30.0, 20.0, 60.0]] * 2)
    q = retargeter.joints(bent)
    straight = q
    for elbow in np.linspace(60.0, 0.0, 120):
        bent[:, 3] = np.radians(elbow)
        straight = retargeter.joints(bent)
    assert_allclose(straight[:, 2], q[:, 2], atol=1e-3)
    assert_allclose(straight[:, 3], 0.0, atol=1e-9)
    retargeter = Retargeter(RIGS["torso"])
    retargeter.joints(np.radians([[-170.0, 20.0, 0.0, 30.0]] * 2))
    retargeter.reset(-natural_pose(REST))
    retargeter.reset()
    assert_allclose(retargeter.joints(REST), natural_pose(REST), atol=0.0)
    retargeter = Retargeter(RIGS["torso"])
    retargeter.joints(REST)[:] = 7.0
    assert_allclose(retargeter.joints(REST), natural_pose(REST), atol=1e-12)
