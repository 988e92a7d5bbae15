"""Smoothness of a law: from dt to dt/2, dt/4, dt/8 a smooth motion's largest step of q̇ halves each time, a
jump stays.
"""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from controllers.kinematics import Array
from scenes.history import COLUMN
from scenes.inputs import Recorded
from scenes.rerun import FIXED, rerun
from scenes.settings import RunSettings, values
from scenes.simulation import Simulation

SUBSTEPS: Final = (1, 2, 4, 8)

SMOOTH: Final = 0.65
"""q̇ is smooth if the last halving of dt, and all on average, leave at most this share of the largest step.
"""

JUMP: Final = 0.85
"""q̇ jumps if the last halving leaves at least this share: 1/2 for a bounded derivative, 1 at a jump. 45 runs
of all laws and scenes gave 0.48 … 0.50 or 0.98 … 1.02; small or many jumps are between.
"""

STILL: Final = 1e-9
"""A smaller largest step is rounding [rad/s]."""

ECHO: Final = 20
"""Ignored steps after a jump of the inputs, which followers repeat a step later."""

StepTrend = Literal["measuring", "still", "smooth", "jump", "between"]


@dataclass(frozen=True)
class StepStudy:
    """Largest step of q̇ against the time step.

    Attributes:
        seconds: length of the recomputed run [s].
        dts: time steps [s].
        largest: largest change of an avoiding joint's velocity in a step, for each dt [rad/s]; None if not
            yet computed.
    """

    settings: RunSettings
    seconds: float
    dts: tuple[float, ...]
    largest: tuple[float | None, ...]

    @property
    def verdict(self) -> StepTrend:
        if any(step is None for step in self.largest):
            return "measuring"
        first, *_, coarser, finest = (step or 0.0 for step in self.largest)
        if max(coarser, finest) < STILL:
            return "still"
        last = finest / max(coarser, STILL)
        if last >= JUMP:
            return "jump"
        mean = (finest / max(first, STILL)) ** (1.0 / (len(self.largest) - 1))
        return "smooth" if max(last, mean) <= SMOOTH else "between"


def unmeasured(recorded: Recorded, settings: RunSettings) -> StepStudy:
    dt = recorded.stretches[-1].settings.dt
    return StepStudy(
        settings, recorded.seconds, tuple(dt / k for k in SUBSTEPS), tuple(None for _ in SUBSTEPS)
    )


def largest_velocity_step(recorded: Recorded, settings: RunSettings, substeps: int) -> float:
    """Largest change of an avoiding joint's velocity in a step [rad/s].

    Steps after the beginning, or after another kind of target, are left out: jumps are expected there.

    Args:
        settings: in force all the time, except those in `FIXED`.

    Raises:
        Stopped: see `scenes.rerun.rerun`.
    """
    asked = {key: value for key, value in values(settings).items() if key not in FIXED}
    again = rerun(recorded, asked, substeps)
    simulation = Simulation(settings, 1)
    columns = [
        column
        for task in simulation.roles.avoiders(settings.avoid)
        for column in range(task.joints.start, task.joints.stop)
    ]
    velocities = simulation.history.velocities(again.table)[:, columns]
    steps = np.abs(np.diff(velocities, axis=0))
    for seam in (1, *again.seams):
        steps[seam - 1 : seam - 1 + ECHO] = 0.0
    return float(steps.max()) if steps.size else 0.0


AROUND: Final = 20

FINER: Final = 2


def time_of_largest_jump(times: Array, velocities: Array, dt: float) -> float:
    """Time after the step with the largest change of a joint's velocity [s]; the first steps do not count.

    Args:
        times: (steps,) at least one [s].
        velocities: q̇ (steps, joints).
    """
    steps = np.abs(np.diff(velocities, axis=0)).max(axis=1, initial=0.0)
    steps[times[1:] < ECHO * dt] = 0.0
    return float(times[1 + int(steps.argmax())]) if len(steps) and steps.max() > 0.0 else float(times[-1])


def rows_around(times: Array, time: float, dt: float) -> slice:
    """Rows within `AROUND` steps of an instant [s]."""
    reach = (AROUND + 0.25) * dt
    return slice(int(np.searchsorted(times, time - reach)), int(np.searchsorted(times, time + reach)))


def avoiding_rates(simulation: Simulation, table: Array) -> Array:
    return simulation.history.velocities(table)[:, simulation.avoiding.joints]


def finer_rows(recorded: Recorded, time: float, dt: float) -> Array:
    """Steps around an instant [s], recomputed in finer steps (rows, columns of `scenes.history`).

    Args:
        dt: of the original steps [s].

    Raises:
        Stopped: see `scenes.rerun.rerun`.
    """
    table = rerun(recorded, substeps=FINER).table
    return table[rows_around(table[:, COLUMN["t"]], time, dt)]
