"""A person's hand on an arm: where the hand should be → how the guided arm moves, at no more than a person's speed."""

from typing import Final

import numpy as np
import pinocchio as pin
from scipy.linalg.lapack import dposv

from controllers.kinematics import Arm, Array, Kinematics, damped_solution
from controllers.limits import VelocityBox
from scenes.robots import Robot
from scenes.targets import HandTarget, JointTarget, LinkTarget

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

PULL_DAMPING: Final = 0.1
"""μ of a pulled link [m/rad]: pulls go beyond the reach, and an arm stretched out by one must not tremble."""

PULL_REST: Final = 0.4
"""ρ of a pulled link: how much the hand would rather stay where it is."""

SWEEPS: Final = 4
"""How often the joints of a pulled arm make up, one after the other, for those at their bounds."""

SATURATIONS: Final = 4
"""How often joints at their bounds are taken out before the rest is clipped."""


class Guide:
    """Turns hand targets into velocities of the guided arm, redundancy-resolved and inside its joint bounds.

    No point of its axis (elbow, wrist, hand tip) moves faster than `top_speed`, so no closest point does: a capsule's normal meets it.

    Args:
        robot: its make.
        box: its velocity bounds; to be updated before `follow`.
        posture: q (n,) it likes to be in [rad].
    """

    def __init__(self, kinematics: Kinematics, arm: Arm, robot: Robot, box: VelocityBox, posture: Array) -> None:
        self.kinematics, self.arm, self.box, self.posture = kinematics, arm, box, posture
        self.velocities = np.zeros(arm.joints.stop - arm.joints.start)
        self._hand = kinematics.hand_pose(arm)
        first, offset = arm.joints.start, arm.shoulder - robot.shoulder
        self._reach = _reach(robot)
        # Of every place where an axis ends: its placement, the Jacobian's columns and the velocities that move it (live views), and
        # where it is in the frame of its joint.
        self._points = [
            (
                kinematics.data.oMi[joint + offset],
                kinematics.jacobian[:, first : joint + offset],
                self.velocities[: joint + offset - first],
                point,
            )
            for joint, point in _axis_ends(robot)
        ]

    def reset(self) -> None:
        """Come to rest at once."""
        self.velocities[:] = 0.0

    def follow(
        self, target: HandTarget | JointTarget | LinkTarget | None, positions: Array, dt: float, top_speed: float
    ) -> Array:
        """Return q̇ (n,) of the guided arm for this tick [rad/s]; the array is reused.

        Args:
            target: None lets the arm come to rest where it is.
            positions: q (n,) of the arm.
            dt: [s].
            top_speed: w_max [m/s].
        """
        wanted = self._wanted(target, positions, top_speed) if target is not None else 0.0
        dq = self.velocities
        dq += (wanted - dq) * (dt / (SMOOTHING_TIME + dt))
        np.minimum(np.maximum(dq, self.box.lower, out=dq), self.box.upper, out=dq)
        # Each joint moves no point faster than its rate times the arm's length beyond it: mostly, that settles it.
        if float(np.abs(dq).dot(self._reach)) > top_speed:
            fastest = self.fastest_point()
            if fastest > top_speed:
                dq *= top_speed / fastest
        return dq

    def fastest_point(self) -> float:
        """Return the speed of the fastest point of the arm's axis at the present `velocities` [m/s]."""
        fastest = 0.0
        for placement, jacobian, velocities, local in self._points:
            vx, vy, vz, ax, ay, az = jacobian.dot(velocities).tolist()
            px, py, pz = placement.act(local).tolist()
            sx, sy, sz = vx + ay * pz - az * py, vy + az * px - ax * pz, vz + ax * py - ay * px
            fastest = max(fastest, sx * sx + sy * sy + sz * sz)
        return fastest**0.5

    def _wanted(self, target: HandTarget | JointTarget | LinkTarget, positions: Array, top_speed: float) -> Array:
        if isinstance(target, JointTarget):
            return self.box.clip((target.positions - positions) * FOLLOW_GAIN)
        kinematics, arm = self.kinematics, self.arm
        if isinstance(target, LinkTarget):
            return self._pulled(target, top_speed)
        pose = self._hand
        task = shortened((target.position - pose.translation) * FOLLOW_GAIN, top_speed)
        if target.rotation is not None:
            turn = shortened(pin.log3(target.rotation.dot(pose.rotation.T)) * FOLLOW_GAIN, TURN_SPEED)
            task = np.concatenate([task, turn])
        J = kinematics.hand_jacobian(arm, len(task))
        free = (self.posture - positions) * POSTURE_GAIN
        if target.elbow is not None:
            elbow = kinematics.joint_point(arm.elbow)
            J_elbow = kinematics.point_jacobian(arm, arm.elbow, elbow)
            free = damped_solution(J_elbow, shortened((target.elbow - elbow) * FOLLOW_GAIN, top_speed), 0.05)
        return self._inside_box(J, task, free)

    def _pulled(self, target: LinkTarget, top_speed: float) -> Array:
        """Return q̇ (n,) inside the box with the least |J q̇ − ẋ|² + μ² |q̇|² + ρ² |J_hand q̇|²; it changes steadily with the posture."""
        J, way = pull(self.kinematics, self.arm, target, top_speed)
        J_hand = self.kinematics.hand_jacobian(self.arm, 3)
        gradient = J.T.dot(way)
        hessian = J.T.dot(J) + PULL_REST**2 * J_hand.T.dot(J_hand)
        hessian[np.diag_indices(len(hessian))] += PULL_DAMPING**2
        dq = dposv(hessian, gradient)[1]
        if self.box.contains(dq):
            return dq
        # Projected Gauss-Seidel: joints taken out at their bounds, as in `_inside_box`, would tremble at the edge of the reach.
        dq, lower, upper = self.box.clip(dq), self.box.lower, self.box.upper
        for _ in range(SWEEPS):
            for i, row in enumerate(hessian):
                dq[i] = min(max(dq[i] + (gradient[i] - row.dot(dq)) / row[i], lower[i]), upper[i])
        return dq

    def _inside_box(self, J: Array, task: Array, free: Array) -> Array:
        """Return eq. (4), J^# ẋ + N q̇₀, with joints at their bounds taken out and the others doing their share."""
        lower, upper, movable = self.box.lower, self.box.upper, J
        fixed, dq = None, free
        for _ in range(SATURATIONS):
            # J^# (ẋ − J q̇₀) + q̇₀ is J^# ẋ + N q̇₀ without building N.
            dq = damped_solution(movable, task - J.dot(free), GUIDE_DAMPING)
            dq += free
            if self.box.contains(dq):
                return dq
            beyond = (dq < lower) | (dq > upper)
            fixed = beyond if fixed is None else fixed | beyond
            free = np.where(fixed, np.minimum(np.maximum(dq, lower), upper), free)
            movable = np.where(fixed, 0.0, J)
        return self.box.clip(dq)


