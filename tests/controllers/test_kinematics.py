"""Poses, Jacobians and errors of the real arms against finite differences, also in singular postures."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from controllers.choices import HandTask
from controllers.kinematics import DAMPING, Arm, Array, damped_solution, pseudo_inverse
from controllers.tasks import TASK_DIMENSION, hold, pose_error
from scenes.rigs import RIGS
from scenes.room import Room
from scenes.settings import RigName
from tests.controllers.helpers import bodies, derivative, random_postures
from tests.scenes.helpers import RIG_NAMES


def postures(room: Room) -> list[Array]:
    """Random postures, and the arm's singular ones: all zero, elbows straight, wrists straight."""
    found = [room.start, np.zeros(room.model.nv), *random_postures(room, 6, seed=11)]
    for joint in (3, 5):
        straight = random_postures(room, 1, seed=12 + joint)[0]
        straight[[joint, joint + 7]] = 0.0
        found.append(straight)
    return found


@pytest.mark.parametrize("rig", RIG_NAMES)
def test_hand_jacobian_against_finite_differences(rig: RigName) -> None:
    """J's linear rows are ∂p/∂q, its angular rows the axis of (∂R/∂q) Rᵀ; the other arm has no effect."""
    room, kinematics, _ = bodies(rig)
    for q in postures(room):
        for arm in room.arms:
            kinematics.update(q)
            J, R = kinematics.hand_jacobian(arm).copy(), kinematics.hand_pose(arm).rotation.copy()

            def pose(at: Array, arm: Arm = arm, R: Array = R) -> Array:
                kinematics.update(at)
                hand = kinematics.hand_pose(arm)
                return np.r_[hand.translation, pin.log3(hand.rotation.dot(R.T))]

            numeric = derivative(pose, q)
            assert_allclose(J, numeric[:, arm.joints], atol=2e-8)
            others = np.delete(numeric, np.r_[arm.joints], axis=1)
            assert_allclose(others, 0.0, atol=1e-12)
            assert np.abs(J).max() > 0.1


@pytest.mark.parametrize("rig", RIG_NAMES)
def test_point_jacobian_against_finite_differences(rig: RigName) -> None:
    """For a point fixed to any joint; joints further out do not move it."""
    room, kinematics, _ = bodies(rig)
    local = np.array([0.07, -0.03, 0.11])
    for q in postures(room):
        for arm in room.arms:
            for joint in range(arm.shoulder - 1, arm.shoulder + 6):

                def point(at: Array, joint: int = joint) -> Array:
                    kinematics.update(at)
                    return kinematics.data.oMi[joint].act(local)

                numeric = derivative(point, q)[:, arm.joints]
                at = point(q)
                J = kinematics.point_jacobian(arm, joint, at)
                assert_allclose(J, numeric, atol=2e-8)
                column = kinematics.model.joints[joint].idx_v - arm.joints.start
                assert not J[:, column + 1 :].any() and np.abs(J[:, : column + 1]).max() > 0.01


@pytest.mark.parametrize("rig", RIG_NAMES)
def test_joint_positions_and_the_pose_error(rig: RigName) -> None:
    # All zero is straight up from the base: shoulder .310, elbow .710, wrist 1.100, flange 1.178 m along it.
    room, kinematics, _ = bodies(rig)
    kinematics.update(np.zeros(room.model.nv))
    for arm, base in zip(room.arms, RIGS[rig].bases, strict=True):
        for height, point in (
            (0.310, kinematics.joint_point(arm.shoulder)),
            (0.710, kinematics.joint_point(arm.elbow)),
            (1.100, kinematics.joint_point(arm.wrist)),
            (1.178, kinematics.hand_pose(arm).translation),
        ):
            assert_allclose(point, base.act(np.array([0.0, 0.0, height])), atol=1e-12)
    # e = 0 at the pose itself; a target moved by δ and turned by φ about a world axis gives e = (δ, φ).
    room, kinematics, _ = bodies(rig)
    kinematics.update(room.start)
    pose = kinematics.hand_pose(room.arms[0])
    assert_allclose(pose_error(pose, pose.translation, pose.rotation), 0.0, atol=1e-12)
    shift, turn = np.array([0.1, -0.2, 0.05]), np.array([0.3, 0.1, -0.4])
    assert_allclose(
        pose_error(pose, pose.translation + shift, pin.exp3(turn) @ pose.rotation),
        np.r_[shift, turn],
        atol=1e-12,
    )


