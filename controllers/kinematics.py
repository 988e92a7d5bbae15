"""One Pinocchio model of all arms: poses, Jacobians, damped pseudo-inverse, null-space projector and basis, eqs (1)–(6)."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from controllers.compiled import Matrix, Vector, loop

Array = NDArray[np.float64]

DAMPING: Final = 1e-2
"""Damping μ of the task's pseudo-inverse [m/rad]: acts only near singularities."""

LONGEST_STEP: Final = 0.02
"""Longest stable time step of `quiet_solution` [s]; used at every dt: q̇ is independent of dt."""


@dataclass(frozen=True)
class Arm:
    """Indices of one arm in the model of all arms.

    Attributes:
        name: "left" or "right".
        joints: its columns in q, q̇ and every Jacobian.
        hand: frame id of the hand (the flange).
        shoulder, elbow, wrist: joint ids; the elbow swivels about the line between the other two.
    """

    name: str
    joints: slice
    hand: int
    shoulder: int
    elbow: int
    wrist: int
    labels: tuple[str, ...]

    def joint(self, number: int) -> int:
        """Id of a joint, counted from 1 at the base."""
        return self.joints.start + number


class Kinematics:
    """Poses and Jacobians of all arms at the q of the last `update`."""

    def __init__(self, model: pin.Model, arms: tuple[Arm, ...]) -> None:
        self.model = model
        self.data = model.createData()
        self.jacobian: Array = self.data.J
        """Live view of Pinocchio's memory (6, nv), world axes and world origin: rows 0–2 linear, 3–5 angular.
        """
        self.positions: Array = pin.neutral(model)
        """q (nv,) of the last `update`, not a copy [rad]."""
        self._hand_poses = {arm.hand: self.data.oMf[arm.hand] for arm in arms}

    def update(self, positions: Array) -> None:
        """Compute every joint and hand pose and the Jacobian at q (nv,) [rad]."""
        model, data = self.model, self.data
        self.positions = positions
        pin.computeJointJacobians(model, data, positions)
        for hand in self._hand_poses:
            pin.updateFramePlacement(model, data, hand)

    def hand_pose(self, arm: Arm) -> pin.SE3:
        """Pose of the hand in the world, a live view."""
        return self._hand_poses[arm.hand]

    def hand_jacobian(self, arm: Arm, dimension: int = 6) -> Array:
        """First rows (dimension, n) of J of the hand, eq. (2): linear, then angular velocity, world axes."""
        return pin.getFrameJacobian(self.model, self.data, arm.hand, pin.LOCAL_WORLD_ALIGNED)[
            :dimension, arm.joints
        ]

    def joint_point(self, joint: int) -> Array:
        """Origin (3,) of a joint frame in the world [m], a copy."""
        return self.data.oMi[joint].translation.copy()

    def point_jacobian(self, arm: Arm, joint: int, point: Array) -> Array:
        """Jacobian (3, n) of a point (3,) [m], world, fixed to a joint of the arm [m/rad]."""
        J = np.zeros((3, arm.joints.stop - arm.joints.start))
        fill_point_jacobian(
            self.jacobian[:, arm.joints], self.model.joints[joint].idx_v - arm.joints.start + 1, point, J
        )
        return J


@loop("void(float64[:, :], int64, float64[:], float64[:, :])", fills=("J",))
def fill_point_jacobian(spatial: Matrix, moving: int, point: Vector, J: Matrix) -> None:
    """Fill J (3, moving) of a point (3,) [m] that the first joints move; `spatial`: see
    `Kinematics.jacobian`.
    """
    px, py, pz = point[0], point[1], point[2]
    for j in range(moving):
        vx, vy, vz = spatial[0, j], spatial[1, j], spatial[2, j]
        ax, ay, az = spatial[3, j], spatial[4, j], spatial[5, j]
        J[0, j], J[1, j], J[2, j] = vx + ay * pz - az * py, vy + az * px - ax * pz, vz + ax * py - ay * px


@loop("void(float64[:, :], float64[:], float64, float64[:])", fills=("velocities",))
def fill_damped_solution(J: Matrix, task_velocity: Vector, damping: float, velocities: Vector) -> None:
    """Fill `damped_solution` (n,): J Jᵀ + μ² I = L Lᵀ (Cholesky), L z = ẋ, Lᵀ y = z, q̇ = Jᵀ y."""
    m, n = J.shape
    L, y = np.empty((m, m)), np.empty(m)
    for i in range(m):
        for k in range(i + 1):
            entry = damping * damping if i == k else 0.0
            for j in range(n):
                entry += J[i, j] * J[k, j]
            for j in range(k):
                entry -= L[i, j] * L[k, j]
            L[i, k] = math.sqrt(entry) if i == k else entry / L[k, k]
    for i in range(m):
        y[i] = task_velocity[i]
        for k in range(i):
            y[i] -= L[i, k] * y[k]
        y[i] /= L[i, i]
    for i in range(m - 1, -1, -1):
        for k in range(i + 1, m):
            y[i] -= L[k, i] * y[k]
        y[i] /= L[i, i]
    for j in range(n):
        velocities[j] = 0.0
        for i in range(m):
            velocities[j] += J[i, j] * y[i]


