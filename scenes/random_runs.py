"""Runs with random settings and start postures, and the checks on every run: a search for a counterexample."""

import math
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from controllers.curve import curve_text
from controllers.kinematics import Array
from scenes.experiments import EXPERIMENTS
from scenes.headless import run
from scenes.history import COLUMN
from scenes.promise import broken_by
from scenes.roles import room_of
from scenes.room import Room, World, random_bounds
from scenes.setting_spec import Spec
from scenes.settings import LATER, HardwareSettings, RunSettings, changed, specs, values

SECONDS: Final = 6.0
"""Simulated time of a run [s]."""

ROUNDING: Final = 1e-9
"""Tolerance of a bound [rad, rad/s, m]."""

EXCESS: Final = 1e-5
"""Excess from which the promise counts as broken [m]; smaller ones are not examined."""

LEAST_HALVINGS: Final = 3
MOST_HALVINGS: Final = 5
"""Largest number of halvings of the time step that test whether an excess vanishes."""

SLACK: Final = 2.0
"""An excess vanishes in proportion to dt if the rest after k halvings is at most this over 2^k."""

HARDWARE: Final = specs(HardwareSettings)

UNDRAWN: Final = frozenset({*HARDWARE, *LATER})
"""Settings that are not drawn with the others: a series of a seed stays as it was before the later ones."""

REAL_ROBOTS: Final = 0.25
"""Share of the runs with robots that are not ideal; the bounds hold for them, the promise is not made."""


@dataclass(frozen=True)
class RandomRun:
    """One run. `start`: q (nv,) [rad, m], None for the settings' own."""

    settings: RunSettings
    start: Array | None


@dataclass(frozen=True)
class RunVerdict:
    """Result of a run.

    Attributes:
        faults: one line each; () without a fault.
        promised: the law makes the promise d ≥ d_law ≥ d_m.
        margin: smallest d_law − d_m [m].
        excesses: loss of d_law below d_m with every condition met [m]: at dt, and if that is too much at
            dt/2, dt/4, …
    """

    index: int
    faults: tuple[str, ...]
    promised: bool
    margin: float
    excesses: tuple[float, ...]


def random_run(seed: int, index: int) -> RandomRun:
    """Run `index` of the series of a seed, always the same."""
    dice = np.random.default_rng([seed, index])
    settings = RunSettings()
    for key, spec in specs().items():
        if key not in UNDRAWN:
            settings = changed(settings, key, _drawn(dice, key, spec, values(settings)[key]))
    start = _start(dice, room_of(settings))
    if dice.random() < REAL_ROBOTS:
        for key, spec in HARDWARE.items():
            settings = changed(settings, key, _drawn(dice, key, spec, values(settings)[key]))
    return RandomRun(settings, start)


def _drawn(dice: np.random.Generator, key: str, spec: Spec, default: Any) -> object:
    """Value of a setting: half of the laws are the one with the promise, half of the numbers are the
    defaults.
    """
    usual = bool(dice.random() < 0.5)
    if key == "scene":
        # Another first task has values and units of its own.
        return str(
            dice.choice([name for name, experiment in EXPERIMENTS.items() if experiment.obstacle != "task"])
        )
    if spec.choices:
        return default if key == "law" and usual else str(dice.choice(spec.choices))
    if spec.read is not None:
        # A curve, the only text: a few points in any order of heights, each at least 1 mm from the last.
        gaps = dice.uniform(0.001, 0.15, dice.integers(2, 8))
        return curve_text(tuple(zip(np.cumsum(gaps).tolist(), dice.random(len(gaps)).tolist(), strict=True)))
    if isinstance(default, bool):
        return bool(dice.random() < 0.25)
    if usual and key != "seed":
        return default
    number = float(dice.uniform(spec.low, spec.high))
    return round(number) if isinstance(default, int) else float(f"{number:.4g}")


def _start(dice: np.random.Generator, room: Room) -> Array | None:
    """The room's own start posture (None), a random one, or the one of twelve random ones with the nearest
    bodies.
    """
    tries = (0, 1, 12, 12)[dice.integers(4)]
    if not tries:
        return None
    model = room.model
    world = World(room, 10.0)
    postures = dice.uniform(*random_bounds(room), (tries, model.nv)).round(3)
    distances: list[float] = []
    for posture in postures:
        world.kinematics.update(posture)
        distances.append(world.detector.detect().distance)
    return postures[int(np.argmin(distances))].clip(model.lowerPositionLimit, model.upperPositionLimit)


def run_verdict(seed: int, index: int, seconds: float = SECONDS) -> RunVerdict:
    """Make run `index` of the series of a seed, of this simulated time [s], and check it."""
    random = random_run(seed, index)
    settings = random.settings
    done = run(settings, seconds, start=random.start)
    table, model, history = done.table, done.simulation.room.model, done.simulation.history
    q, dq, promised = history.positions(table), history.velocities(table), settings.law.entry.promises
    if not (
        np.isfinite(q).all() and np.isfinite(dq).all() and not np.isnan(table[:, : COLUMN["lever"] + 1]).any()
    ):
        return RunVerdict(index, ("a number is none: NaN or infinite",), promised, math.nan, ())
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
    if over > ROUNDING and not settings.hardware.sees_wrong:
        faults.append(f"d_law is larger than d by {over:.3g} m")
    if not promised or settings.hardware != HardwareSettings():
        return RunVerdict(index, tuple(faults), False, margin, ())
    excesses = _excesses(random, broken_by(settings, table), seconds)
    if not explained(excesses):
        lost = ", ".join(f"{1000.0 * excess:.3f}" for excess in excesses)
        faults.append(f"d_law falls below d_m with every condition met, by {lost} mm at dt, dt/2, dt/4, …")
    return RunVerdict(index, tuple(faults), True, margin, excesses)


def _excesses(random: RandomRun, first: float, seconds: float) -> tuple[float, ...]:
    """Excess [m] at dt, and if that is too much at dt/2, dt/4, … until the worst is two halvings behind."""
    excesses = [first]
    if first <= EXCESS:
        return (first,)
    for halvings in range(1, MOST_HALVINGS + 1):
        finer = replace(random.settings, dt=random.settings.dt / 2**halvings)
        excesses.append(broken_by(finer, run(finer, seconds, start=random.start).table))
        if halvings >= LEAST_HALVINGS and halvings >= int(np.argmax(excesses)) + 2:
            break
    return tuple(excesses)


def explained(excesses: tuple[float, ...]) -> bool:
    """True if a time step explains excesses [m] at dt, dt/2, dt/4, …: after the worst they vanish in
    proportion to dt.

    The worst need not be the first: a smooth minimum with weights that change within a step (β times the
    speeds along the pairs times dt of order 1) chatters like the closest pair, differently at every dt.
    """
    worst = int(np.argmax(excesses))
    if excesses[worst] <= EXCESS:
        return True
    later = enumerate(excesses[worst + 1 :], 1)
    return len(excesses) > worst + 2 and all(
        excess <= max(SLACK * excesses[worst] / 2**k, EXCESS) for k, excess in later
    )
