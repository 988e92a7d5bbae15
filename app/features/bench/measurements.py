"""The figures of `lwr-duet bench`, row by row, and as ratios to those of an earlier run on the same machine, which mean more than times;
and what a step costs, with it a whole run and the curves of "what if"."""

import json
import platform
import statistics
import subprocess
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from time import perf_counter_ns
from typing import Any, Final

import numpy as np

from app.features.bench.processes import limit_of
from app.features.bench.visitors import FULL_PAGE, measure_crowd, measure_sessions, measure_visitor
from app.runtime.job_pool import JobPool
from app.session.session import Session
from app.settings import Settings
from app.version import duet_version
from controllers.compiled import load_now
from controllers.errors import BadInputFile
from controllers.own_packages import own_command
from scenes.experiments import EXPERIMENTS, HOLD
from scenes.files import input_content
from scenes.laws import LAWS
from scenes.roles import TargetSource
from scenes.settings import RunSettings, changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget

BenchFigures = dict[str, dict[str, float]]
"""What was measured → figure → value."""

BenchRows = Iterator[tuple[str, dict[str, float]]]
"""The same, one after the other."""

MOST_BYTES: Final = 10_000_000
"""Largest file of figures."""

WATCHERS: Final = 30
SESSIONS: Final = 8


def measured_figures(steps: int, seconds: float, robot: str) -> BenchRows:
    """Yield all figures.

    Args:
        steps: measured steps of each scene.
        seconds: duration of each measurement of visitors [s].
        robot: the arms of the measured steps.
    """
    yield from measure_steps(steps, robot).items()
    yield "run of 46 s", measure_run()
    yield "what if, 30 s again", measure_what_if()
    yield "one visitor", measure_visitor(seconds)
    yield "one visitor, ghost and four plots", measure_visitor(seconds, FULL_PAGE)
    yield f"lecture with {WATCHERS} watchers", measure_crowd(WATCHERS, seconds, lecture=True)
    yield f"{SESSIONS} private sessions", measure_crowd(SESSIONS, seconds, lecture=False)


def measure_capacity(sessions: Iterable[int], seconds: float) -> BenchRows:
    """Yield what so many private sessions cost, one number after the other.

    Args:
        seconds: duration of each [s].
    """
    for count in sessions:
        yield f"{count} private sessions", measure_sessions(count, seconds)


def printed(rows: BenchRows) -> dict[str, Any]:
    """Print every row as soon as it is measured, then what takes the server's time where that was measured.

    Returns:
        The figures, ready for JSON.
    """
    figures: BenchFigures = {}
    for name, row in rows:
        figures[name] = row
        print(_row(name, row, lambda value: f"{value:.3g}" if abs(value) < 10 else f"{value:.1f}"), flush=True)
    for name, row in figures.items():
        if limit := limit_of(row):
            print(f"{name:36s} {limit}")
    machine = f"{platform.machine()}, Python {platform.python_version()}, numpy {np.__version__}"
    return {"version": duet_version(), "machine": machine, "figures": figures}


def read_figures(path: Path) -> dict[str, Any]:
    """Return figures saved earlier.

    Raises:
        BadInputFile: the file cannot be read, or does not hold figures.
    """
    try:
        result = json.loads(input_content(path, MOST_BYTES))
        if not isinstance(result["figures"], dict):
            raise TypeError
    except (ValueError, KeyError, TypeError, RecursionError):
        raise BadInputFile(f"{path}: is not a file that `bench --out` has written.") from None
    return result


def ratio_table(now: dict[str, Any], before: dict[str, Any]) -> str:
    """Return a table of the ratios new : old of every figure that both have."""
    ratios: BenchFigures = {}
    for name, figures in now["figures"].items():
        old = before["figures"].get(name, {})
        ratios[name] = {key: value / old[key] for key, value in figures.items() if old.get(key)}
    rows = [_row(name, figures, lambda value: f"{value:.2f}x") for name, figures in ratios.items()]
    return "\n".join((f"\nratio to version {before.get('version', '?')}", *rows))


def _row(name: str, figures: dict[str, float], shown: Callable[[float], str]) -> str:
    return f"{name:36s} " + "   ".join(f"{key} {shown(value)}" for key, value in figures.items())


