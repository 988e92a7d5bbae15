"""Runs without a page, each simulated once."""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

from app.features.lessons.curve_drawing import true_curve
from app.features.lessons.lesson import Compared, Measurement
from app.features.lessons.runs import Pairs, Setup
from app.features.lessons.scripts import script
from app.features.measures.evidence import Evidence
from app.features.measures.quantities.quantity import Value, measure
from app.features.measures.room_places import start_positions
from app.plots.curve_chart import Curve
from app.plots.drawing_axes import Drawing
from scenes.recording import read_inputs
from scenes.roles import NO_TARGETS, TargetSource
from scenes.simulation import Simulation

KEPT_RUNS = 6
"""Whole runs in memory; of others only the values."""


def begin_reference_run(simulation: Simulation, setup: Setup) -> None:
    simulation.reset(start_positions(simulation.room, setup.start))


def person_of(
    simulation: Simulation, setup: Setup, kept: Mapping[str, TargetSource] | None = None
) -> TargetSource:
    """Targets for a simulation that has just begun; none if the student moves.

    Args:
        kept: motions of earlier steps, by name.
    """
    given = setup.input
    match given.kind:
        case "autopilot":
            return simulation.source()
        case "script":
            return script(given.name, given.parameters, simulation)
        case "file":
            return read_inputs(setup.folder / given.name)
        case "kept":
            if kept and given.name in kept:
                return kept[given.name]
            assert given.fallback is not None
            return person_of(simulation, replace(setup, input=given.fallback), kept)
        case _:
            return NO_TARGETS


@lru_cache(maxsize=KEPT_RUNS)
def simulated(setup: Setup) -> Simulation:
    """Finished simulation, read-only; the autopilot replaces the student."""
    run = setup.run
    steps = max(1, round(setup.seconds / run.dt))
    simulation = Simulation(run, steps)
    begin_reference_run(simulation, setup)
    person = simulation.source() if setup.input.kind == "yours" else person_of(simulation, setup)
    for _ in range(steps):
        simulation.step(person.target(simulation.time))
    return simulation


@lru_cache(maxsize=4096)
def measured(setup: Setup, name: str, parameters: Pairs = ()) -> Value:
    return measure(Evidence(simulated(setup)), name, parameters)


@lru_cache(maxsize=64)
def drawn(setup: Setup, drawing: Drawing) -> Curve:
    return true_curve(drawing, Evidence(simulated(setup)))


def comparisons(setup: Setup, m: Measurement, compared: tuple[Compared, ...]) -> tuple[Value, ...]:
    return tuple(measured(c.setup(setup), m.name, m.parameters) for c in compared)


def forget() -> None:
    for cached in (simulated, measured, drawn):
        cached.cache_clear()