def test_a_singular_posture_gives_a_bounded_velocity() -> None:
    """All joints zero, the hand commanded down: |q̇| ≤ |ẋ| / 2μ, where the undamped inverse would diverge."""
    room, kinematics, _ = bodies("table")
    kinematics.update(np.zeros(room.model.nv))
    J = kinematics.hand_jacobian(room.arms[0])[:3]
    assert np.linalg.svd(J)[1][-1] < 1e-9
    dq = damped_solution(J, np.array([0.1, 0.0, -0.25]))
    assert np.isfinite(dq).all()
    assert np.linalg.norm(dq) <= np.linalg.norm([0.1, 0.0, -0.25]) / (2.0 * DAMPING)


@given(st.integers(0, 10_000), st.sampled_from([1, 2, 3, 6]), st.floats(0.0, 0.5))
def test_damped_solution_is_the_damped_pseudo_inverse(seed: int, m: int, damping: float) -> None:
    """J^# ẋ by Cholesky equals the matrix applied to ẋ; without damping it is numpy's pseudo-inverse, and J q̇ = ẋ."""
    random = np.random.default_rng(seed)
    J, task = random.normal(size=(m, 7)), random.normal(size=m)
    assume(np.linalg.svd(J)[1][-1] > 0.05)
    J.flags.writeable = task.flags.writeable = False
    assert_allclose(
        damped_solution(J, task, damping), pseudo_inverse(J, damping) @ task, atol=1e-9, rtol=1e-9
    )
    assert_allclose(pseudo_inverse(J), np.linalg.pinv(J), atol=1e-8)
    assert_allclose(J @ damped_solution(J, task, 0.0), task, atol=1e-8)


@given(st.integers(0, 10_000), st.floats(1e-3, 0.3))
def test_damping_is_tikhonovs(seed: int, damping: float) -> None:
    """q̇ minimises |J q̇ − ẋ|² + μ² |q̇|²: its gradient vanishes, also for a J without full rank."""
    random = np.random.default_rng(seed)
    J, task = random.normal(size=(6, 7)), random.normal(size=6)
    J[5] = J[4]
    dq = damped_solution(J, task, damping)
    assert_allclose(J.T @ (J @ dq - task) + damping**2 * dq, 0.0, atol=1e-6)


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-6, 1e-3, 0.2, 1.5, 2.8])
def test_the_errors_rate_is_minus_the_jacobian_turned_by_the_logarithm(rig: RigName, angle: float) -> None:
    """−J for positions, −J_log(φ) J for turns: any error φ (tiny ones by series), and singular postures."""
    room, kinematics, _ = bodies(rig)
    turn = pin.exp3(angle * np.array([0.6, -0.48, 0.64]))
    for q in postures(room):
        for arm in room.arms:
            kinematics.update(q)
            J, pose = kinematics.hand_jacobian(arm).copy(), kinematics.hand_pose(arm).copy()

            def error(at: Array, arm: Arm = arm, pose: pin.SE3 = pose) -> Array:
                kinematics.update(at)
                return pose_error(kinematics.hand_pose(arm), pose.translation + 0.1, turn @ pose.rotation)

            numeric = derivative(error, q)[:, arm.joints]
            # R_e = R_d Rᵀ; a turn ω gives R_e exp(−ω), and Jlog3 is the derivative of log for it.
            assert_allclose(numeric[3:], -pin.Jlog3(turn) @ J[3:], atol=1e-7)
            assert_allclose(numeric[:3], -J[:3], atol=1e-7)


@pytest.mark.parametrize("task", ["position", "pose"])
def test_holding_brings_the_error_back(task: HandTask) -> None:
    """Eqs (7), (8): with q̇ = J^# K e the error falls as exp(−K t); with K = 0 it stays (positive control)."""
    room, kinematics, _ = bodies("torso")
    arm, dt, m = room.arms[0], 0.002, TASK_DIMENSION[task]
    for gain, left in ((2.0, np.exp(-1.0)), (0.0, 1.0)):
        q = room.start.copy()
        kinematics.update(q)
        pose = kinematics.hand_pose(arm)
        position, rotation = (
            pose.translation + np.array([0.02, 0.03, -0.01]),
            pin.exp3(np.array([0.1, 0.0, 0.1])) @ pose.rotation,
        )
        errors = []
        for _ in range(251):
            kinematics.update(q)
            error = pose_error(kinematics.hand_pose(arm), position, rotation)
            errors.append(float(np.linalg.norm(error[:m])))
            q[arm.joints] += hold(kinematics.hand_jacobian(arm)[:m], error[:m], gain) * dt
        assert errors[-1] / errors[0] == pytest.approx(left, rel=0.02)
