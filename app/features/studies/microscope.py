"""Single steps around an instant, at dt and dt/2."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from app.runtime.job_pool import Job, Jobs, JobWatch
from controllers.kinematics import Array
from scenes.history import COLUMN, History
from scenes.inputs import InputsLog
from scenes.simulation import Simulation
from scenes.smoothness import AROUND, avoiding_rates, finer_rows, rows_around, time_of_largest_jump

Signal = Literal["d", "lambda", "dq", "e"]

WINDOW: Final = 20.0
"""Part of the run searched for the largest jump; recomputed at least [s]."""

STRIDE: Final = 10


@dataclass(frozen=True, eq=False)
class Steps:
    """`dt` [s], `times` (k,) [s], `values` (k,) [SI]."""

    dt: float
    times: Array
    values: Array

    @property
    def largest(self) -> float:
        return float(np.abs(np.diff(self.values)).max(initial=0.0))


@dataclass(frozen=True, eq=False)
class Magnified:
    """The shown steps.

    Attributes:
        joint: index of the joint that jumps most.
        finer: at dt/2; None until computed, or if impossible.
    """

    time: float
    quantity: Signal
    joint: int
    steps: Steps
    finer: Steps | None


class Microscope:
    """Instant and signal of one visitor's microscope. All methods belong to the session's thread.

    Args:
        background, wake: see `JobWatch`.

    Attributes:
        span: begin and end of the kept run, and the shown instant [s], or None.
    """

    def __init__(self, background: Jobs | None, wake: Callable[[], None], inputs: InputsLog) -> None:
        self._jobs, self._inputs = JobWatch(background, wake, self._failed), inputs
        self.quantity: Signal = "dq"
        self._time: float | None = None
        self.span: tuple[float, float, float] | None = None
        self._asked: tuple[History, float, float, bool] | None = None
        self._finer: Array | None = None

    def go_to(self, time: float | None) -> None:
        """`time`: [s]; None follows the largest step of q̇."""
        self._time = time

    def move(self, steps: int, dt: float) -> None:
        """Move by `steps` steps of `dt` [s]."""
        if self.span is not None:
            self._time = self.span[2] + steps * dt

    def magnify(self, simulation: Simulation) -> Magnified | None:
        """None before the second step. Starts the computation of finer steps."""
        self._jobs.collect()
        dt, history = simulation.settings.dt, simulation.history
        times = history.column("t")
        if len(times) < 2:
            self.span = None
            return None
        time = self._time
        if time is None:
            newest = history.table(round(WINDOW / dt))
            time = time_of_largest_jump(newest[:, COLUMN["t"]], avoiding_rates(simulation, newest), dt)
        # The times ascend.
        place = min(int(np.searchsorted(times, time)), len(times) - 1)
        place -= place > 0 and time - times[place - 1] < times[place] - time
        time = float(times[place])
        self.span = float(times[0]), float(times[-1]), time
        rows = rows_around(times, time, dt)
        table = history.table(len(times) - rows.start, len(times) - rows.stop)
        joint = int(
            np.abs(np.diff(avoiding_rates(simulation, table), axis=0)).max(axis=0, initial=0.0).argmax()
        )
        whole = bool(times[-1] >= time + (AROUND + 1) * dt)
        if self._asked is None or self._asked[:3] != (history, time, dt):
            self._finer = None
        # Asked again when the run has passed the end of the view.
        if self._asked != (asked := (history, time, dt, whole)) and self._jobs.computes:
            self._asked = asked
            if (
                recorded := self._inputs.window(max(WINDOW, float(times[-1]) - time) + AROUND * dt)
            ) is not None:
                self._jobs.submit("microscope", self._take, finer_rows, recorded, time, dt)
        of = self.quantity
        steps = Steps(dt, table[:, COLUMN["t"]], _signal(simulation, table, of, joint))
        finer = self._finer
        if finer is None or len(finer) < 2:
            return Magnified(time, of, joint, steps, None)
        half = float(finer[1, COLUMN["t"]] - finer[0, COLUMN["t"]])
        return Magnified(
            time, of, joint, steps, Steps(half, finer[:, COLUMN["t"]], _signal(simulation, finer, of, joint))
        )

    def _take(self, rows: Array) -> None:
        self._finer = rows

    def _failed(self, job: Job) -> None:
        """Show only the run's own steps."""

    def forget(self) -> None:
        self._jobs.close()
        self._asked = self._finer = self._time = None


def _signal(simulation: Simulation, table: Array, quantity: Signal, joint: int) -> Array:
    match quantity:
        case "dq":
            return avoiding_rates(simulation, table)[:, joint]
        case "e":
            return np.sqrt(table[:, COLUMN["e2"]])
        case _:
            return table[:, COLUMN[quantity]]
