"""A person's hand on an arm."""

import math
from typing import Final

import numpy as np

from controllers.compiled import Indices, Matrix, Vector, loop
from controllers.kinematics import (
    Arm,
    Array,
    Kinematics,
    damped_solution,
    fill_damped_solution,
    fill_point_jacobian,
)
from scenes.targets import LinkTarget

FOLLOW_GAIN: Final = 8.0
"""[1/s]; also smooths targets that arrive in steps."""

SMOOTHING_TIME: Final = 0.04
"""Time constant of joint velocities [s]: the mass of a person's arm."""

POSTURE_GAIN: Final = 0.6
"""Rate towards the usual posture in the hand's null space [1/s]."""

GUIDE_DAMPING: Final = 0.03
"""[m/rad]; a singular posture feels stiff and does not jump."""

ELBOW_DAMPING: Final = 0.05
"""[m/rad]"""

SATURATIONS: Final = 4
"""Rounds that fix joints at bounds; then q̇ is clipped."""


@loop("void(float64[:, :], float64[:], float64[:], float64[:], float64[:], float64[:])", fills=("dq",))
def fill_inside_box(J: Matrix, task: Vector, free: Vector, lower: Vector, upper: Vector, dq: Vector) -> None:
    """Fill eq. (4), q̇ = J^# ẋ + N q̇₀ (n,); joints at bounds are held, the others compensate.

    Args:
        J: (m, n).
        task: ẋ (m,).
        free: q̇₀ (n,) [rad/s].
        lower, upper: bounds of q̇ (n,) [rad/s].
    """
    m, n = J.shape
    movable, aim, missing, fixed = np.empty((m, n)), np.empty(n), np.empty(m), np.zeros(n)
    for j in range(n):
        aim[j] = free[j]
        for i in range(m):
            movable[i, j] = J[i, j]
    for _ in range(SATURATIONS):
        # J^# (ẋ − J q̇₀) + q̇₀ is J^# ẋ + N q̇₀ without building N.
        for i in range(m):
            missing[i] = task[i]
            for j in range(n):
                missing[i] -= J[i, j] * aim[j]
        fill_damped_solution(movable, missing, GUIDE_DAMPING, dq)
        inside = True
        for j in range(n):
            dq[j] += aim[j]
            if not lower[j] <= dq[j] <= upper[j]:
                inside, fixed[j] = False, 1.0
        if inside:
            return
        for j in range(n):
            if fixed[j]:
                aim[j] = min(max(dq[j], lower[j]), upper[j])
                for i in range(m):
                    movable[i, j] = 0.0
    for j in range(n):
        dq[j] = min(max(dq[j], lower[j]), upper[j])


@loop("float64(float64[:], float64, float64[:], float64[:], float64[:], float64[:])", fills=("dq",))
def fill_smoothed(
    wanted: Vector, share: float, lower: Vector, upper: Vector, reach: Vector, dq: Vector
) -> float:
    """Move q̇ (n,) by a share of the way to `wanted`, within bounds; return Σ |q̇_j| `reach`_j."""
    speed = 0.0
    for j in range(len(dq)):
        dq[j] = min(max(dq[j] + (wanted[j] - dq[j]) * share, lower[j]), upper[j])
        speed += abs(dq[j]) * reach[j]
    return float(speed)


@loop(
    "float64(float64[:, :], float64[:], float64[:], float64[:], float64[:], float64, float64,"
    " float64[:], float64[:], float64[:], float64[:])",
    fills=("dq",),
)
def fill_followed(
    spatial: Matrix,
    hand: Vector,
    posture: Vector,
    positions: Vector,
    place: Vector,
    top_speed: float,
    share: float,
    lower: Vector,
    upper: Vector,
    reach: Vector,
    dq: Vector,
) -> float:
    """`fill_smoothed` towards the q̇ (n,) of a hand that is pulled to a place.

    Args:
        spatial: J (6, n), world axes and origin.
        hand, place: present and desired position (3,), world [m].
        posture, positions: usual and present q (n,) [rad].
        top_speed: of the hand [m/s].
    """
    n = len(dq)
    J, task, free, wanted = np.empty((3, n)), np.empty(3), np.empty(n), np.empty(n)
    square = 0.0
    for i in range(3):
        task[i] = (place[i] - hand[i]) * FOLLOW_GAIN
        square += task[i] * task[i]
    length = math.sqrt(square)
    if length > top_speed:
        for i in range(3):
            task[i] *= top_speed / length
    for j in range(n):
        free[j] = (posture[j] - positions[j]) * POSTURE_GAIN
    fill_point_jacobian(spatial, n, hand, J)
    fill_inside_box(J, task, free, lower, upper, wanted)
    return fill_smoothed(wanted, share, lower, upper, reach, dq)


@loop("float64(float64[:, :], float64[:, :], int64[:], float64[:, :], float64[:])")
def fastest_of(placements: Matrix, ends: Matrix, moving: Indices, J: Matrix, dq: Vector) -> float:
    """Speed of the fastest end of an axis [m/s].

    Args:
        placements: of the ends' joints: rotation by columns, then origin (ends, 12).
        ends: in the frame of the joint (ends, 3) [m].
        moving: number of joints that move each end (ends,).
        J: (6, n), world axes and origin.
        dq: (n,) [rad/s].
    """
    fastest = 0.0
    for k in range(len(ends)):
        M, end = placements[k], ends[k]
        vx = vy = vz = ax = ay = az = 0.0
        for j in range(moving[k]):
            vx += J[0, j] * dq[j]
            vy += J[1, j] * dq[j]
            vz += J[2, j] * dq[j]
            ax += J[3, j] * dq[j]
            ay += J[4, j] * dq[j]
            az += J[5, j] * dq[j]
        px = M[0] * end[0] + M[3] * end[1] + M[6] * end[2] + M[9]
        py = M[1] * end[0] + M[4] * end[1] + M[7] * end[2] + M[10]
        pz = M[2] * end[0] + M[5] * end[1] + M[8] * end[2] + M[11]
        sx, sy, sz = vx + ay * pz - az * py, vy + az * px - ax * pz, vz + ax * py - ay * px
        fastest = max(fastest, sx * sx + sy * sy + sz * sz)
    return math.sqrt(fastest)


def pull(kinematics: Kinematics, arm: Arm, target: LinkTarget, top_speed: float) -> tuple[Array, Array]:
    """J (3, n) of the pulled point and its desired velocity (3,) [m/s]."""
    joint = arm.joint(target.joint)
    point = kinematics.data.oMi[joint].act(target.offset)
    way = shortened((target.position - point) * FOLLOW_GAIN, top_speed)
    return kinematics.point_jacobian(arm, joint, point), way


def elbow_motion(kinematics: Kinematics, arm: Arm, place: Array, top_speed: float) -> Array:
    """q̇₀ (n,) [rad/s] that moves the elbow to a place (3,) [m]."""
    elbow = kinematics.joint_point(arm.elbow)
    J = kinematics.point_jacobian(arm, arm.elbow, elbow)
    return damped_solution(J, shortened((place - elbow) * FOLLOW_GAIN, top_speed), ELBOW_DAMPING)


def shortened(vector: Array, longest: float) -> Array:
    length = float(vector.dot(vector)) ** 0.5
    return vector * (longest / length) if length > longest else vector
