"""One arm alone (eqs 1–8): a hand that stays or draws a circle, and null-space motions."""

from collections.abc import Callable
from functools import cache
from typing import Final

import numpy as np
import pinocchio as pin

from controllers.kinematics import Arm, Array, Kinematics, null_space_basis, pseudo_inverse, swing_and_turns
from scenes.arm_tasks.hold_task import HoldTask
from scenes.rigs import ALONE
from scenes.robots import robot
from scenes.robots.start_search import found_postures
from scenes.roles import NO_TARGETS, Roles, Scenario, Scripted, TargetSource
from scenes.room import Room, World, with_arm
from scenes.setting_spec import makes
from scenes.settings import RunSettings
from scenes.targets import HandTarget

RADIUS: Final = 0.10
"""Radius of the circle [m]."""

LAP: Final = 8.0
"""Time per lap [s]."""

POINTS: Final = 96

ALONE_NAME: Final = "arm"


def circle(time: float, home: Array) -> tuple[Array, Array]:
    """Position (3,) [m] and velocity (3,) [m/s] on an upright circle from home (3,)."""
    phase, rate = 2.0 * np.pi * time / LAP, 2.0 * np.pi / LAP
    s, c = np.sin(phase), np.cos(phase)
    return home + RADIUS * np.array([0.0, s, 1.0 - c]), RADIUS * rate * np.array([0.0, c, s])


@cache
def build_alone(robot_name: str = "lwr") -> Room:
    made, geometry = robot(robot_name), pin.GeometryModel()
    model, arm = with_arm(pin.Model(), geometry, made, ALONE_NAME, ALONE.bases[0])
    return Room(ALONE, (made,), model, geometry, (arm,), alone_start(robot_name))


def alone_start(robot_name: str) -> Array:
    """Start q (n,) [rad] of a single arm."""
    if robot_name == "lwr":
        return ALONE.starts[0].copy()
    return found_postures(robot(robot_name), ALONE.bases[0], ALONE.bases[0], "left", "table")[0]


class Solo(Scenario):
    """No obstacle is near, so no law changes the task."""

    def room(self, settings: RunSettings) -> Room:
        return build_alone(makes(settings.robot)[0])

    def roles(self, world: World, settings: RunSettings) -> Roles:
        arm, drawing = world.room.arms[0], settings.draws_circle
        keeper = HoldTask(world, arm, circle if drawing else None, movable=not drawing, overdriven=True)
        return Roles((keeper,), arm, arm, keeper, None, (keeper,))

    def source(self, world: World, settings: RunSettings) -> TargetSource:
        return NO_TARGETS if settings.draws_circle else elbow_sway(world, settings.seed)

    def way(self, settings: RunSettings, home: Array) -> Array:
        if not settings.draws_circle:
            return super().way(settings, home)
        return np.array([circle(LAP * i / POINTS, home)[0] for i in range(POINTS + 1)])


def swing(kinematics: Kinematics, arm: Arm) -> Callable[[float], HandTarget]:
    """Target that turns the elbow by an angle [rad] about the line from shoulder to wrist.

    Args:
        kinematics: at angle 0.
    """
    pose = kinematics.hand_pose(arm)
    hand, rotation = pose.translation.copy(), pose.rotation.copy()
    shoulder, elbow, wrist = (kinematics.joint_point(j) for j in (arm.shoulder, arm.elbow, arm.wrist))
    axis = (wrist - shoulder) / np.linalg.norm(wrist - shoulder)
    return lambda angle: HandTarget(hand, rotation, shoulder + pin.exp3(axis * angle) @ (elbow - shoulder))


def elbow_sway(world: World, seed: int) -> Scripted:
    """Target that swings the elbow, with the hand at rest."""
    turned, random = swing(world.kinematics, world.room.arms[0]), np.random.default_rng(seed)
    period, angle = float(random.uniform(6.0, 9.0)), float(random.uniform(0.5, 0.8))
    return Scripted(lambda time: turned(angle * np.sin(2.0 * np.pi * time / period)))


MOTIONS: Final = 4
"""7 joints less 3 coordinates of the hand."""

STEP: Final = 0.01
"""Length of a step [rad]; the hand is put back after each."""

PUT_BACK: Final = 1e-3
"""Damping of this correction [m/rad], against a leap near a singular posture."""


def has_null_motions(arm: Arm) -> bool:
    """True if the arm has four null-space motions: the elbow's, and three rotations of the hand."""
    return arm.joints.stop - arm.joints.start == MOTIONS + 3


class NullMotions:
    """Moves an arm of seven joints along its four null-space motions.

    The basis is carried from step to step, so that going back undoes a motion.

    Args:
        positions: initial q (nv,) [rad].

    Attributes:
        gone: path length along each motion (4,) [rad].
    """

    def __init__(self, room: Room, arm: Arm, positions: Array) -> None:
        self._kinematics, self._arm = Kinematics(room.model, room.arms), arm
        self._positions = positions.copy()
        self._low, self._high = (
            room.model.lowerPositionLimit[arm.joints],
            room.model.upperPositionLimit[arm.joints],
        )
        self._kinematics.update(self._positions)
        self._hand = self._kinematics.hand_pose(arm).translation.copy()
        self.basis: Array = swing_and_turns(self._kinematics.hand_jacobian(arm))
        self.gone = np.zeros(MOTIONS)

    @property
    def joints(self) -> Array:
        """q of the arm (7,) [rad]."""
        return self._positions[self._arm.joints].copy()

    def go(self, motion: int, way: float) -> Array:
        """Move along a motion (0 … 3) to a distance from the beginning [rad], or to a joint's limit; return q
        (7,) [rad].
        """
        while abs(left := way - self.gone[motion]) > 1e-9 and self._step(motion, min(max(left, -STEP), STEP)):
            pass
        return self.joints

    def _step(self, motion: int, way: float) -> bool:
        """False, without a step, if a joint would pass its limit."""
        kinematics, arm, before = self._kinematics, self._arm, self.joints
        self._put(before + self.basis[:, motion] * way)
        error = self._hand - kinematics.hand_pose(arm).translation
        self._put(self.joints + pseudo_inverse(kinematics.hand_jacobian(arm, 3), PUT_BACK).dot(error))
        joints = self.joints
        if (joints < self._low).any() or (joints > self._high).any():
            self._put(before)
            return False
        self.basis = null_space_basis(kinematics.hand_jacobian(arm, 3), self.basis)
        self.gone[motion] += way
        return True

    def _put(self, joints: Array) -> None:
        self._positions[self._arm.joints] = joints
        self._kinematics.update(self._positions)
