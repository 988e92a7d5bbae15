"""Scripted motion: the seeded person, reproducible, and an arm on null-space motions, which keep the hand."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from controllers.kinematics import Array, Kinematics
from scenes.room import build_room
from scenes.settings import ArmName, RigName
from scenes.simulation import Simulation
from scenes.solo import MOTIONS, NullMotions
from scenes.targets import JointTarget
from scenes.two_arms import PAUSE_RANGE, SPEED_RANGE, Autopilot
from tests.scenes.helpers import RIG_NAMES, given_settings

SEEDS = st.integers(0, 9999)


def path(rig: RigName, guided: ArmName, seed: int, times: Array) -> Array:
    autopilot = Autopilot(build_room(rig), guided, seed)
    return np.array([autopilot.target(float(t)).position for t in times])


@given(st.sampled_from(RIG_NAMES), st.sampled_from(["left", "right"]), SEEDS)
def test_a_seed_determines_the_person(rig: RigName, guided: ArmName, seed: int) -> None:
    times = np.linspace(0.0, 30.0, 40)
    first = path(rig, guided, seed, times)
    assert_array_equal(path(rig, guided, seed, times), first)
    assert_array_equal(path(rig, guided, seed, times[::-1])[::-1], first)
    assert np.abs(path(rig, guided, seed + 1, times) - first).max() > 0.01


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_person_moves_smoothly_within_the_speed_range(rig: RigName, seed: int) -> None:
    dt = 0.002
    speeds = np.diff(path(rig, "right", seed, np.arange(0.0, 46.0, dt)), axis=0) / dt
    peak = float(np.linalg.norm(speeds, axis=1).max())
    assert SPEED_RANGE[0] * 0.99 < peak <= SPEED_RANGE[1] * 1.001
    accelerations = np.linalg.norm(np.diff(speeds, axis=0), axis=1) / dt
    # A quintic of length L in T ≥ .5 s peaks at an acceleration of 5.77 L/T² and a speed of 1.875 L/T.
    assert 0.05 < accelerations.max() < 5.78 / 1.875 * SPEED_RANGE[1] / 0.5


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("guided", ["left", "right"])
def test_the_person_moves_to_the_other_arm_and_back(rig: RigName, guided: ArmName) -> None:
    room = build_room(rig)
    kinematics = Kinematics(room.model, room.arms)
    kinematics.update(room.start)
    other = room.other(guided)
    elbow, wrist = kinematics.joint_point(other.elbow), kinematics.joint_point(other.wrist)
    places = [kinematics.hand_pose(other).translation.copy(), wrist, (elbow + wrist) / 2.0]
    home = kinematics.hand_pose(room.arm(guided)).translation.copy()
    dt = 0.01
    points = path(rig, guided, 4, np.arange(0.0, 90.0, dt))
    still = np.r_[False, np.abs(np.diff(points, axis=0)).max(axis=1) == 0.0]
    edges = np.flatnonzero(np.diff(still.astype(int)))
    rests = [(points[a + 1], (b - a) * dt) for a, b in itertools.pairwise(edges) if still[a + 1]]
    assert len(rests) >= 8
    for i, (point, seconds) in enumerate(rests):
        assert PAUSE_RANGE[0] - 2 * dt <= seconds <= PAUSE_RANGE[1] + 0.2
        near = places if i % 2 == 0 else [home]
        reach = 0.06 if i % 2 == 0 else 0.10
        assert min(float(np.abs(point - place).max()) for place in near) <= reach + 1e-9


def test_starts_and_targets() -> None:
    # At time 0 the target is the hand's place in the start posture, or the one in the settings.
    room = build_room("torso")
    kinematics = Kinematics(room.model, room.arms)
    kinematics.update(room.start)
    assert_array_equal(
        Autopilot(room, "right", 1).target(0.0).position, kinematics.hand_pose(room.arm("right")).translation
    )
    start = np.array([0.5, -0.2, 1.0])
    assert_array_equal(Autopilot(room, "right", 1, start).target(0.0).position, start)
    assert_array_equal(start, [0.5, -0.2, 1.0])
    autopilot = Autopilot(build_room("table"), "left", 7)
    for time in (0.0, 3.0, 1e3):
        before = autopilot.target(time).position.copy()
        autopilot.target(time).position[:] = 1e9
        assert_array_equal(autopilot.target(time).position, before)


def alone(**changes: object) -> Simulation:
    return Simulation(given_settings(scene="solo", path="stay", task="position", **changes), 10)


def at(simulation: Simulation, joints: Array) -> tuple[Array, Array]:
    """Positions of hand and elbow with the arm's joints (7,) [rad]."""
    q = simulation.positions.copy()
    q[simulation.guided.joints] = joints
    simulation.kinematics.update(q)
    kinematics, arm = simulation.kinematics, simulation.guided
    return kinematics.hand_pose(arm).translation.copy(), kinematics.joint_point(arm.elbow)


@pytest.mark.parametrize("motion", range(MOTIONS))
@pytest.mark.parametrize("way", [0.9, -0.9])
def test_a_motion_keeps_the_hand_and_the_way_back_restores_the_start(motion: int, way: float) -> None:
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


def test_a_motion_ends_at_a_joint_limit_and_can_return() -> None:
    simulation = alone()
    arm, model = simulation.guided, simulation.room.model
    motions = NullMotions(simulation.room, arm, simulation.positions)
    there = motions.go(2, 30.0)
    low, high = model.lowerPositionLimit[arm.joints], model.upperPositionLimit[arm.joints]
    assert (there >= low).all() and (there <= high).all()
    assert np.minimum(there - low, high - there).min() < 0.02 and motions.gone[2] < 30.0
    assert np.linalg.norm(motions.go(2, 0.0) - simulation.positions[arm.joints]) < 1e-3


@pytest.mark.parametrize(("gain", "dt"), [(2.0, 0.005), (10.0, 0.005), (0.0, 0.02)])
def test_the_arm_follows_a_jump_of_a_slider_and_its_hand_stays(gain: float, dt: float) -> None:
    simulation = alone(k=gain, dt=dt)
    hand, _ = at(simulation, simulation.positions[simulation.guided.joints])
    motions = NullMotions(simulation.room, simulation.guided, simulation.positions)
    for motion, way in enumerate((0.9, 0.8, -0.7, 0.8)):
        target = JointTarget(motions.go(motion, way))
        for _ in range(round(3.0 / dt)):
            simulation.step(target)
            assert (
                np.linalg.norm(at(simulation, simulation.positions[simulation.guided.joints])[0] - hand)
                < 5e-4
            )
    assert_allclose(simulation.positions[simulation.guided.joints], motions.joints, atol=2e-3)