def pull(kinematics: Kinematics, arm: Arm, target: LinkTarget, top_speed: float) -> tuple[Array, Array]:
    """Return J (3, n) of the point that is pulled and its wanted velocity (3,) [m/s]."""
    joint = arm.joint(target.joint)
    point = kinematics.data.oMi[joint].act(target.offset)
    way = shortened((target.position - point) * FOLLOW_GAIN, top_speed)
    return kinematics.point_jacobian(arm, joint, point), way


def shortened(vector: Array, longest: float) -> Array:
    """Return a vector (k,), shortened to a length if it is longer."""
    length = float(vector.dot(vector)) ** 0.5
    return vector * (longest / length) if length > longest else vector


def _reach(robot: Robot) -> Array:
    """Return how far the arm reaches beyond each joint at most (n,) [m]: the way along the joints to the farthest capsule end."""
    model = robot.model
    ways = np.array([float(np.linalg.norm(model.jointPlacements[j].translation)) for j in range(1, model.njoints)])
    reach = np.zeros(model.nv)
    for joint, point in _axis_ends(robot):
        beyond = float(np.linalg.norm(point))
        for j in range(joint, 0, -1):
            reach[j - 1] = max(reach[j - 1], beyond)
            beyond += ways[j - 1]
    return reach


def _axis_ends(robot: Robot) -> list[tuple[int, Array]]:
    """Return joint and place in its frame (3,) of every capsule end that moves; ends that are always together count once."""
    data, ends, ways = robot.model.createData(), [], []
    postures = [np.zeros(robot.model.nq), np.full(robot.model.nq, 0.3), np.full(robot.model.nq, -0.7)]
    for capsule in robot.capsules:
        for point in (capsule.start, capsule.end):
            way: list[Array] = []
            for q in postures:
                pin.forwardKinematics(robot.model, data, q)
                way.append(data.oMi[capsule.joint].act(point))
            if np.allclose(way, way[0]) or any(np.allclose(way, other) for other in ways):
                continue
            ways.append(way)
            ends.append((capsule.joint, point))
    return ends
