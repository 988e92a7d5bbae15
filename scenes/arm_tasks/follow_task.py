"""An arm that follows joint angles: the slave of a master, or one arm of a person's imitation (Fig. 4: direct control of the joints)."""

import numpy as np

from controllers.kinematics import Arm, Array
from controllers.limits import bounded_task
from scenes.arm_tasks.arm_task import ArmTask, Memory
from scenes.room import World
from scenes.settings import RunSettings
from scenes.targets import Target


class JointSource:
    """The model that is followed; one without a memory of its own only says its angles."""

    def begin(self) -> None:
        """Take the present state as where everything begins."""

    def angles(self, target: Target | None, settings: RunSettings, time: float) -> tuple[Array, Array]:
        """Return q_d (n,) [rad] and its velocity (n,) [rad/s]."""
        raise NotImplementedError

    def memory(self) -> Memory:
        """Return everything that goes on to the next step, as copies."""
        return ()

    def remember(self, memory: Memory) -> None:
        """Go on from there."""


class JointFollower(ArmTask):
    """q̇_n = q̇_d + K (q_d − q): eq. (7) with J = I.

    Args:
        world: where.
        arm: which.
        model: whom it follows.
    """

    def __init__(self, world: World, arm: Arm, model: JointSource) -> None:
        self.joints = arm.joints
        self.desired = world.positions[arm.joints].copy()
        self._positions = world.positions[arm.joints]
        self._box = world.bounds.part(arm.joints)
        self._model = model

    def begin(self) -> None:
        """Follow from here."""
        self._model.begin()
        self.desired = self._positions.copy()

    def nominal(self, target: Target | None, settings: RunSettings, time: float) -> Array:
        """Return q̇_n (n,) inside the arm's bounds [rad/s]."""
        desired, speed = self._model.angles(target, settings, time)
        self.desired = desired
        error = desired - self._positions
        self.squared_error = float(error.dot(error))
        error *= settings.gain
        error += speed
        return bounded_task(error, None, self._box, settings.bounds)

    def memory(self) -> Memory:
        """Return the state of the model."""
        return self._model.memory()

    def remember(self, memory: Memory) -> None:
        """Go on from there."""
        self._model.remember(memory)


class Master(JointSource):
    """The other arm, of which every joint is copied: q_d = q_s0 + S (q_m − q_m0), S the identity or the mirror's signs.

    The rig's start postures correspond to each other, wherever the arms are when everything begins. Where one arm has more joints than
    the other, its last ones have no partner: those of a slave stay as they are.

    Args:
        world: where.
        master, slave: who is followed by whom.
        signs: of the mirror (n,).
    """

    def __init__(self, world: World, master: Arm, slave: Arm, signs: Array) -> None:
        self._master, self._slave = world.positions[master.joints], world.positions[slave.joints]
        self._speed = world.velocities[master.joints]
        count = min(len(self._master), len(self._slave))
        self._signs, self._same = (np.pad(s[:count], (0, len(self._slave) - count)) for s in (signs, np.ones_like(signs)))
        self._partner = np.minimum(np.arange(len(self._slave)), count - 1)
        self._from, self._to = world.room.start[master.joints], world.room.start[slave.joints]

    def angles(self, target: Target | None, settings: RunSettings, time: float) -> tuple[Array, Array]:
        """Return q_d (n,) [rad] and its velocity (n,), the master's of the last tick [rad/s]."""
        del target, time
        signs = self._signs if settings.following == "mirrored" else self._same
        return self._to + signs * (self._master - self._from)[self._partner], signs * self._speed[self._partner]
