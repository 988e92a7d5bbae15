"""One Pinocchio model of all arms: poses, Jacobians, damped pseudo-inverse and null-space projector, eqs (1)–(6)."""

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.linalg.lapack import dposv

Array = NDArray[np.float64]

DAMPING: Final = 1e-2
"""Damping μ of the task's pseudo-inverse [m/rad]: three orders below the LWR's reach, so that it only acts near singularities."""


@dataclass(frozen=True)
class Arm:
    """Where one arm lives in the model of all arms.

    Attributes:
        name: "left" or "right".
        joints: its columns in q, q̇ and every Jacobian.
        hand: frame id of the hand (the flange).
        shoulder, elbow, wrist: joint ids of the three centres of the arm; the elbow swivels about the line between the others.
        labels: what a person calls each joint.
    """

    name: str
    joints: slice
    hand: int
    shoulder: int
    elbow: int
    wrist: int
    labels: tuple[str, ...]

    def joint(self, number: int) -> int:
        """Return the id of a joint of the arm, counted from 1 at the base; all joints of the model have one column."""
        return self.joints.start + number


class Kinematics:
    """Poses and Jacobians of all arms at the present q.

    `update` is the only method that computes; everything else reads. `jacobian` is a live view of Pinocchio's memory.
    """

    def __init__(self, model: pin.Model, arms: tuple[Arm, ...]) -> None:
        self.model = model
        self.arms = arms
        self.data = model.createData()
        self.jacobian: Array = self.data.J
        """(6, nv), spatial, world axes and world origin: rows 0–2 linear, 3–5 angular."""
        self._hands = tuple(arm.hand for arm in arms)
        self._hand_poses = {hand: self.data.oMf[hand] for hand in self._hands}

    def update(self, positions: Array) -> None:
        """Compute every joint and hand pose and the Jacobian at q (nv,) [rad]."""
        model, data = self.model, self.data
        pin.computeJointJacobians(model, data, positions)
        for hand in self._hands:
            pin.updateFramePlacement(model, data, hand)

    def hand_pose(self, arm: Arm) -> pin.SE3:
        """Return the pose of the hand in the world; a live view, copy it to keep it."""
        return self._hand_poses[arm.hand]

    def hand_jacobian(self, arm: Arm, dimension: int = 6) -> Array:
        """Return the first rows (dimension, n) of J of the hand, eq. (2): linear over angular velocity of the hand, world axes."""
        return pin.getFrameJacobian(self.model, self.data, arm.hand, pin.LOCAL_WORLD_ALIGNED)[:dimension, arm.joints]

    def joint_point(self, joint: int) -> Array:
        """Return the origin (3,) of a joint frame in the world [m], a copy."""
        return self.data.oMi[joint].translation.copy()

    def joint_rotation(self, joint: int) -> Array:
        """Return the rotation (3, 3) of a joint frame in the world, a copy."""
        return self.data.oMi[joint].rotation.copy()

    def point_jacobian(self, arm: Arm, joint: int, point: Array) -> Array:
        """Return the Jacobian (3, n) of a point (3,) [m], world, that moves with a joint of the arm [m/rad]."""
        J = self.jacobian[:, arm.joints]
        moving = np.arange(arm.joints.start, arm.joints.stop) <= self.model.joints[joint].idx_v
        return (J[:3] + np.cross(J[3:].T, point).T) * moving


@cache
def _regularisation(dimensions: int, damping: float) -> Array:
    return damping * damping * np.eye(dimensions)


def damped_solution(J: Array, task_velocity: Array, damping: float = DAMPING) -> Array:
    """Return q̇ = J^# ẋ, eqs (4), (5), with J^# = Jᵀ (J Jᵀ + μ² I)⁻¹.

    Args:
        J: (m, n).
        task_velocity: ẋ (m,).
        damping: μ; 0 gives the Moore–Penrose inverse of a J with full row rank.

    Returns:
        (n,) [rad/s].
    """
    gram = J.dot(J.T)
    gram += _regularisation(len(gram), damping)
    return dposv(gram, task_velocity)[1].dot(J)


def pseudo_inverse(J: Array, damping: float = 0.0) -> Array:
    """Return J^# (n, m), eq. (5), optionally damped. For analysis; the hot path uses `damped_solution`."""
    return np.asarray(np.linalg.solve(J @ J.T + damping**2 * np.eye(len(J)), J).T, np.float64)


def null_space_projector(J: Array, damping: float = 0.0) -> Array:
    """Return N = I − J^# J (n, n), eq. (6)."""
    return np.eye(J.shape[1]) - pseudo_inverse(J, damping) @ J
