"""The arm's task as a desired joint velocity q̇_n, eqs (7), (8)."""

from typing import Final

import numpy as np
import pinocchio as pin

from controllers.choices import HandTask
from controllers.compiled import Matrix, Vector, loop
from controllers.kinematics import DAMPING, Array, fill_point_jacobian, fill_quiet_solution, quiet_solution

TASK_DIMENSION: Final[dict[HandTask, int]] = {"position": 3, "pose": 6}


def position_error(pose: pin.SE3, target_position: Array) -> Array:
    """e = p_d − p (3,) [m], eq. (8)."""
    return target_position - pose.translation


def pose_error(pose: pin.SE3, target_position: Array, target_rotation: Array) -> Array:
    """e = (p_d − p, log₃(R_d Rᵀ)) (6,) [m, rad], eq. (8), world axes, for p_d (3,) [m] and R_d (3, 3).

    The logarithm on SE(3) would let a wrong orientation bend the hand's path.
    """
    error = np.empty(6)
    np.subtract(target_position, pose.translation, out=error[:3])
    error[3:] = pin.log3(target_rotation.dot(pose.rotation.T))
    return error


@loop(
    "float64(float64[:, :], float64[:], float64[:], float64[:], float64, float64, float64[:, :], float64[:])",
    fills=("J", "dq"),
)
def fill_place_task(
    spatial: Matrix,
    hand: Vector,
    place: Vector,
    velocity: Vector,
    gain: float,
    bend: float,
    J: Matrix,
    dq: Vector,
) -> float:
    """Fill J (3, n) of the hand's position and q̇_n = J^#(ẋ_d + K e) (n,), eqs (2), (7), (8); return |e|²
    [m²].

    Args:
        spatial: the arm's columns of `Kinematics.jacobian` (6, n).
        hand, place: present and desired position (3,), world [m].
        velocity, gain: ẋ_d (3,) [m/s], K [1/s].
        bend: see `quiet_solution`.
    """
    task, squared = np.empty(3), 0.0
    for i in range(3):
        e = place[i] - hand[i]
        squared += e * e
        task[i] = gain * e + velocity[i]
    fill_point_jacobian(spatial, spatial.shape[1], hand, J)
    fill_quiet_solution(J, task, bend, DAMPING, dq)
    return squared


def hold(
    J: Array,
    error: Array,
    gain: float,
    velocity: Array | None = None,
    free: Array | None = None,
    bend: float = 0.0,
) -> Array:
    """q̇_n = J^#(ẋ_d + K e) + N q̇₀ (n,) [rad/s], eqs (4), (7), for J (m, n) and e (m,).

    Args:
        gain: K [1/s].
        velocity: first entries of ẋ_d; None at rest.
        free: q̇₀ (n,), joint motion in the null space; None for zero.
        bend: see `quiet_solution` [m/rad²].
    """
    task = gain * error
    if velocity is not None:
        task[: len(velocity)] += velocity
    if free is None:
        return quiet_solution(J, task, bend)
    # J^# (ẋ − J q̇₀) + q̇₀ is J^# ẋ + N q̇₀ without building N.
    return quiet_solution(J, task - J.dot(free), bend) + free
