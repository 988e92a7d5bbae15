"""What a step costs, and with it a whole run and the curves of "what if"."""

import statistics
import subprocess
import sys
import time
from dataclasses import replace
from time import perf_counter_ns
from typing import Final

import numpy as np

from app.runtime.job_pool import JobPool
from app.session.session import Session
from app.settings import Settings
from controllers.compiled import load_now
from scenes.experiments import EXPERIMENTS, HOLD
from scenes.laws import LAWS
from scenes.roles import TargetSource
from scenes.settings import RunSettings, changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget

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
        command = [sys.executable, "-m", "app", "run", "--scene", HOLD, "--seconds", seconds]
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
