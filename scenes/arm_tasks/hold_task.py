"""A hand that keeps a place."""

from collections.abc import Callable
from typing import Final

import numpy as np

from controllers.kinematics import Arm, Array, damped_solution
from controllers.limits import bounded_task
from controllers.tasks import TASK_DIMENSION, fill_place_task, hold, pose_error, position_error
from scenes.arm_tasks.arm_task import ArmTask, Memory
from scenes.guide import ELBOW_DAMPING, FOLLOW_GAIN, elbow_motion, pull, shortened
from scenes.room import World
from scenes.settings import RunSettings
from scenes.targets import HandTarget, JointTarget, LinkTarget, PairTarget, Target

Path = Callable[[float, Array], tuple[Array, Array]]
"""(time [s], start (3,)) → place (3,) [m] and its velocity (3,) [m/s]."""

_STILL: Final = np.zeros(3)

SELF_MOTION_SPEED: Final = 0.6
"""Largest |q̇₀| towards a posture [rad/s]: 0.1 mm of error at usual gains."""


class HoldTask(ArmTask):
    """q̇_n = J^#(ẋ_d + K e) + N q̇₀, eqs (7), (8): the hand is drawn to its place.

    Args:
        path: motion of the place, or None.
        movable: a person may move the place, pull the elbow or a link, or lead all joints (`HandTarget`,
            `LinkTarget`, `JointTarget`), in the null space (q̇₀).
        overdriven: K is multiplied by `overdrive`.
    """

    def __init__(
        self,
        world: World,
        arm: Arm,
        path: Path | None = None,
        movable: bool = False,
        overdriven: bool = False,
    ) -> None:
        self.joints = arm.joints
        self.place: Array = np.zeros(3)
        """Desired position (3,), world [m]."""
        self.place_rotation: Array = np.eye(3)
        """Desired rotation (3, 3)."""
        self.home: Array = self.place
        """The hand at the beginning (3,), world [m]."""
        self.path_began = -1.0
        """Start time of the path [s]; −1 before that."""
        self._overdriven = overdriven
        self._room, self._kinematics, self._arm = world.room, world.kinematics, arm
        self._path, self._movable = path, movable
        self._pose = world.kinematics.hand_pose(arm)
        # Live views.
        self._joints, self._hand = world.positions[arm.joints], self._pose.translation
        self._spatial = world.kinematics.jacobian[:, arm.joints]
        self._box = world.bounds.part(arm.joints)
        self._bend = world.room.bend(arm)

    def begin(self) -> None:
        self.place = self._pose.translation.copy()
        self.place_rotation = self._pose.rotation.copy()
        self.home = self.place.copy()
        self.path_began = -1.0

    def nominal(self, target: Target | None, settings: RunSettings, time: float) -> Array:
        kinematics, arm, task = self._kinematics, self._arm, self._room.task(settings)
        speed: Array | None = None
        if self._path is not None:
            if self.path_began < 0.0:
                # The path begins at the hand's position when it is chosen.
                self.path_began = time
            self.place, speed = self._path(time - self.path_began, self.home)
        swing: Array | None = None
        # A second person holds this arm; the first one only if it is the only arm.
        target = target.second if isinstance(target, PairTarget) else target if self._movable else None
        if isinstance(target, LinkTarget):
            swing = self._pulled(target, settings)
        elif isinstance(target, HandTarget):
            self._carry(target, settings)
            if target.elbow is not None:
                swing = elbow_motion(kinematics, arm, target.elbow, settings.hand_speed)
        elif isinstance(target, JointTarget):
            swing = shortened((target.positions - self._joints) * FOLLOW_GAIN, SELF_MOTION_SPEED)
        pose = self._pose
        gain = settings.gain * settings.overdrive if self._overdriven else settings.gain
        if task == "position" and swing is None:
            count = len(self._joints)
            J, dq = np.empty((3, count)), np.empty(count)
            velocity = _STILL if speed is None else speed
            where = self._spatial, self._hand, self.place
            self.squared_error = fill_place_task(*where, velocity, gain, self._bend, J, dq)
        else:
            error = (
                position_error(pose, self.place)
                if task == "position"
                else pose_error(pose, self.place, self.place_rotation)
            )
            x, y, z = error[:3].tolist()
            self.squared_error = x * x + y * y + z * z
            J = kinematics.hand_jacobian(arm, TASK_DIMENSION[task])
            dq = hold(J, error, gain, speed, swing, self._bend)
        self._jacobian = J
        return bounded_task(dq, J, self._box, settings.bounds)

    def _pulled(self, target: LinkTarget, settings: RunSettings) -> Array | None:
        """q̇₀ (n,) of a pull [rad/s]; None for a link of the hand, which moves the place."""
        joint = self._arm.joint(target.joint)
        if joint >= self._arm.wrist:
            grip = self._kinematics.data.oMi[joint].act(target.offset)
            self._carry(HandTarget(self._pose.translation + target.position - grip), settings)
            return None
        J, way = pull(self._kinematics, self._arm, target, settings.hand_speed)
        return damped_solution(J, way, ELBOW_DAMPING)

    def _carry(self, target: HandTarget, settings: RunSettings) -> None:
        way = shortened((target.position - self.place) * FOLLOW_GAIN, settings.hand_speed)
        self.place = self.place + way * settings.dt
        if target.rotation is not None:
            self.place_rotation = target.rotation

    def memory(self) -> Memory:
        return self.place.copy(), self.place_rotation.copy(), self.home.copy(), np.array(self.path_began)

    def remember(self, memory: Memory) -> None:
        self.place, self.place_rotation, self.home = (array.copy() for array in memory[:3])
        self.path_began = float(memory[3])
