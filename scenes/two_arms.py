"""Two arms, one moved by a person: the other keeps its hand in place (Fig. 5), or follows joint by joint
(Fig. 6).
"""

from typing import Final

import numpy as np
import pinocchio as pin

from controllers.kinematics import Array, Kinematics
from scenes.arm_tasks.follow_task import Slave
from scenes.arm_tasks.guided_task import GuidedTask
from scenes.arm_tasks.hold_task import HoldTask
from scenes.opening import OPENING, Opening, begins_with_opening
from scenes.roles import Roles, Scenario, TargetSource
from scenes.room import Room, World, build_room
from scenes.settings import ArmName, RunSettings
from scenes.targets import HandTarget, quintic


class Hold(Scenario):
    def room(self, settings: RunSettings) -> Room:
        return build_room(settings.rig, settings.robot)

    def roles(self, world: World, settings: RunSettings) -> Roles:
        room = world.room
        guided, avoiding = room.arm(settings.guided), room.other(settings.guided)
        held = GuidedTask(world, guided, room.robots[room.arms.index(guided)])
        keeper = HoldTask(world, avoiding)
        return Roles((held, keeper), guided, avoiding, keeper, held, (keeper,))

    def source(self, world: World, settings: RunSettings) -> TargetSource:
        start = world.kinematics.hand_pose(world.room.arm(settings.guided)).translation.copy()
        return Autopilot(world.room, settings.guided, settings.seed, start)

    def opening(self, world: World, settings: RunSettings) -> TargetSource | None:
        """Scripted push, then the autopilot; None for other arms and tasks."""
        if not begins_with_opening(settings):
            return None
        start = world.kinematics.hand_pose(world.room.arm(settings.guided)).translation.copy()
        return Opening(
            start, Autopilot(world.room, settings.guided, settings.seed, np.array(OPENING[-1].place))
        )


class MasterSlave(Hold):
    """The other arm follows the joints of the first; both avoid."""

    def roles(self, world: World, settings: RunSettings) -> Roles:
        room = world.room
        master, slave = room.arm(settings.guided), room.other(settings.guided)
        made = room.robots[room.arms.index(master)]
        held = GuidedTask(world, master, made)
        data = made.model.createData()
        axes = pin.computeJointJacobians(made.model, data, pin.neutral(made.model))[3:].copy()
        follower = Slave(world, master, slave, mirror_signs(axes))
        return Roles((held, follower), master, slave, follower, held, (follower, held))


def mirror_signs(axes: Array) -> Array:
    """(n,) +1 for every joint that keeps its sign in a mirror between left and right, else −1.

    Args:
        axes: (3, n) at q = 0, base frame, y to the left; a mirror reverses rotations about axes in its plane.
    """
    return np.where(abs(axes[1]) < 0.5, -1.0, 1.0)


SPEED_RANGE: Final = (0.10, 0.22)
"""Peak speed of a move [m/s]."""

PAUSE_RANGE: Final = (0.4, 1.2)
"""Rest between two moves [s]."""


class Autopilot:
    """Position of the guided hand as a pure function of time and seed: quintics from rest to rest, by turns
    to a random place on the other arm and near home.

    Args:
        start: the hand at time 0 (3,) [m]; None for the room's start.
    """

    def __init__(self, room: Room, guided: ArmName, seed: int, start: Array | None = None) -> None:
        kinematics = Kinematics(room.model, room.arms)
        kinematics.update(room.start)
        other = room.other(guided)
        elbow, wrist = kinematics.joint_point(other.elbow), kinematics.joint_point(other.wrist)
        hand = kinematics.hand_pose(other).translation.copy()
        self._places = (hand, wrist, (elbow + wrist) / 2.0)
        self._home = kinematics.hand_pose(room.arm(guided)).translation.copy()
        self._random = np.random.default_rng(seed)
        self._begin = self._home if start is None else np.array(start, float)
        # Begin, duration, from and to of each move.
        self._moves: list[tuple[float, float, Array, Array]] = []
        self._end = 0.0

    def target(self, time: float) -> HandTarget:
        while self._end <= time:
            self._plan_move()
        move = self._moves[-1]
        if move[0] > time:
            move = next(move for move in reversed(self._moves) if move[0] <= time)
        start, duration, a, b = move
        share, _ = quintic(min((time - start) / duration, 1.0))
        return HandTarget(a + (b - a) * share)

    def _plan_move(self) -> None:
        random = self._random
        a = self._moves[-1][3] if self._moves else self._begin
        if len(self._moves) % 2 == 0:
            b = self._places[random.integers(len(self._places))] + random.uniform(-0.06, 0.06, 3)
        else:
            b = self._home + random.uniform(-0.10, 0.10, 3)
        # A quintic from rest to rest peaks at 15/8 of its mean speed.
        duration = max(1.875 * float(np.linalg.norm(b - a)) / random.uniform(*SPEED_RANGE), 0.5)
        self._moves.append((self._end, duration, a, b))
        self._end += duration + random.uniform(*PAUSE_RANGE)
