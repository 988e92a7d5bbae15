"""The single steps about an instant of a run, and the same inputs in finer steps."""

from collections.abc import Callable
from typing import Final

import numpy as np

from controllers.kinematics import Array
from scenes.history import COLUMN
from scenes.inputs import Recorded
from scenes.rerun import never, rerun
from scenes.simulation import Simulation
from scenes.smoothness import ECHO

AROUND: Final = 20
"""Steps shown on either side of the instant."""

SUBSTEPS: Final = 2
"""Into how many a step is divided in the run beside it."""


def largest_jump(times: Array, velocities: Array, dt: float) -> float:
    """Return when the velocity of any joint changes most from one step to the next [s]: the time of the later step.

    What follows immediately upon the beginning of a run is left out: there a jump is expected.

    Args:
        times: (steps,) at least one [s].
        velocities: q̇ of the avoiding arm (steps, joints).
    """
    steps = np.abs(np.diff(velocities, axis=0)).max(axis=1, initial=0.0)
    steps[times[1:] < ECHO * dt] = 0.0
    return float(times[1 + int(steps.argmax())]) if len(steps) and steps.max() > 0.0 else float(times[-1])


def rows_around(times: Array, time: float, dt: float) -> slice:
    """Return which rows lie within `AROUND` steps of an instant [s]."""
    reach = (AROUND + 0.25) * dt
    return slice(int(np.searchsorted(times, time - reach)), int(np.searchsorted(times, time + reach)))


def avoiding_rates(simulation: Simulation, table: Array) -> Array:
    """Return q̇ of the avoiding arm (rows, joints) of a table."""
    return simulation.history.velocities(table)[:, simulation.avoiding.joints]


def finer_rows(recorded: Recorded, time: float, stopped: Callable[[], bool] = never) -> Array:
    """Return the steps about an instant [s] of a recorded piece that is made again in finer steps (rows, columns of `scenes.history`).

    Raises:
        Stopped: see `scenes.rerun.rerun`.
    """
    table = rerun(recorded, substeps=SUBSTEPS, stopped=stopped).table
    return table[rows_around(table[:, COLUMN["t"]], time, recorded.dt)]
