"""The benchmark: what a step costs, and what a visitor costs the server.

Figures of one run are compared as ratios to those of another; times on a machine that does other work mean little by themselves.
"""

import asyncio
import json
import os
import platform
import statistics
import subprocess
import sys
import time
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from time import perf_counter_ns
from typing import Any, Final, get_args

import numpy as np

from app.bench.fairness import DOINGS, measure_neighbour
from app.bench.headless_client import HeadlessClient
from app.bench.visitors import limit_of, measure_crowd
from app.runtime.job_pool import JobPool
from app.session.session import Session
from app.settings import Settings
from app.version import duet_version
from controllers.errors import BadInputFile
from scenes.files import read_file
from scenes.roles import TargetSource
from scenes.settings import LawName, RunSettings, SceneName, changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget

Figures = dict[str, dict[str, float]]

WARM_UP: Final = 500
"""Steps made before any is measured."""

MOST_BYTES: Final = 10_000_000
"""Largest file of figures."""

RESTLESS: Final = "hold, soft minimum, bounds at work"
"""A person who jerks the arm to and fro at 1 m/s drives the avoiding arm into its velocity bounds."""

SERVE_WARM_UP: Final = 3.0
"""Time a visitor is left alone before it is watched [s]."""

FULL_PAGE: Final = "scene=imitation&plot=follow&ghost=unprotected"
"""Link to a page with a ghost and four plots over time."""

PAST: Final = 30.0
"""How much of a run "what if" makes again [s]."""

WATCHERS: Final = 30
SESSIONS: Final = 8


def _scenes() -> dict[str, RunSettings]:
    base = RunSettings()
    single = replace(base, law=replace(base.law, pairs="single"))
    soft = replace(base, law=replace(base.law, pairs="soft"))
    return {
        "hold, single pair": single,
        "hold, soft minimum": soft,
        RESTLESS: replace(
            soft,
            gain=20.0,
            hand_speed=1.0,
            limit_gain=1.0,
            law=replace(soft.law, nominal_velocity=1.0, critical_distance=0.3),
        ),
        "hold, pose, soft minimum": replace(soft, task="pose"),
        **{f"hold, {law}": replace(base, law=replace(base.law, law=law)) for law in get_args(LawName) if law != base.law.law},
        **{f"{scene}, soft minimum": replace(soft, scene=scene) for scene in get_args(SceneName) if scene != base.scene},
    }


class _Restless:
    """A person who wants to be at the other arm's hand for one second and at home for the next."""

    def __init__(self, simulation: Simulation) -> None:
        kinematics = simulation.kinematics
        self._places = tuple(kinematics.hand_pose(arm).translation.copy() for arm in (simulation.avoiding, simulation.guided))

    def target(self, time: float) -> HandTarget:
        return HandTarget(self._places[int(time) % 2])


def measure_steps(steps: int) -> Figures:
    """Return scene → median and 99th percentile of a whole step of both arms [µs], all scenes interleaved in one run."""
    runs: dict[str, tuple[Simulation, TargetSource]] = {}
    for name, settings in _scenes().items():
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
        command = [sys.executable, "-m", "app", "run", "--scene", "hold", "--seconds", seconds]
        subprocess.run(command, check=True, capture_output=True)
        times.append(time.perf_counter() - begin)
    return {"wall_s": times[0], "start_s": times[1]}


def measure_what_if() -> dict[str, float]:
    """Return how long the curves of "what if" take from the last move of a slider until they can be drawn [s]."""
    background = JobPool()
    session = Session(changed(Settings(), "whatif", True), background=background)
    try:
        while session.simulation.time < PAST:
            session.advance(0.05)
        figures: dict[str, float] = {}
        for name, distance in (("first_s", 0.12), ("later_s", 0.17)):
            answer = session.what_if
            session.change("dm", distance)
            begin = time.perf_counter()
            while session.what_if is answer and time.perf_counter() - begin < PAST:
                time.sleep(1.0 / 32.0)
                session.advance(1.0 / 32.0)
            figures[name] = time.perf_counter() - begin
        return figures
    finally:
        session.close()
        background.close()


def measure_visitor(seconds: float, query: str = "") -> dict[str, float]:
    """Return what one visitor costs a server that was started as anybody starts it: CPU, messages, bytes and frames.

    Args:
        seconds: how long the visitor is watched.
        query: of the link that the visitor comes by.

    Returns:
        Besides that, the time from the command until the server answers, and until the arms have arrived at the visitor [s].
    """
    command = [sys.executable, "-m", "app", "serve", "--port", "0", "--no-open"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, encoding="utf-8") as server:
        try:
            assert server.stdout is not None
            begin = time.perf_counter()
            line = server.stdout.readline()
            started = time.perf_counter() - begin
            url = next(word for word in line.split() if word.startswith("http"))
            return {"start_s": started, **asyncio.run(_watch(url, server.pid, seconds, query, begin))}
        finally:
            server.terminate()


