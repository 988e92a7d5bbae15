"""The arm that a person holds, at no more than a person's speed."""

from typing import Final

import numpy as np
import pinocchio as pin
from scipy.linalg.lapack import dposv

from controllers.kinematics import Arm, Array
from scenes.arm_tasks.arm_task import ArmTask, Memory
from scenes.guide import (
    FOLLOW_GAIN,
    POSTURE_GAIN,
    SMOOTHING_TIME,
    elbow_motion,
    fastest_of,
    fill_followed,
    fill_inside_box,
    fill_smoothed,
    pull,
    shortened,
)
from scenes.robots import Robot
from scenes.room import World
from scenes.settings import RunSettings
from scenes.targets import HandTarget, JointTarget, LinkTarget, PairTarget, Target

TURN_SPEED: Final = 1.5
"""Largest angular speed of the hand [rad/s]."""

PULL_DAMPING: Final = 0.1
"""μ of a pulled link [m/rad], against trembling beyond the reach."""

PULL_REST: Final = 0.4
"""ρ of a pulled link: weight of the hand's motion."""

SWEEPS: Final = 4
"""Rounds in which the other joints compensate for those at their bounds."""


class GuidedTask(ArmTask):
    """Follows a hand, an elbow, a pulled link or joint positions inside the joint bounds.

    No point of its axis (elbow, wrist, hand tip) is faster than `hand_speed`, so no closest point is: a
    capsule's normal meets the axis.
    """

    def __init__(self, world: World, arm: Arm, robot: Robot) -> None:
        self.joints = arm.joints
        self._kinematics, self._arm = world.kinematics, arm
        self._positions, self._box = world.positions[arm.joints], world.bounds.part(arm.joints)
        self._posture = world.room.start[arm.joints]
        """Usual q (n,) [rad]."""
        self._velocities, self._wish, self._rest = np.zeros((3, len(self._posture)))
        self._hand = world.kinematics.hand_pose(arm)
        self._place = self._hand.translation
        self._reach, ends = _reach(robot), _axis_ends(robot)
        first, offset = arm.joints.start, arm.shoulder - robot.shoulder
        self._ends = np.array([point for _, point in ends])
        self._moving = np.array([joint + offset - first for joint, _ in ends])
        self._spatial = world.kinematics.jacobian[:, arm.joints]
        placed = [world.kinematics.data.oMi[joint + offset] for joint, _ in ends]
        # Live views of Pinocchio's memory.
        self._placed = [view for M in placed for view in (M.rotation.T.reshape(-1), M.translation)]
        self._placements = np.empty((len(ends), 12))

    @property
    def task_jacobian(self) -> Array:
        return self._kinematics.hand_jacobian(self._arm, 3) if self._jacobian is None else self._jacobian

    def begin(self) -> None:
        self._velocities[:] = 0.0

    def nominal(self, target: Target | None, settings: RunSettings, time: float) -> Array:
        """q̇ (n,) [rad/s]; the array is reused. Without a target the arm comes to rest."""
        del time
        # The camera's last frame is evaluated later, with the arms of that time.
        held = settings.hardware.frame_rate > 0.0
        self._jacobian = self._kinematics.hand_jacobian(self._arm, 3) if held else None
        target = target.first if isinstance(target, PairTarget) else target
        dq, box, share, top_speed = (
            self._velocities,
            self._box,
            settings.dt / (SMOOTHING_TIME + settings.dt),
            settings.hand_speed,
        )
        if isinstance(target, HandTarget) and target.rotation is None and target.elbow is None:
            arm = self._spatial, self._place, self._posture, self._positions
            speed = fill_followed(
                *arm, target.position, top_speed, share, box.lower, box.upper, self._reach, dq
            )
        else:
            speed = fill_smoothed(
                self._wanted(target, top_speed), share, box.lower, box.upper, self._reach, dq
            )
        # Bound by each joint's rate times the arm's length beyond it; usually enough.
        if speed > top_speed:
            np.concatenate(self._placed, out=self._placements.reshape(-1))
            fastest = fastest_of(self._placements, self._ends, self._moving, self._spatial, dq)
            if fastest > top_speed:
                dq *= top_speed / fastest
        return dq

    def _wanted(self, target: Target | None, top_speed: float) -> Array:
        if isinstance(target, JointTarget):
            return self._box.clip((target.positions - self._positions) * FOLLOW_GAIN)
        if isinstance(target, LinkTarget):
            return self._pulled(target, top_speed)
        if not isinstance(target, HandTarget):
            return self._rest
        pose = self._hand
        task = shortened((target.position - pose.translation) * FOLLOW_GAIN, top_speed)
        if target.rotation is not None:
            turn = shortened(pin.log3(target.rotation.dot(pose.rotation.T)) * FOLLOW_GAIN, TURN_SPEED)
            task = np.concatenate([task, turn])
        J = self._kinematics.hand_jacobian(self._arm, len(task))
        free = (self._posture - self._positions) * POSTURE_GAIN
        if target.elbow is not None:
            free = elbow_motion(self._kinematics, self._arm, target.elbow, top_speed)
        fill_inside_box(J, task, free, self._box.lower, self._box.upper, self._wish)
        return self._wish

    def _pulled(self, target: LinkTarget, top_speed: float) -> Array:
        """q̇ (n,) inside the box with the least |J q̇ − ẋ|² + μ² |q̇|² + ρ² |J_hand q̇|²; continuous in the
        posture.
        """
        J, way = pull(self._kinematics, self._arm, target, top_speed)
        J_hand = self._kinematics.hand_jacobian(self._arm, 3)
        gradient = J.T.dot(way)
        hessian = J.T.dot(J) + PULL_REST**2 * J_hand.T.dot(J_hand)
        hessian[np.diag_indices(len(hessian))] += PULL_DAMPING**2
        dq = dposv(hessian, gradient)[1]
        if self._box.contains(dq):
            return dq
        # Projected Gauss-Seidel: taking joints out at their bounds would make the arm tremble when stretched.
        dq, lower, upper = self._box.clip(dq), self._box.lower, self._box.upper
        for _ in range(SWEEPS):
            for i, row in enumerate(hessian):
                dq[i] = min(max(dq[i] + (gradient[i] - row.dot(dq)) / row[i], lower[i]), upper[i])
        return dq

    def memory(self) -> Memory:
        return (self._velocities.copy(),)

    def remember(self, memory: Memory) -> None:
        self._velocities[:] = memory[0]


def _reach(robot: Robot) -> Array:
    """Reach beyond each joint (n,) [m]: along the joints to the farthest capsule end."""
    model = robot.model
    ways = np.array(
        [float(np.linalg.norm(model.jointPlacements[j].translation)) for j in range(1, model.njoints)]
    )
    reach = np.zeros(model.nv)
    for joint, point in _axis_ends(robot):
        beyond = float(np.linalg.norm(point))
        for j in range(joint, 0, -1):
            reach[j - 1] = max(reach[j - 1], beyond)
            beyond += ways[j - 1]
    return reach


def _axis_ends(robot: Robot) -> list[tuple[int, Array]]:
    """Joint and position in its frame (3,) of all different moving capsule ends."""
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
