"""Recorded runs to keep, made once."""

from __future__ import annotations

from functools import cache
from typing import Any

from controllers.kinematics import Array
from scenes.inputs import InputsLog, Recorded
from scenes.settings import RunSettings, changed
from scenes.simulation import Simulation


def given(**changes: object) -> RunSettings:
    """The default settings with a few changes, by key."""
    settings = RunSettings()
    for key, value in changes.items():
        settings = changed(settings, key, value)
    return settings


@cache
def piece(
    scene: str, seconds: float = 3.0, window: float = 99.0, lively: bool = False, law: str = "smooth_priority"
) -> tuple[Recorded, Array]:
    """A piece of a run with the experiment's own person, and its table; in a lively one the settings change twice."""
    settings = given(scene=scene, law=law, ball="cross" if scene == "ball" else "still")
    later: dict[float, dict[str, Any]] = {0.45: {"dm": 0.11}, 0.7: {"k": 3.0, "dt": 0.004, "v": 0.4}} if lively else {}
    simulation, log = Simulation(settings), InputsLog()
    person = simulation.person()
    while simulation.time < seconds - 1e-9:
        for share in [share for share in later if simulation.time >= share * seconds]:
            for key, value in later.pop(share).items():
                simulation.apply(changed(simulation.settings, key, value))
        target = person.target(simulation.time)
        log.record(simulation, target)
        simulation.step(target)
    recorded = log.window(window)
    assert recorded is not None
    return recorded, simulation.history.table(recorded.steps)