async def _watch(url: str, pid: int, seconds: float, query: str, started: float) -> dict[str, float]:
    guest = await HeadlessClient(url, query=query).connect()
    await guest.wait_for(lambda v: v.mirror.replayed and any(name.endswith("/j7") for name in v.mirror.nodes))
    seen = time.perf_counter() - started
    await asyncio.sleep(SERVE_WARM_UP)
    guest.reset_counters()
    cpu, begin = _cpu_seconds(pid), time.perf_counter()
    await asyncio.sleep(seconds)
    cpu, elapsed = _cpu_seconds(pid) - cpu, time.perf_counter() - begin
    received = guest.received
    figures = {
        "arms_s": seen,
        "cpu_percent_of_a_core": 100.0 * cpu / elapsed,
        "frames_per_s": received.frames / elapsed,
        "messages_per_s": received.messages.total() / elapsed,
        "kB_per_s": received.bytes / elapsed / 1000.0,
    }
    await guest.close()
    return figures


def _cpu_seconds(pid: int) -> float:
    """Return the processor time that a process has used [s]; nan where the system does not tell."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii", errors="replace").rsplit(")", 1)[1].split()
    except OSError:
        return float("nan")
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def measure(steps: int, seconds: float) -> dict[str, Any]:
    """Return all figures, ready for JSON.

    Args:
        steps: measured of each scene.
        seconds: how long visitors are watched.
    """
    return _described(
        {
            **measure_steps(steps),
            "run of 46 s": measure_run(),
            "what if, 30 s again": measure_what_if(),
            "one visitor": measure_visitor(seconds),
            "one visitor, ghost and four plots": measure_visitor(seconds, FULL_PAGE),
            f"lecture with {WATCHERS} watchers": measure_crowd(WATCHERS, seconds, lecture=True),
            f"{SESSIONS} private sessions": measure_crowd(SESSIONS, seconds, lecture=False),
        }
    )


def measure_fairness(seconds: float, names: Iterable[str] = tuple(DOINGS)) -> dict[str, Any]:
    """Return what a neighbour sees while somebody else does each of `app.bench.fairness.DOINGS`, ready for JSON.

    Args:
        seconds: how long each is done.
        names: of those that are measured.
    """
    return _described({name: measure_neighbour(name, seconds) for name in names})


def _described(figures: Figures) -> dict[str, Any]:
    machine = f"{platform.machine()}, Python {platform.python_version()}, numpy {np.__version__}"
    return {"version": duet_version(), "machine": machine, "figures": figures}


def table_text(result: dict[str, Any]) -> str:
    """Return the figures as a table, and below it what takes the time where that was measured."""
    table = _table(result["figures"], lambda value: f"{value:.3g}" if abs(value) < 10 else f"{value:.1f}")
    limits = {name: limit_of(figures) for name, figures in result["figures"].items()}
    return "\n".join((table, *(f"{name:36s} {limit}" for name, limit in limits.items() if limit)))


def read_figures(path: Path) -> dict[str, Any]:
    """Return figures saved earlier.

    Raises:
        BadInputFile: no such file, or not such a file.
    """
    try:
        result = json.loads(read_file(path, MOST_BYTES))
        if not isinstance(result["figures"], dict):
            raise TypeError
    except OSError as error:
        raise BadInputFile(f"{path}: cannot be read ({error.strerror}).") from None
    except (ValueError, KeyError, TypeError, RecursionError):
        raise BadInputFile(f"{path}: is not a file that `bench --out` has written.") from None
    return result


def compare(now: dict[str, Any], before: dict[str, Any]) -> str:
    """Return a table of the ratios new : old of every figure that both have."""
    ratios: Figures = {}
    for name, figures in now["figures"].items():
        old = before["figures"].get(name, {})
        ratios[name] = {key: value / old[key] for key, value in figures.items() if old.get(key)}
    return f"\nratio to version {before.get('version', '?')}\n" + _table(ratios, lambda value: f"{value:.2f}x")


def _table(figures: Figures, shown: Any) -> str:
    lines: list[str] = []
    for name, row in figures.items():
        cells = "   ".join(f"{key} {shown(value)}" for key, value in row.items())
        lines.append(f"{name:36s} {cells}")
    return "\n".join(lines)
