"""How many sessions a machine carries: an estimate from the speed of its steps, to be corrected by what rounds take."""

import math
import time
from typing import Final

from app.session.clock import SLOWEST
from scenes.settings import RunSettings
from scenes.simulation import Simulation

HEADROOM: Final = 0.9
"""Part of a frame that sessions may fill."""

DRAWING: Final = 20.0
"""What drawing and sending one session's frame costs, in steps of the room that a newcomer sees."""

BATCHES, BATCH = 5, 20
"""The steps that are timed: the quickest batch counts, as whatever else runs makes it slower only."""


def step_seconds() -> float:
    """Measure how much processor time one step takes here, in some 10 ms [s]."""
    run = RunSettings()
    simulation, least = Simulation(run), math.inf
    source = simulation.source()
    for _ in range(BATCHES):
        begin = time.thread_time()
        for _ in range(BATCH):
            simulation.step(source.target(simulation.time))
        least = min(least, (time.thread_time() - begin) / BATCH)
    return least


def places(step: float, loops: int = 1) -> int:
    """Estimate how many sessions have 1 / `SLOWEST` frames a second at once, each at real time.

    Args:
        step: see `step_seconds` [s].
        loops: processes with a frame loop each, and a core for each.
    """
    session = (SLOWEST / RunSettings().dt + DRAWING) * step
    return affordable(session) * loops


def affordable(session: float) -> int:
    """Return how many sessions fit into one frame loop, at least one. `session`: what each takes of a round [s]."""
    return max(int(HEADROOM * SLOWEST / max(session, 1e-9)), 1)
