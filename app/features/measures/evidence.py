"""Evidence of a run."""

from collections.abc import Callable
from functools import cached_property
from typing import Final

import numpy as np

from controllers.kinematics import Arm, Array, Kinematics
from scenes.history import COLUMN
from scenes.room import Room, World
from scenes.settings import RunSettings
from scenes.simulation import Simulation

SAMPLES: Final = 600
"""Most rows at which positions are computed."""


class Evidence:
    """Record of a run, with kinematics of its own.

    Args:
        until: later rows do not count [s].
        newest: number of newest rows; None for all.

    Attributes:
        settings, room: at the end of the run.
        table: rows (rows, columns of `scenes.history`), oldest first; perhaps without the run's first.
        arm: with the shown task.
    """

    def __init__(
        self, simulation: Simulation, until: float = float("inf"), newest: int | None = None
    ) -> None:
        self._simulation = simulation
        self.settings: RunSettings = simulation.settings
        self.room: Room = simulation.room
        table = simulation.history.table(newest)
        self.table: Array = table[table[:, COLUMN["t"]] < until - 1e-9]
        self.arm: Arm = simulation.avoiding

    @property
    def rows(self) -> int:
        return len(self.table)

    @property
    def whole(self) -> bool:
        """True if the first step is in the table."""
        return self.rows > 0 and float(self.table[0, COLUMN["t"]]) == 0.0

    @property
    def has_obstacle(self) -> bool:
        """False before the first step."""
        return self.rows > 0 and bool(np.isfinite(self.column("d")).any())

    def column(self, name: str) -> Array:
        """Column (rows,), see `scenes.history.SCALARS`."""
        return self.table[:, COLUMN[name]]

    @property
    def times(self) -> Array:
        """(rows,) [s]."""
        return self.column("t")

    @property
    def positions(self) -> Array:
        """q of everything that moves (rows, nv) [rad, m]."""
        return self._simulation.history.positions(self.table)

    @property
    def velocities(self) -> Array:
        """q̇ of the arm (rows, n) [rad/s]."""
        return self._simulation.history.velocities(self.table)[:, self.arm.joints]

    @property
    def desired(self) -> Array:
        """q_d of the arm (rows, n) [rad], or nan."""
        return self._simulation.history.desired(self.table)[:, self.arm.joints]

    def row_at(self, time: float) -> int | None:
        """Row nearest to a time [s]; None if missing."""
        times, half = self.times, self.settings.dt * 0.75
        if not len(times):
            return None
        row = int(np.abs(times - time).argmin())
        return row if abs(float(times[row]) - time) <= half else None

    @cached_property
    def _world(self) -> World:
        return World(self.room, self.settings.limit_gain)

    @property
    def kinematics(self) -> Kinematics:
        return self._world.kinematics

    def kinematics_at(self, row: int) -> Kinematics:
        self._world.positions[:] = self.positions[row]
        self.kinematics.update(self._world.positions)
        return self.kinematics

    def lever(self, row: int) -> Array:
        """J_d (n,), as the law saw it [m/rad]."""
        self.kinematics_at(row)
        law = self.settings.law
        return self._world.detector.detect(*law.proximity).row[self.arm.joints].copy()

    def hand(self, row: int) -> Array:
        """(3,) [m]."""
        return self.kinematics_at(row).hand_pose(self.arm).translation.copy()

    def elbow(self, row: int) -> Array:
        """(3,) [m]."""
        return self.kinematics_at(row).joint_point(self.arm.elbow)

    def sampled_rows(self) -> list[int]:
        """At most `SAMPLES` evenly spaced rows of a non-empty run, including the last."""
        return sorted({round(x) for x in np.linspace(0, self.rows - 1, min(self.rows, SAMPLES))})

    def along(self, what: Callable[[int], Array]) -> Array:
        """Values at `sampled_rows` (k, …)."""
        return np.array([what(row) for row in self.sampled_rows()])
