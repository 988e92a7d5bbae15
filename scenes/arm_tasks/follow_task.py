"""An arm that follows joint angles (Fig. 4: direct control of the joints)."""

import numpy as np

from controllers.kinematics import Arm, Array
from controllers.limits import bounded_task
from scenes.arm_tasks.arm_task import ArmTask
from scenes.room import World
from scenes.settings import RunSettings
from scenes.targets import Target


class JointFollower(ArmTask):
    """q̇_n = q̇_d + K (q_d − q): eq. (7) with J = I."""

    def __init__(self, world: World, arm: Arm) -> None:
        self.joints = arm.joints
        self.desired = world.positions[arm.joints].copy()
        self._positions = world.positions[arm.joints]
        self._box = world.bounds.part(arm.joints)
        self._correction = np.zeros(len(self._positions))
        """K (q_d − q) (n,) [rad/s]."""

    def begin(self) -> None:
        self.desired = self._positions.copy()

    def wanted(self, target: Target | None, settings: RunSettings, time: float) -> tuple[Array, Array]:
        """q_d (n,) [rad] and its velocity (n,) [rad/s]."""
        raise NotImplementedError

    def nominal(self, target: Target | None, settings: RunSettings, time: float) -> Array:
        desired, speed = self.wanted(target, settings, time)
        self.desired = desired
        error = desired - self._positions
        self.squared_error = float(error.dot(error))
        error *= settings.gain
        self._correction = error
        return bounded_task(error + speed, None, self._box, settings.bounds)


class Slave(JointFollower):
    """Every joint copies one of the other arm: q_d = q_s0 + S (q_m − q_m0), S the identity or the mirror's
    signs.

    q_s0 and q_m0 are the rig's start postures. Surplus joints do not move.

    Args:
        signs: of the mirror (n,).
    """

    def __init__(self, world: World, master: Arm, slave: Arm, signs: Array) -> None:
        super().__init__(world, slave)
        self._copied = master.joints
        self._master, self._speed = world.positions[master.joints], world.velocities[master.joints]
        own = len(self._positions)
        count = min(len(self._master), own)
        self._signs, self._same = (np.pad(s[:count], (0, own - count)) for s in (signs, np.ones_like(signs)))
        self._partner = np.minimum(np.arange(own), count - 1)
        self._from, self._to = world.room.start[master.joints], world.room.start[slave.joints]

    def wanted(self, target: Target | None, settings: RunSettings, time: float) -> tuple[Array, Array]:
        """q_d (n,) [rad] and its velocity (n,), the master's of the last step [rad/s]."""
        del target, time
        signs = self._signs if settings.following == "mirrored" else self._same
        return self._to + signs * (self._master - self._from)[self._partner], signs * self._speed[
            self._partner
        ]

    def own_velocity(self, others: slice) -> Array | None:
        """K (q_d − q) (n,), clipped, if `others` are the master's joints."""
        return self._box.clip(self._correction) if others == self._copied else None
