"""Which steps of a run the visitor looks at one by one, and the same steps at half the time step, computed in the background."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from app.runtime.job_pool import Job, Jobs
from app.runtime.job_watch import JobWatch
from controllers.kinematics import Array
from scenes.history import COLUMN, History
from scenes.inputs import Recorded
from scenes.simulation import Simulation
from scenes.single_steps import AROUND, avoiding_rates, finer_rows, largest_jump, rows_around

Quantity = Literal["d", "lambda", "dq", "e"]

WINDOW: Final = 20.0
"""How far back an instant may lie [s]: what the plots show."""

STRIDE: Final = 10
"""Steps by which the instant is moved."""


@dataclass(frozen=True, eq=False)
class Steps:
    """One signal, step by step.

    Attributes:
        dt: time step [s].
        times: (k,) [s].
        values: (k,) in SI units.
    """

    dt: float
    times: Array
    values: Array

    @property
    def largest(self) -> float:
        """The largest change from one step to the next."""
        return float(np.abs(np.diff(self.values)).max(initial=0.0))


@dataclass(frozen=True, eq=False)
class Magnified:
    """What is seen.

    Attributes:
        joint: number of the joint, from 0, of which q̇ is shown: the one that jumps most.
        steps: of the run.
        finer: of the same inputs in finer steps; None while they are computed, or where they cannot be.
    """

    time: float
    quantity: Quantity
    joint: int
    steps: Steps
    finer: Steps | None


class Microscope:
    """The instant and the signal that one visitor looks at. All methods belong to the session's thread.

    Args:
        background: where the finer steps are computed; None where they are not.
        wake: called, from any thread, when they are there.
    """

    def __init__(self, background: Jobs | None, wake: Callable[[], None]) -> None:
        self._jobs = None if background is None else JobWatch(background, wake, self._failed)
        self.quantity: Quantity = "dq"
        self._time: float | None = None
        self._shown = 0.0
        self._asked: tuple[History, float, float, bool] | None = None
        self._finer: Array | None = None

    def look_at(self, quantity: Quantity) -> None:
        self.quantity = quantity

    def find_jump(self) -> None:
        """Go to the largest step of q̇, and follow it."""
        self._time = None

    def move(self, steps: int, dt: float) -> None:
        """Go so many steps of `dt` [s] on."""
        self._time = self._shown + steps * dt

    def magnify(self, simulation: Simulation, window: Callable[[float], Recorded | None]) -> Magnified | None:
        """Return what is seen of a run; None before its second step.

        Args:
            window: gives the newest piece of its inputs of a length [s].
        """
        if self._jobs is not None:
            self._jobs.collect()
        dt = simulation.settings.dt
        table = simulation.history.table(round(WINDOW / dt))
        if len(table) < 2:
            return None
        times, rates = table[:, COLUMN["t"]], avoiding_rates(simulation, table)
        time = largest_jump(times, rates, dt) if self._time is None else self._time
        time = self._shown = float(times[int(np.argmin(np.abs(times - time)))])
        rows = rows_around(times, time, dt)
        rates = rates[rows]
        joint = int(np.abs(np.diff(rates, axis=0)).max(axis=0, initial=0.0).argmax())
        whole = bool(times[-1] >= time + (AROUND + 1) * dt)
        if self._asked is None or self._asked[:3] != (simulation.history, time, dt):
            self._finer = None
        # Asked once more when the run has gone on as far as there is to see.
        if self._asked != (asked := (simulation.history, time, dt, whole)) and self._jobs is not None:
            self._asked = asked
            if (recorded := window(WINDOW + AROUND * dt)) is not None:
                self._jobs.submit("microscope", self._take, finer_rows, recorded, time)
        of = self.quantity
        steps = Steps(dt, times[rows], _signal(simulation, table[rows], of, joint))
        finer = self._finer
        if finer is None or len(finer) < 2:
            return Magnified(time, of, joint, steps, None)
        half = float(finer[1, COLUMN["t"]] - finer[0, COLUMN["t"]])
        return Magnified(time, of, joint, steps, Steps(half, finer[:, COLUMN["t"]], _signal(simulation, finer, of, joint)))

    def _take(self, rows: Array) -> None:
        self._finer = rows

    def _failed(self, job: Job) -> None:
        """Show the run's own steps alone."""

    def forget(self) -> None:
        """Drop what is being computed."""
        if self._jobs is not None:
            self._jobs.close()
        self._asked = self._finer = None


def _signal(simulation: Simulation, table: Array, quantity: Quantity, joint: int) -> Array:
    match quantity:
        case "dq":
            return avoiding_rates(simulation, table)[:, joint]
        case "e":
            return np.sqrt(table[:, COLUMN["e2"]])
        case _:
            return table[:, COLUMN[quantity]]
