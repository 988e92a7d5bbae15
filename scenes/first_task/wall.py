"""A wall that a person carries and turns."""

from typing import Final

import numpy as np
import pinocchio as pin

from controllers.first_tasks.points_over_plane import Plane
from controllers.kinematics import Array
from scenes.arm_tasks.arm_task import ArmTask, Memory
from scenes.guide import FOLLOW_GAIN, SMOOTHING_TIME, shortened
from scenes.room import World
from scenes.settings import RunSettings
from scenes.targets import PairTarget, Target, WallTarget

WALL_ROOM: Final = 2.5
"""Largest coordinate of the wall's middle [m]."""

WALL_SPEED: Final = 1.5
"""Top speed along each axis [m/s]."""

WALL_TURN_SPEED: Final = 0.5
"""A person's top speed of turning [rad/s]."""

WALL_TURN: Final = 3.2
"""Largest angle about the vertical, either way [rad]."""

WALL_TILT: Final = 1.6
"""Largest tilt, either way [rad]."""

BASE_CLEAR: Final = 0.20
"""Least distance from the shoulder, which cannot give way [m]."""


def add_wall(model: pin.Model) -> slice:
    """Add the wall's joints to a model (three translations, turn about z, tilt about y); return their columns
    of q.
    """
    first, far = model.nv, np.full(3, WALL_ROOM)
    still = pin.SE3.Identity()
    carried = model.addJoint(
        0, pin.JointModelTranslation(), still, "wall", np.zeros(3), np.full(3, WALL_SPEED), -far, far
    )
    parent = carried
    for joint, name, most in (
        (pin.JointModelRZ(), "wall turn", WALL_TURN),
        (pin.JointModelRY(), "wall tilt", WALL_TILT),
    ):
        ends = np.array([-most]), np.array([most])
        parent = model.addJoint(parent, joint, still, name, np.zeros(1), np.array([WALL_SPEED]), *ends)
    return slice(first, first + 5)


def normal_of(turn: float, tilt: float) -> Array:
    """Normal n (3,): −x, tilted about y, then turned about z; a positive tilt looks up."""
    c = np.cos(tilt)
    return np.array([-c * np.cos(turn), -c * np.sin(turn), np.sin(tilt)])


def angles_of(normal: Array) -> Array:
    """Turn and tilt (2,) [rad] of a normal (3,)."""
    x, y, z = normal.tolist()
    return np.array([np.arctan2(-y, -x), np.arcsin(min(max(z, -1.0), 1.0))])


def turn_of(coordinates: Array) -> Array:
    """Orientation (3, 3) from the wall's coordinates (5,); its first axis points away from the arm."""
    turn, tilt = coordinates[3:].tolist()
    return np.asarray(pin.rpy.rpyToMatrix(0.0, tilt, turn), np.float64)


def plane_of(coordinates: Array) -> Plane:
    """Plane of a wall at rest from its coordinates (5,) [m, rad]."""
    return Plane(normal_of(*coordinates[3:].tolist()), coordinates[:3].copy())


class WallTask(ArmTask):
    """Moves the wall at a person's speed, and stops before the base.

    Args:
        columns: of the wall in q.
    """

    def __init__(self, world: World, columns: slice) -> None:
        self.joints = columns
        self._positions = world.positions[columns]
        self._box = world.bounds.part(columns)
        self._shoulder = world.kinematics.data.oMi[world.room.arms[0].shoulder].translation
        self._velocities = np.zeros(5)
        self.held_back = False
        """True if the wall is as near to the base as allowed, and wanted nearer."""

    def begin(self) -> None:
        self._velocities[:] = 0.0

    def nominal(self, target: Target | None, settings: RunSettings, time: float) -> Array:
        """Velocities of the wall (5,) [m/s, rad/s]; the array is reused."""
        del time
        v, here, dt = self._velocities, self._positions, settings.dt
        wanted = np.zeros(5)
        target = target.first if isinstance(target, PairTarget) else target
        if isinstance(target, WallTarget):
            way = np.concatenate([target.position, target.turn]) - here
            wanted[:3] = shortened(way[:3] * FOLLOW_GAIN, settings.hand_speed)
            wanted[3:] = shortened(way[3:] * FOLLOW_GAIN, WALL_TURN_SPEED)
        v += (wanted - v) * (dt / (SMOOTHING_TIME + dt))
        v[:] = self._box.clip(v)
        # The base cannot get out of the way.
        room = lambda at: float(normal_of(*at[3:].tolist()).dot(self._shoulder - at[:3])) - BASE_CLEAR  # noqa: E731
        ahead = room(here + v * dt)
        self.held_back = ahead < 0.0
        if self.held_back and ahead < room(here):
            v[:] = 0.0
        return v

    def memory(self) -> Memory:
        return (self._velocities.copy(),)

    def remember(self, memory: Memory) -> None:
        self._velocities[:] = memory[0]
