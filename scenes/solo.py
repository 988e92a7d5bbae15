"""One arm alone (eqs 1–8): a hand that keeps its place or draws a circle, and an elbow that is free to move."""

from typing import Final

import numpy as np
import pinocchio as pin

from controllers.kinematics import Array
from scenes.arm_tasks.hold_task import HoldTask
from scenes.roles import NoSource, Roles, TargetSource
from scenes.settings import RunSettings
from scenes.targets import HandTarget
from scenes.world import World

RADIUS: Final = 0.10
"""Of the circle [m]."""

LAP: Final = 8.0
"""Time of a lap [s]."""


def circle(time: float, home: Array) -> tuple[Array, Array]:
    """Return where the hand should be (3,) [m] and its velocity (3,) [m/s] on an upright circle that begins at home (3,)."""
    phase, rate = 2.0 * np.pi * time / LAP, 2.0 * np.pi / LAP
    s, c = np.sin(phase), np.cos(phase)
    return home + RADIUS * np.array([0.0, s, 1.0 - c]), RADIUS * rate * np.array([0.0, c, s])


def roles(world: World, settings: RunSettings) -> Roles:
    """Return the roles. No obstacle is near, so that no law changes the task."""
    arm = world.room.arms[0]
    drawing = settings.path == "circle"
    keeper = HoldTask(world, arm, circle if drawing else None, movable=not drawing, overdriven=True)
    return Roles((keeper,), arm, arm, keeper, None, (keeper,))


def source(world: World, settings: RunSettings) -> TargetSource:
    """Return the source that moves the elbow."""
    return NoSource() if settings.path == "circle" else ElbowSway(world, settings.seed)


class ElbowSway:
    """Swings the elbow to and fro about the line from shoulder to wrist, while the hand stays.

    Args:
        world: a room with one arm, as it stands now.
        seed: which person.
    """

    def __init__(self, world: World, seed: int) -> None:
        kinematics, arm = world.kinematics, world.room.arms[0]
        pose = kinematics.hand_pose(arm)
        self._hand, self._rotation = pose.translation.copy(), pose.rotation.copy()
        self._shoulder, self._elbow, wrist = (kinematics.joint_point(j) for j in (arm.shoulder, arm.elbow, arm.wrist))
        way = wrist - self._shoulder
        self._axis = way / np.linalg.norm(way)
        random = np.random.default_rng(seed)
        self._period, self._angle = float(random.uniform(6.0, 9.0)), float(random.uniform(0.5, 0.8))

    def target(self, time: float) -> HandTarget:
        """Return where hand and elbow should be at a time [s]."""
        turn = pin.exp3(self._axis * (self._angle * np.sin(2.0 * np.pi * time / self._period)))
        return HandTarget(self._hand, self._rotation, self._shoulder + turn @ (self._elbow - self._shoulder))
