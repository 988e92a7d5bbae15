"""The figures of `lwr-duet bench`."""

import statistics
from dataclasses import replace
from time import perf_counter_ns
from typing import Final

import numpy as np

from app.features.bench.figures_table import BenchRows
from app.features.bench.visitor import FULL_PAGE, measure_visitor
from controllers.compiled import load_now
from scenes.experiments import EXPERIMENTS
from scenes.laws import LAWS
from scenes.roles import TargetSource
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from scenes.targets import HandTarget

WARM_UP: Final = 600

BLOCK: Final = 200
"""Steps of one scene before the next one's turn."""

RESTLESS: Final = "hold, soft minimum, bounds at work"
"""A hand that jumps between two places at 1 m/s drives the avoiding arm to its velocity bounds."""


def measured_figures(steps: int, seconds: float, robot: str) -> BenchRows:
    """All figures. `seconds`: duration of each measurement of a visitor [s]."""
    yield from measure_steps(steps, robot).items()
    yield "one visitor", measure_visitor(seconds)
    yield "one visitor, ghost and four plots", measure_visitor(seconds, FULL_PAGE)


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
        **{
            f"hold, {law}": replace(base, law=replace(base.law, law=law))
            for law in LAWS
            if law != base.law.law
        },
        **{
            f"{scene}, soft minimum": replace(soft, scene=scene)
            for scene in EXPERIMENTS
            if scene != base.scene
        },
    }


class _Restless:
    """Alternates each second between the other arm's hand and the start."""

    def __init__(self, simulation: Simulation) -> None:
        kinematics = simulation.kinematics
        self._places = tuple(
            kinematics.hand_pose(arm).translation.copy() for arm in (simulation.avoiding, simulation.guided)
        )

    def target(self, time: float) -> HandTarget:
        return HandTarget(self._places[int(time) % 2])


def measure_steps(steps: int, robot: str) -> dict[str, dict[str, float]]:
    """Scene → median and 99th percentile of a step of both arms [µs], and share at a bound; interleaved."""
    load_now()
    runs: dict[str, tuple[Simulation, TargetSource]] = {}
    for name, settings in _scenes(robot).items():
        simulation = Simulation(settings)
        runs[name] = simulation, _Restless(simulation) if name == RESTLESS else simulation.source()
    for simulation, person in runs.values():
        for _ in range(WARM_UP):
            simulation.step(person.target(simulation.time))
    times: dict[str, list[int]] = {name: [] for name in runs}
    bounded = dict.fromkeys(runs, 0)
    for done in range(0, steps, BLOCK):
        for name, (simulation, person) in runs.items():
            for _ in range(min(BLOCK, steps - done)):
                target = person.target(simulation.time)
                begin = perf_counter_ns()
                simulation.step(target)
                times[name].append(perf_counter_ns() - begin)
                bounded[name] += simulation.bound_bites
    return {
        name: {
            "median_us": statistics.median(values) / 1000.0,
            "p99_us": float(np.percentile(values, 99)) / 1000.0,
            "bounded_share": bounded[name] / len(values),
        }
        for name, values in times.items()
    }
