"""Random runs with checks: a search for a counterexample."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from scenes.experiments import Series
from scenes.headless import Run, run
from scenes.history import COLUMN
from scenes.promise import broken_by
from scenes.quantities import KeptQuantity
from scenes.random_draws import RandomRun, random_run
from scenes.room import World
from scenes.settings import HardwareSettings, RunSettings
from scenes.world_stages import clearance, kept_clear

SECONDS: Final = 6.0
"""Simulated time of a run [s]."""

ROUNDING: Final = 1e-9
"""Tolerance of a bound [rad, rad/s, m]."""

EXCESS: Final = 1e-5
"""Smallest excess that breaks the promise, in the unit of the first task."""

LEAST_HALVINGS: Final = 3
MOST_HALVINGS: Final = 5
"""Fewest and most halvings of dt that test whether an excess vanishes."""

SLACK: Final = 2.0
"""An excess vanishes in proportion to dt if at most this over 2^k of it remains after k halvings."""


@dataclass(frozen=True)
class RunVerdict:
    """Result of a run.

    Attributes:
        promised: the law promises h ≥ h_law ≥ h_m (of the arms' distance d ≥ d_law ≥ d_m).
        margin: smallest h_law − h_m, in the unit of the first task.
        excesses: largest h_m − h_law with every condition met, in that unit: at dt, and if too large at dt/2,
            dt/4, …
        clear: least distance of the arms that began clear of their surroundings from these [m], negative
            inside; ∞ if not checked.
    """

    index: int
    faults: tuple[str, ...]
    promised: bool
    margin: float
    excesses: tuple[float, ...]
    kept: KeptQuantity
    clear: float = math.inf


def run_verdict(seed: int, index: int, seconds: float = SECONDS, series: Series = "usual") -> RunVerdict:
    """Simulate and check run `index` of a seed's series. `seconds`: simulated time [s]."""
    random = random_run(seed, index, series)
    settings = random.settings
    kept, ideal = settings.quantity, settings.hardware == HardwareSettings()
    done = _made(random, settings, seconds)
    table, model, history = done.table, done.simulation.room.model, done.simulation.history
    q, dq, promised = history.positions(table), history.velocities(table), settings.law.entry.promises
    if not (
        np.isfinite(q).all() and np.isfinite(dq).all() and not np.isnan(table[:, : COLUMN["lever"] + 1]).any()
    ):
        return RunVerdict(index, ("a number is none: NaN or infinite",), promised, math.nan, (), kept)
    margin = float(table[:, COLUMN["law_d"]].min()) - settings.law.critical_distance
    faults: list[str] = []
    passed = max((model.lowerPositionLimit - q).max(), (q - model.upperPositionLimit).max())
    if passed > ROUNDING:
        faults.append(f"a joint passes its stop by {passed:.3g} rad or m")
    faster = (np.abs(dq) - model.velocityLimit).max()
    if faster > ROUNDING:
        faults.append(f"a joint is faster than it may be by {faster:.3g} rad/s or m/s")
    met = table[table[:, COLUMN["pair"]] >= 0.0]
    over = float((met[:, COLUMN["law_d"]] - met[:, COLUMN["d"]]).max(initial=-np.inf))
    # With stages the law sees the first of several first tasks, which need not be the least.
    if over > ROUNDING and not settings.hardware.sees_wrong and not settings.stages:
        faults.append(f"{kept.seen} is larger than {kept.symbol} by {over:.3g} {kept.unit}")
    clear = math.inf
    if settings.world and ideal:
        clear = _clear(done)
        if clear < 0.0:
            entered = _until(lambda finer: max(0.0, -_clear(_made(random, finer, seconds))), settings, -clear)
            if not explained(entered):
                faults.append(f"an arm is inside of something, by {_listed(entered)} mm at dt, dt/2, dt/4, …")
    if not promised or not ideal:
        return RunVerdict(index, tuple(faults), False, margin, (), kept, clear)
    excesses = _until(
        lambda finer: broken_by(finer, _made(random, finer, seconds).table),
        settings,
        broken_by(settings, table),
    )
    if not explained(excesses):
        faults.append(
            f"{kept.seen} falls below {kept.critical} with every condition met, by {_listed(excesses)} {kept.page_unit} "
            "at dt, dt/2, dt/4, …"
        )
    return RunVerdict(index, tuple(faults), True, margin, excesses, kept, clear)


def _made(random: RandomRun, settings: RunSettings, seconds: float) -> Run:
    return run(settings, seconds, random.hand, random.start)


def _clear(done: Run) -> float:
    world = World(done.simulation.room, done.simulation.settings.limit_gain)
    positions = done.simulation.history.positions(done.table)
    world.kinematics.update(positions[0])
    kept = [one for one in kept_clear(world) if clearance([one]) > 0.0]
    least = math.inf
    for posture in positions:
        world.kinematics.update(posture)
        least = min(least, clearance(kept))
    return least


def _listed(excesses: tuple[float, ...]) -> str:
    return ", ".join(f"{1000.0 * excess:.3f}" for excess in excesses)


def _until(
    excess_of: Callable[[RunSettings], float], settings: RunSettings, first: float
) -> tuple[float, ...]:
    """Excess at dt, and if too large at dt/2, dt/4, … until the worst is two halvings behind."""
    excesses = [first]
    if first <= EXCESS:
        return (first,)
    for halvings in range(1, MOST_HALVINGS + 1):
        excesses.append(excess_of(replace(settings, dt=settings.dt / 2**halvings)))
        if halvings >= LEAST_HALVINGS and halvings >= int(np.argmax(excesses)) + 2:
            break
    return tuple(excesses)


def explained(excesses: tuple[float, ...]) -> bool:
    """True if the time step explains excesses at dt, dt/2, dt/4, …: after the worst they vanish in proportion
    to dt.

    The worst need not be the first: a smooth minimum whose weights change within a step (β · speed · dt of
    order 1) chatters differently at every dt.
    """
    worst = int(np.argmax(excesses))
    if excesses[worst] <= EXCESS:
        return True
    later = enumerate(excesses[worst + 1 :], 1)
    return len(excesses) > worst + 2 and all(
        excess <= max(SLACK * excesses[worst] / 2**k, EXCESS) for k, excess in later
    )
