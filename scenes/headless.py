"""A run without a page, and its summary."""

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter_ns
from typing import Final

import numpy as np

from controllers.compiled import load_if_compiled
from controllers.errors import BadSetting
from controllers.kinematics import Array
from controllers.laws.situation import Law
from scenes.given_robots import GivenAtStart, take_over
from scenes.history import COLUMN
from scenes.recording import pair_label
from scenes.roles import TargetSource
from scenes.room import World
from scenes.settings import RunSettings, specs
from scenes.simulation import Simulation

FELT: Final = 0.01
"""Smallest jump of λ J_d that counts as felt [m/rad]; |J_d| is about 1 m/rad."""


@dataclass(frozen=True)
class Summary:
    """Joint figures are those of the avoiding arm.

    Attributes:
        d_min, d_min_pair: smallest distance [m] and its pair of bodies.
        e2_max, e2_end: squared error, largest and last [m² or rad²].
        dq_step_max: largest change of a joint velocity between steps [rad/s].
        ddq_max: `dq_step_max` / dt [rad/s²].
        pair_switches: changes of the closest pair.
        pair_switches_felt: those at which λ J_d jumped by `FELT` or more, which alone reach q̇; 0 for a
            smooth minimum or a law without λ.
        out_of_authority_s: time in which the arm could not follow the law [s].
        step_us_median: median wall time of a step of both arms [µs].
    """

    d_min: float
    d_min_pair: str
    share_below: float
    e2_max: float
    e2_end: float
    dq_step_max: float
    ddq_max: float
    pair_switches: int
    pair_switches_felt: int
    out_of_authority_s: float
    steps: int
    step_us_median: float


@dataclass(frozen=True)
class Run:
    """A finished run. `simulation`: at its end; `table`: (steps, columns of `scenes.history`)."""

    simulation: Simulation
    table: Array
    summary: Summary


def ready(given: GivenAtStart) -> None:
    """Prepare a new process for runs. `given`: the parent's `given_at_start`."""
    take_over(given)
    load_if_compiled()


LONG: Final = 1_000
"""Steps from which loading machine code is faster."""

MOST_STEPS: Final = 1_000_000
"""A step takes about 500 bytes."""


def check_length(settings: RunSettings, seconds: float) -> None:
    """Raise `BadSetting` for an impossible length [s]."""
    longest = MOST_STEPS * settings.dt
    if not 0.0 < seconds <= longest:
        larger_dt = " (or a larger dt)" if longest < seconds <= MOST_STEPS * specs()["dt"].high else ""
        raise BadSetting(
            f"seconds = {seconds:g} is out of range; give a number above 0 and up to {longest:g}{larger_dt}."
        )


def run(
    settings: RunSettings,
    seconds: float,
    source: TargetSource | None = None,
    start: Array | None = None,
    on_progress: Callable[[int], object] | None = None,
    law: Law | None = None,
) -> Run:
    """Simulate from a fresh start.

    Args:
        seconds: simulated; rounded to whole steps, at least one.
        source: None for the experiment's own, with the settings' seed.
        start: q (nv,) [rad]; None for the room's.
        on_progress: called with the number of steps since the last call.
        law: None for the settings' law.

    Raises:
        BadSetting: the start violates a first task.
    """
    steps = max(1, round(seconds / settings.dt))
    simulation = Simulation(settings, steps)
    if steps >= LONG:
        # A loading thread takes as long as a run that never waits.
        load_if_compiled()
    simulation.use(law)
    if start is not None:
        simulation.reset(start)
    if simulation.start_problem is not None:
        raise simulation.start_problem
    active = source or simulation.source()
    times = np.empty(steps, dtype=np.int64)
    for i in range(steps):
        target = active.target(simulation.time)
        begin = perf_counter_ns()
        simulation.step(target)
        times[i] = perf_counter_ns() - begin
        if on_progress and i % 500 == 499:
            on_progress(500)
    if on_progress:
        on_progress(steps % 500)
    table = simulation.history.table()
    return Run(simulation, table, summarise(simulation, table, float(np.median(times)) / 1000.0))


def summarise(simulation: Simulation, table: Array, step_us_median: float = float("nan")) -> Summary:
    """Summary of a history table (rows ≥ 1, columns) made with the simulation's present settings."""
    dt = simulation.settings.dt
    distance = table[:, COLUMN["d"]]
    nearest = int(distance.argmin())
    pair = int(table[nearest, COLUMN["pair"]])
    velocities = simulation.history.velocities(table)[:, simulation.avoiding.joints]
    largest = float(np.abs(np.diff(velocities, axis=0)).max()) if len(table) > 1 else 0.0
    switched = np.diff(table[:, COLUMN["pair"]]) != 0.0
    return Summary(
        d_min=float(distance[nearest]),
        d_min_pair=pair_label(simulation.detector.pair_names[pair]) if pair >= 0 else "none",
        share_below=float((distance < simulation.settings.law.critical_distance).mean()),
        e2_max=float(table[:, COLUMN["e2"]].max()),
        e2_end=float(table[-1, COLUMN["e2"]]),
        dq_step_max=largest,
        ddq_max=largest / dt,
        pair_switches=int(np.count_nonzero(switched)),
        pair_switches_felt=_felt(simulation, table, np.flatnonzero(switched).tolist()),
        out_of_authority_s=float(np.count_nonzero(table[:, COLUMN["authority"]]) * dt),
        steps=len(table),
        step_us_median=step_us_median,
    )


def _felt(simulation: Simulation, table: Array, switches: list[int]) -> int:
    if simulation.settings.law.pairs != "single":
        return 0
    world = World(simulation.room, simulation.settings.limit_gain)
    avoiding = [task.joints for task in simulation.roles.avoiders(simulation.settings.avoid)]
    pairs, lam = table[:, COLUMN["pair"]].astype(int).tolist(), table[:, COLUMN["lambda"]].tolist()
    positions = simulation.history.positions(table)
    felt = 0
    for k in switches:
        if lam[k + 1] < FELT / 2.0:
            continue
        world.kinematics.update(positions[k + 1])
        world.detector.detect()
        jump = world.detector.row(pairs[k + 1]) - world.detector.row(pairs[k])
        felt += any(lam[k + 1] * np.linalg.norm(jump[joints]) >= FELT for joints in avoiding)
    return felt
