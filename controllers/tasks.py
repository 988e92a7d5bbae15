"""What an arm is asked to do, as a desired joint velocity q̇_n, eqs (7), (8)."""

from typing import Final, Literal

import numpy as np
import pinocchio as pin

from controllers.kinematics import Arm, Array, Kinematics, damped_solution

HoldTask = Literal["position", "pose"]
"""What the hand keeps: where it is (3 dimensions), or also how it is turned (6)."""

TASK_DIMENSION: Final[dict[HoldTask, int]] = {"position": 3, "pose": 6}


def position_error(pose: pin.SE3, target_position: Array) -> Array:
    """Return e = p_d − p (3,) [m], eq. (8)."""
    return target_position - pose.translation


def pose_error(pose: pin.SE3, target_position: Array, target_rotation: Array) -> Array:
    """Return e = (p_d − p, log₃(R_d Rᵀ)) (6,) [m, rad], eq. (8), world axes.

    Position and orientation are decoupled: the logarithm on SE(3) would let a wrong orientation bend the path of the hand.
    """
    error = np.empty(6)
    np.subtract(target_position, pose.translation, out=error[:3])
    error[3:] = pin.log3(target_rotation.dot(pose.rotation.T))
    return error


def hold(kinematics: Kinematics, arm: Arm, task: HoldTask, error: Array, gain: float) -> Array:
    """Return q̇_n = J^# K e (n,) [rad/s], eq. (7) with ẋ_d = 0.

    Args:
        error: e (m,) of `position_error` or `pose_error`; the position task reads its first three entries only.
        gain: K [1/s].
    """
    J = kinematics.hand_jacobian(arm)
    m = TASK_DIMENSION[task]
    return damped_solution(J[:m], gain * error[:m])
