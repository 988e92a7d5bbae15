"""A person's hand on an arm: where the hand should be → how the guided arm moves, at no more than a person's speed."""

from typing import Final, NamedTuple

import numpy as np
import pinocchio as pin

from controllers.kinematics import Arm, Array, Kinematics, damped_solution
from controllers.limits import VelocityBox
from scenes.robots import Robot

FOLLOW_GAIN: Final = 8.0
"""How fast the hand closes the way to where the person wants it [1/s]; also smooths targets that arrive in steps."""

TURN_SPEED: Final = 1.5
"""Largest turning speed of the hand [rad/s]."""

SMOOTHING_TIME: Final = 0.04
"""Time constant of the guided arm's joint velocities [s]: the mass of a person's arm."""

POSTURE_GAIN: Final = 0.6
"""How fast the arm drifts back to its usual posture where that does not move the hand [1/s]."""


GUIDE_DAMPING: Final = 0.03
"""Damping of the guided arm's pseudo-inverse [m/rad]: a person feels a singular posture as stiffness, not as a jump."""

SATURATIONS: Final = 4
"""How often joints at their bounds are taken out before the rest is clipped."""


class HandTarget(NamedTuple):
    """Where the person wants the guided arm.

    Attributes:
        position: of the hand (3,), world [m].
        rotation: of the hand (3, 3), or None if the person does not care.
        elbow: where the person pulls the elbow (3,), world [m], or None.
    """

    position: Array
    rotation: Array | None = None
    elbow: Array | None = None


class Guide:
    """Turns hand targets into velocities of the guided arm.

    The arm follows in its redundancy-resolved way, inside its joint bounds, and no point of its axis (elbow, wrist, hand tip) moves
    faster than `top_speed`; since the normal of a capsule meets its axis, no closest point approaches faster either.

    Args:
        kinematics: of all arms.
        arm: the guided one.
        robot: its make.
        box: its velocity bounds.
        posture: q (n,) it likes to be in [rad].
    """

    def __init__(self, kinematics: Kinematics, arm: Arm, robot: Robot, box: VelocityBox, posture: Array) -> None:
        self.kinematics, self.arm, self.box, self.posture = kinematics, arm, box, posture
        self.velocities = np.zeros(arm.joints.stop - arm.joints.start)
        first = arm.joints.start
        offset = arm.shoulder - robot.shoulder
        self._points = [
            (capsule.joint + offset, capsule.joint + offset - first, point)
            for capsule in robot.capsules
            if capsule.joint
            for point in (capsule.start, capsule.end)
            if capsule.joint != robot.shoulder or point.any()
        ]
        self._cumulated = np.empty((6, len(self.velocities)))

    def reset(self) -> None:
        """Come to rest at once."""
        self.velocities[:] = 0.0

    def follow(self, target: HandTarget | None, positions: Array, dt: float, top_speed: float) -> Array:
        """Return q̇ (n,) of the guided arm for this tick [rad/s]; the array is reused.

        Args:
            target: None lets the arm come to rest where it is.
            positions: q (n,) of the arm.
            dt: [s].
            top_speed: w_max [m/s].
        """
        self.box.update(positions)
        wanted = self._wanted(target, positions, top_speed) if target is not None else 0.0
        dq = self.velocities
        dq += (wanted - dq) * (dt / (SMOOTHING_TIME + dt))
        np.minimum(np.maximum(dq, self.box.lower, out=dq), self.box.upper, out=dq)
        fastest = self.fastest_point(dq)
        if fastest > top_speed:
            dq *= top_speed / fastest
        return dq

    def fastest_point(self, velocities: Array) -> float:
        """Return the speed of the fastest point of the arm's axis at q̇ (n,) [m/s]."""
        kinematics = self.kinematics
        # Column i: the spatial velocity of link i, the sum of what joints 1 … i contribute.
        twists = np.multiply(kinematics.jacobian[:, self.arm.joints], velocities, out=self._cumulated)
        twists = twists.cumsum(axis=1)
        fastest = 0.0
        for joint, column, local in self._points:
            vx, vy, vz, ax, ay, az = twists[:, column - 1].tolist()
            px, py, pz = kinematics.data.oMi[joint].act(local).tolist()
            sx, sy, sz = vx + ay * pz - az * py, vy + az * px - ax * pz, vz + ax * py - ay * px
            fastest = max(fastest, sx * sx + sy * sy + sz * sz)
        return fastest**0.5

    def _wanted(self, target: HandTarget, positions: Array, top_speed: float) -> Array:
        kinematics, arm = self.kinematics, self.arm
        pose = kinematics.hand_pose(arm)
        task = np.empty(3 if target.rotation is None else 6)
        linear = (target.position - pose.translation) * FOLLOW_GAIN
        task[:3] = _shortened(linear, top_speed)
        if target.rotation is not None:
            task[3:] = _shortened(pin.log3(target.rotation.dot(pose.rotation.T)) * FOLLOW_GAIN, TURN_SPEED)
        J = kinematics.hand_jacobian(arm)[: len(task)]
        free = (self.posture - positions) * POSTURE_GAIN
        if target.elbow is not None:
            elbow = kinematics.joint_point(arm.elbow)
            J_elbow = kinematics.point_jacobian(arm, arm.elbow, elbow)
            free = damped_solution(J_elbow, _shortened((target.elbow - elbow) * FOLLOW_GAIN, top_speed), 0.05)
        return self._inside_box(J, task, free)

    def _inside_box(self, J: Array, task: Array, free: Array) -> Array:
        """Return eq. (4), J^# ẋ + N q̇₀, with joints at their bounds taken out and the others doing their share."""
        lower, upper = self.box.lower, self.box.upper
        fixed = np.zeros(len(free), dtype=bool)
        dq = free
        for _ in range(SATURATIONS):
            # J^# (ẋ − J q̇₀) + q̇₀ is J^# ẋ + N q̇₀ without building N.
            dq = damped_solution(np.where(fixed, 0.0, J) if fixed.any() else J, task - J.dot(free), GUIDE_DAMPING) + free
            beyond = (dq < lower) | (dq > upper)
            if not beyond.any():
                break
            fixed |= beyond
            free = np.where(fixed, np.minimum(np.maximum(dq, lower), upper), free)
        return dq


def _shortened(vector: Array, longest: float) -> Array:
    length = float(vector.dot(vector)) ** 0.5
    return vector * (longest / length) if length > longest else vector
