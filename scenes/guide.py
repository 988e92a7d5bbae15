"""A person's hand on an arm: where the hand should be → how the guided arm moves, at no more than a person's speed."""

import math
from typing import Final

import numpy as np
import pinocchio as pin
from scipy.linalg.lapack import dposv

from controllers.compiled import FilledVector, Indices, Loop, Matrix, Vector
from controllers.kinematics import Arm, Array, Kinematics, damped_solution, fill_damped_solution, fill_point_jacobian
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

ELBOW_DAMPING: Final = 0.05
"""Damping of the elbow's pseudo-inverse [m/rad]."""

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
        self._wish, self._rest = np.zeros(len(self.velocities)), np.zeros(len(self.velocities))
        self._hand = kinematics.hand_pose(arm)
        self._place = self._hand.translation
        first, offset = arm.joints.start, arm.shoulder - robot.shoulder
        self._reach = _reach(robot)
        ends = _axis_ends(robot)
        self._ends = np.array([point for _, point in ends])
        self._moving = np.array([joint + offset - first for joint, _ in ends])
        self._jacobian = kinematics.jacobian[:, arm.joints]
        placed = [kinematics.data.oMi[joint + offset] for joint, _ in ends]
        # Live views of Pinocchio's memory.
        self._placed = [view for M in placed for view in (M.rotation.T.reshape(-1), M.translation)]
        self._placements = np.empty((len(ends), 12))

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
        dq, box, share = self.velocities, self.box, dt / (SMOOTHING_TIME + dt)
        if isinstance(target, HandTarget) and target.rotation is None and target.elbow is None:
            arm = self._jacobian, self._place, self.posture, positions
            speed = fill_followed(*arm, target.position, top_speed, share, box.lower, box.upper, self._reach, dq)
        else:
            wanted = self._wanted(target, positions, top_speed) if target is not None else self._rest
            speed = fill_smoothed(wanted, share, box.lower, box.upper, self._reach, dq)
        # Each joint moves no point faster than its rate times the arm's length beyond it: mostly, that settles it.
        if speed > top_speed:
            fastest = self.fastest_point()
            if fastest > top_speed:
                dq *= top_speed / fastest
        return dq

    def fastest_point(self) -> float:
        """Return the speed of the fastest point of the arm's axis at the present `velocities` [m/s]."""
        np.concatenate(self._placed, out=self._placements.reshape(-1))
        return fastest_of(self._placements, self._ends, self._moving, self._jacobian, self.velocities)

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
            free = elbow_motion(kinematics, arm, target.elbow, top_speed)
        fill_inside_box(J, task, free, self.box.lower, self.box.upper, self._wish)
        return self._wish

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


@Loop
def fill_inside_box(J: Matrix, task: Vector, free: Vector, lower: Vector, upper: Vector, dq: FilledVector) -> None:
    """Fill eq. (4), q̇ = J^# ẋ + N q̇₀ (n,), with joints at their bounds taken out and the others doing their share.

    Args:
        J: (m, n).
        task: ẋ (m,).
        free: q̇₀ (n,), which moves the arm where that does not move the hand [rad/s].
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


@Loop
def fill_smoothed(wanted: Vector, share: float, lower: Vector, upper: Vector, reach: Vector, dq: FilledVector) -> float:
    """Bring q̇ (n,) nearer to what is wanted by a share of the difference, within its bounds, and return Σ |q̇_j| times `reach` (n,)."""
    speed = 0.0
    for j in range(len(dq)):
        dq[j] = min(max(dq[j] + (wanted[j] - dq[j]) * share, lower[j]), upper[j])
        speed += abs(dq[j]) * reach[j]
    return float(speed)


@Loop
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
    dq: FilledVector,
) -> float:
    """Bring q̇ (n,) nearer to that of a hand which is drawn to a place, and return what `fill_smoothed` does.

    Args:
        spatial: of the arm's joints (6, n), world axes and the world's origin.
        hand, place: where it is, and where the person wants it (3,), world [m].
        posture, positions: q (n,) it likes to be in, and now [rad].
        top_speed: of the hand [m/s].
        share, lower, upper, reach: see `fill_smoothed`.
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


@Loop
def fastest_of(placements: Matrix, ends: Matrix, moving: Indices, J: Matrix, dq: Vector) -> float:
    """Return the speed of the fastest end of an axis [m/s].

    Args:
        placements: of the ends' joints: rotation by columns, then origin (ends, 12).
        ends: in the frame of its joint (ends, 3) [m].
        moving: how many of the arm's joints move it (ends,).
        J: (6, n), world axes and origin.
        dq: q̇ (n,) [rad/s].
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
    """Return J (3, n) of the point that is pulled and its wanted velocity (3,) [m/s]."""
    joint = arm.joint(target.joint)
    point = kinematics.data.oMi[joint].act(target.offset)
    way = shortened((target.position - point) * FOLLOW_GAIN, top_speed)
    return kinematics.point_jacobian(arm, joint, point), way


def elbow_motion(kinematics: Kinematics, arm: Arm, place: Array, top_speed: float) -> Array:
    """Return q̇₀ (n,) [rad/s] that brings the elbow to where a person pulls it (3,) [m]."""
    elbow = kinematics.joint_point(arm.elbow)
    J = kinematics.point_jacobian(arm, arm.elbow, elbow)
    return damped_solution(J, shortened((place - elbow) * FOLLOW_GAIN, top_speed), ELBOW_DAMPING)


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
