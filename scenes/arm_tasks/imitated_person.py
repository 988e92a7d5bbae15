"""A person who is imitated, as two models for two followers: four angles an arm → joints that are fit to be followed."""

import numpy as np

from controllers.kinematics import Array
from scenes.arm_tasks.arm_task import Memory
from scenes.person.filter import AngleFilter
from scenes.person.retarget import DRIVEN, Retargeter
from scenes.settings import RunSettings
from scenes.targets import AnglesTarget, Target
from scenes.world import World


class ImitatedPerson:
    """Retargets the person's angles once a tick, and filters the joints.

    Args:
        world: with two arms.
    """

    def __init__(self, world: World) -> None:
        start = np.array([world.room.start[arm.joints] for arm in world.room.arms])
        self._start = start
        self._retargeter = Retargeter(world.room.rig)
        # Two in a row, so that not even a wild input makes the desired velocity jump.
        self._filters = AngleFilter(start[:, :DRIVEN]), AngleFilter(start[:, :DRIVEN])
        self._time = -1.0
        self.desired: Array = start.copy()
        """q_d of both arms (2, n) [rad]."""
        self.speed: Array = np.zeros_like(start)
        """Their velocities (2, n) [rad/s]."""

    @property
    def lost_for(self) -> float:
        """Time since the person was last seen [s]; 0 while the person is seen."""
        return self._filters[0].lost_for

    def arm(self, side: int) -> "ImitatedArm":
        """Return one arm as a model to follow; 0 is the left one."""
        return ImitatedArm(self, side)

    def begin(self) -> None:
        """Begin at the room's start posture."""
        self._retargeter.reset(self._start[:, :DRIVEN])
        for stage in self._filters:
            stage.reset(self._start[:, :DRIVEN])
        self.desired[:] = self._start
        self.speed[:] = 0.0
        self._time = -1.0

    def update(self, target: Target | None, settings: RunSettings, time: float) -> None:
        """Take in the person's angles of this tick; the second call of a tick does nothing."""
        if time == self._time:
            return
        self._time = time
        angles = target.angles if isinstance(target, AnglesTarget) else None
        seen = None if angles is None else self._retargeter.joints(angles)
        first, second = self._filters
        self.desired[:, :DRIVEN] = second.step(first.step(seen, settings.dt), settings.dt)
        self.speed[:, :DRIVEN] = second.rates

    def memory(self) -> Memory:
        """Return everything that goes on to the next tick."""
        first, second = self._filters
        return (self.desired.copy(), self.speed.copy(), *first.memory(), *second.memory(), *self._retargeter.memory())

    def remember(self, memory: Memory) -> None:
        """Go on from there."""
        self.desired[:], self.speed[:] = memory[0], memory[1]
        rest = memory[2:]
        for stage in self._filters:
            kept = len(stage.memory())
            stage.remember(rest[:kept])
            rest = rest[kept:]
        self._retargeter.remember(rest)
        self._time = -1.0


class ImitatedArm:
    """One arm of an imitated person.

    Args:
        person: the imitated person.
        side: 0 for the left one.
    """

    def __init__(self, person: ImitatedPerson, side: int) -> None:
        self._person, self._side = person, side

    def begin(self) -> None:
        """Begin at the room's start posture."""
        self._person.begin()

    def angles(self, target: Target | None, settings: RunSettings, time: float) -> tuple[Array, Array]:
        """Return q_d (n,) [rad] and its velocity (n,) [rad/s]."""
        self._person.update(target, settings, time)
        return self._person.desired[self._side].copy(), self._person.speed[self._side]

    def memory(self) -> Memory:
        """Return the whole person's memory."""
        return self._person.memory()

    def remember(self, memory: Memory) -> None:
        """Go on from there."""
        self._person.remember(memory)
