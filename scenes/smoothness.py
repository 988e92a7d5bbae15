"""Is a law smooth? The same inputs at dt, dt/2, dt/4, dt/8: a smooth motion's largest step of q̇ halves each time, a jump stays.

And the single steps about an instant, beside the same inputs in finer steps.
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
"""Into how many parts dt is divided."""

SMOOTH: Final = 0.65
"""If halving dt leaves at most this share of the largest step, the last time and on average, q̇ is smooth."""

JUMP: Final = 0.85
"""If the last halving leaves at least this share, q̇ jumps. The share is 1/2 where q̇ has a bounded derivative, and 1 at a jump. Over
45 runs of all laws and scenes it was 0.48 … 0.50 or 0.98 … 1.02 at last; a jump that is smaller than the smooth motion of a step, or
many small ones, lie between."""

STILL: Final = 1e-9
"""A largest step below this is rounding [rad/s]."""

ECHO: Final = 20
"""Steps after a jump of the inputs that do not count: an arm that follows another one jumps one step later, and so on."""

StepTrend = Literal["measuring", "still", "smooth", "jump", "between"]


@dataclass(frozen=True)
class StepStudy:
    """The largest step of q̇ against the time step.

    Attributes:
        settings: in force all the time.
        seconds: how much of a run was made again [s].
        dts: time steps [s].
        largest: of each, the largest change of the velocity of any joint that keeps clear, from one step to the next [rad/s]; None
            while it is being computed.
    """

    settings: RunSettings
    seconds: float
    dts: tuple[float, ...]
    largest: tuple[float | None, ...]

    @property
    def verdict(self) -> StepTrend:
        """What the numbers say."""
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
    """Return the measures of a recorded piece of a run, with some settings."""
    dt = recorded.stretches[-1].settings.dt
    return StepStudy(settings, recorded.seconds, tuple(dt / k for k in SUBSTEPS), tuple(None for _ in SUBSTEPS))


def largest_velocity_step(recorded: Recorded, settings: RunSettings, substeps: int) -> float:
    """Return the largest change of a joint's velocity from one step to the next [rad/s], see `StepStudy`.

    What follows immediately upon the beginning, or upon another kind of target (the user took hold), is left out: there a jump is
    expected.

    Args:
        recorded, substeps: as in `scenes.rerun.rerun`.
        settings: in force all the time; the time step is that of the recorded run.

    Raises:
        Stopped: see there.
    """
    asked = {key: value for key, value in values(settings).items() if key not in FIXED}
    again = rerun(recorded, asked, substeps)
    simulation = Simulation(settings, 1)
    columns = [
        column for task in simulation.roles.avoiders(settings.avoid) for column in range(task.joints.start, task.joints.stop)
    ]
    velocities = simulation.history.velocities(again.table)[:, columns]
    steps = np.abs(np.diff(velocities, axis=0))
    for seam in (1, *again.seams):
        steps[seam - 1 : seam - 1 + ECHO] = 0.0
    return float(steps.max()) if steps.size else 0.0


AROUND: Final = 20
"""Steps shown on either side of the instant."""

FINER: Final = 2
"""Into how many a step is divided in the run beside it."""


def time_of_largest_jump(times: Array, velocities: Array, dt: float) -> float:
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


def finer_rows(recorded: Recorded, time: float, dt: float) -> Array:
    """Return the steps about an instant [s] of a recorded piece that is made again in finer steps (rows, columns of `scenes.history`).

    Args:
        dt: of the steps that are shown beside them [s].

    Raises:
        Stopped: see `scenes.rerun.rerun`.
    """
    table = rerun(recorded, substeps=FINER).table
    return table[rows_around(table[:, COLUMN["t"]], time, dt)]
