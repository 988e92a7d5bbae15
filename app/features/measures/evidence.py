"""A run, finished or still going on, as it can be measured. Nothing here touches the simulation's own kinematics."""

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
"""Rows of a run at which a place that has to be computed from the joints is looked at, at most."""


class Evidence:
    """What a run has left behind.

    Args:
        until: rows from this time on do not count [s].
        newest: number of the newest rows; None for all.

    Attributes:
        settings, room: with which the run ended, and where it is.
        table: its rows (rows, columns of `scenes.history`), oldest first; the history may have forgotten the first of them.
        arm: the arm with the shown task.
    """

    def __init__(self, simulation: Simulation, until: float = float("inf"), newest: int | None = None) -> None:
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
        """True if the run is here from its first step on."""
        return self.rows > 0 and float(self.table[0, COLUMN["t"]]) == 0.0

    @property
    def has_obstacle(self) -> bool:
        """True if there is something to keep clear of, and a step was made."""
        return self.rows > 0 and bool(np.isfinite(self.column("d")).any())

    def column(self, name: str) -> Array:
        """Return one column (rows,), see `scenes.history.SCALARS`."""
        return self.table[:, COLUMN[name]]

    @property
    def times(self) -> Array:
        """Time of every row (rows,) [s]."""
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
        """q_d of the arm (rows, n) [rad], nan where it follows nothing."""
        return self._simulation.history.desired(self.table)[:, self.arm.joints]

    def row_at(self, time: float) -> int | None:
        """Return the row nearest to a time [s]; None if the run does not reach it, or has forgotten it."""
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
        """Return the kinematics with the arms as they were in a row."""
        self._world.positions[:] = self.positions[row]
        self.kinematics.update(self._world.positions)
        return self.kinematics

    def lever(self, row: int) -> Array:
        """Return J_d (n,) of the arm in a row, as the law saw it [m/rad]."""
        self.kinematics_at(row)
        law = self.settings.law
        return self._world.detector.detect(*law.proximity).row[self.arm.joints].copy()

    def hand(self, row: int) -> Array:
        """Place of the arm's hand (3,) [m]."""
        return self.kinematics_at(row).hand_pose(self.arm).translation.copy()

    def elbow(self, row: int) -> Array:
        """Place of the arm's elbow (3,) [m]."""
        return self.kinematics_at(row).joint_point(self.arm.elbow)

    def sampled_rows(self) -> list[int]:
        """Return evenly spaced rows of the whole run, which has some: at most `SAMPLES`, the last one among them."""
        return sorted({round(x) for x in np.linspace(0, self.rows - 1, min(self.rows, SAMPLES))})

    def along(self, what: Callable[[int], Array]) -> Array:
        """Return something at the rows of `sampled_rows` (k, …)."""
        return np.array([what(row) for row in self.sampled_rows()])