WARM_UP: Final = 500
"""Steps made before any is measured."""

RESTLESS: Final = "hold, soft minimum, bounds at work"
"""The guided hand jumps between two places at 1 m/s, which drives the avoiding arm into its velocity bounds."""

PAST: Final = 30.0
"""How much of a run "what if" simulates again [s]."""


def _scenes(robot: str) -> dict[str, RunSettings]:
    base = RunSettings(robot=robot)
    single = replace(base, law=replace(base.law, pairs="single"))
    soft = replace(base, law=replace(base.law, pairs="soft"))
    fast = replace(soft.law, nominal_velocity=1.0, critical_distance=0.3)
    return {
        "hold, single pair": single,
        "hold, soft minimum": soft,
        "hold, smooth everywhere": base,
        RESTLESS: replace(soft, gain=20.0, hand_speed=1.0, limit_gain=1.0, law=fast),
        "hold, pose, soft minimum": replace(soft, task="pose"),
        **{f"hold, {law}": replace(base, law=replace(base.law, law=law)) for law in LAWS if law != base.law.law},
        **{f"{scene}, soft minimum": replace(soft, scene=scene) for scene in EXPERIMENTS if scene != base.scene},
    }


class _Restless:
    """A target that is the other arm's hand for one second and the start for the next."""

    def __init__(self, simulation: Simulation) -> None:
        kinematics = simulation.kinematics
        self._places = tuple(kinematics.hand_pose(arm).translation.copy() for arm in (simulation.avoiding, simulation.guided))

    def target(self, time: float) -> HandTarget:
        return HandTarget(self._places[int(time) % 2])


def measure_steps(steps: int, robot: str) -> dict[str, dict[str, float]]:
    """Return scene → median and 99th percentile of one step of both arms [µs], and the share of steps at a bound, all interleaved."""
    load_now()
    runs: dict[str, tuple[Simulation, TargetSource]] = {}
    for name, settings in _scenes(robot).items():
        simulation = Simulation(settings)
        runs[name] = simulation, _Restless(simulation) if name == RESTLESS else simulation.source()
    times: dict[str, list[int]] = {name: [] for name in runs}
    bounded = dict.fromkeys(runs, 0)
    block = 200
    for done in range(0, WARM_UP + steps, block):
        for name, (simulation, person) in runs.items():
            for _ in range(block):
                target = person.target(simulation.time)
                begin = perf_counter_ns()
                simulation.step(target)
                elapsed = perf_counter_ns() - begin
                if done >= WARM_UP:
                    times[name].append(elapsed)
                    bounded[name] += simulation.bound_bites
    return {
        name: {
            "median_us": statistics.median(values) / 1000.0,
            "p99_us": float(np.percentile(values, 99)) / 1000.0,
            "bounded_share": bounded[name] / len(values),
        }
        for name, values in times.items()
    }


def measure_run() -> dict[str, float]:
    """Return how long `lwr-duet run` takes for 46 s of the hold experiment, and how much of it is start-up [s]."""
    times: list[float] = []
    for seconds in ("46", "0.005"):
        begin = time.perf_counter()
        command = own_command("app.__main__", "run", "--scene", HOLD, "--seconds", seconds)
        subprocess.run(command, check=True, capture_output=True)
        times.append(time.perf_counter() - begin)
    return {"wall_s": times[0], "start_s": times[1]}


def measure_what_if() -> dict[str, float]:
    """Return the time from a slider's last move until the curves of "what if" can be drawn [s]."""
    background = JobPool()
    session = Session(changed(Settings(), "whatif", True), background=background)
    try:
        while session.simulation.time < PAST:
            session.advance(0.05)
        figures: dict[str, float] = {}
        for name, distance in (("first_s", 0.12), ("later_s", 0.17)):
            answer = session.studies.questions.what_if
            session.change("dm", distance)
            begin = time.perf_counter()
            while session.studies.questions.what_if is answer and time.perf_counter() - begin < PAST:
                time.sleep(1.0 / 32.0)
                session.advance(1.0 / 32.0)
            figures[name] = time.perf_counter() - begin
        return figures
    finally:
        session.close()
        background.close()