def damped_solution(J: Array, task_velocity: Array, damping: float = DAMPING) -> Array:
    """q̇ = J^# ẋ (n,) [rad/s] for J (m, n) and ẋ (m,), eqs (4), (5), with J^# = Jᵀ (J Jᵀ + μ² I)⁻¹.

    Args:
        damping: μ; 0 for the Moore–Penrose inverse of a J with full row rank.
    """
    velocities = np.empty(J.shape[1])
    fill_damped_solution(J, task_velocity, damping, velocities)
    return velocities


@loop("void(float64[:, :], float64[:], float64, float64, float64[:])", fills=("velocities",))
def fill_quiet_solution(
    J: Matrix, task_velocity: Vector, bend: float, damping: float, velocities: Vector
) -> None:
    m, n = J.shape
    least, square, lost = damping * damping, 0.0, 0.0
    for i in range(m):
        square += task_velocity[i] * task_velocity[i]
    speed = math.sqrt(square)
    most = LONGEST_STEP * bend * speed
    fill_damped_solution(J, task_velocity, math.sqrt(least + 4.0 * most), velocities)
    for i in range(m):
        missing = task_velocity[i]
        for j in range(n):
            missing -= J[i, j] * velocities[j]
        lost += missing * missing
    if square > 0.0:
        share = lost / square
        fill_damped_solution(J, task_velocity, math.sqrt(least + most * share * share), velocities)


def quiet_solution(J: Array, task_velocity: Array, bend: float, damping: float = DAMPING) -> Array:
    """q̇ = J^# ẋ (n,) [rad/s] for J (m, n) and ẋ (m,), with a damping that brings an arm that cannot follow
    to rest.

    Under a constant pull ẋ an arm rests where Jᵀ ẋ = 0, for example stretched towards a target out of reach.
    There, with P = J^# J, H the second derivative of the hand's position along ẋ/|ẋ|, and K the gain of the
    pull,

        ∂q̇/∂q = (I − P) H |ẋ|/μ² − K P.

    I − P is symmetric, positive and commutes with P, so the eigenvalues are real; none is below −max(a
    |ẋ|/μ², K), with a the largest eigenvalue of −H in the null space of J (elsewhere I − P is almost 0).
    Euler's method is stable while dt times the eigenvalue is above −2, and does not overshoot above −1.

    So μ² = μ₀² + a dt |ẋ| is enough there for a reach of 0.25 m or more, with `LONGEST_STEP` as dt; a shorter
    arm may tremble if it is pulled at more than a person's speed. Elsewhere the second term is multiplied
    by s⁴, with s the share of ẋ lost at μ² = μ₀² + 4 a dt |ẋ|: almost 0 at a regular posture. A joint that
    stretches the arm alone never overshoots, as a dt |ẋ| (1 − s⁴) ≤ σ² for every singular value σ.

    Args:
        bend: a, see `largest_bend` [m/rad²]; 0 for μ₀ everywhere.
        damping: μ₀ [m/rad].
    """
    velocities = np.empty(J.shape[1])
    fill_quiet_solution(J, task_velocity, bend, damping, velocities)
    return velocities


def largest_bend(reach: float, joints: int) -> float:
    """a for `quiet_solution` [m/rad²]: stable for any outstretched arm of revolute joints.

    At rest the line of the pull meets every joint's axis or is parallel to it. Let Λ_k be the distances
    between these points, L their sum (`reach`, along the joints to the hand [m]), and w_k the sum of q̇_i u_i
    up to joint k, with u_i the part of axis i across the line, |u_i| ≤ 1. Then −q̇ᵀ H q̇ = Σ Λ_k |w_k|², and
    Σ Λ_k w_k = 0 in the null space of J. That is L times the variance of w, at most L (joints − 1)/4 times
    |q̇|². Half of it is stable, and does not overshoot if every second axis is along the line.
    """
    return reach * (joints - 1) / 8.0


def pseudo_inverse(J: Array, damping: float = 0.0) -> Array:
    """J^# (n, m), eq. (5), optionally damped; slower than `damped_solution`."""
    return np.asarray(np.linalg.solve(J @ J.T + damping**2 * np.eye(len(J)), J).T, np.float64)


def null_space_projector(J: Array, damping: float = 0.0) -> Array:
    """N = I − J^# J (n, n), eq. (6)."""
    return np.eye(J.shape[1]) - pseudo_inverse(J, damping) @ J


def null_space_basis(J: Array, before: Array | None = None) -> Array:
    """Orthonormal columns (n, n − m) that span the null space of J (m, n); at a singular posture the n − m
    directions with the least effect on the task.

    Args:
        before: basis of a nearby posture (n, n − m), for the nearest basis to it; None for any basis.
    """
    free = np.linalg.svd(J)[2][len(J) :].T
    if before is None:
        return free
    # Orthogonal Procrustes problem: of all bases of this null space, the one with the least sum of squared differences.
    left, _, right = np.linalg.svd(free.T.dot(before))
    return free.dot(left).dot(right)


def swing_and_turns(J: Array) -> Array:
    """Basis (7, 4) of the null space of a hand's position: a motion that does not turn the hand, then three
    that turn it nearly about the world's axes. `J`: position and orientation (6, 7).
    """
    swing = null_space_basis(J)
    turns = null_space_basis(np.vstack([J[:3], swing.T]))
    left, _, right = np.linalg.svd(J[3:].dot(turns))
    return np.column_stack([swing, turns.dot(right.T).dot(left.T)])
