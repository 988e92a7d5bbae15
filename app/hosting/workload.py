"""Measured load, and a machine's number of sessions."""

import math
import time
from typing import Final

from app.page.panels.server_load import ServerLoad
from app.session.clock import SLOWEST, budget_of
from controllers.compiled import GAIN, all_loaded
from scenes.settings import RunSettings
from scenes.simulation import Simulation

MEMORY: Final = 3.0
"""Time constant of averages [s]."""

ENOUGH: Final = 2.5
"""Fewer mean sessions say little about the cost of one more."""

BAND: Final = 0.1
"""Relative deviation from which the measured number of places is used."""

REPORT: Final = 1.0


class Workload:
    """Measures rounds. Frame loop's thread only; `places` and `report` can be read from any.

    Args:
        loops: frame loops that share them.
        corrected: correct `places` by measured rounds.

    Attributes:
        sessions: with a frame in the last round.
    """

    def __init__(self, places: int, loops: int = 1, corrected: bool = False) -> None:
        self.places, self._loops, self._corrected = places, loops, corrected
        self.report = ServerLoad(0, 0, max(places // loops, 1), 0)
        self._drawn, self._stepping = 0, 0.0
        self.sessions = 0
        self._work = self._drawing = self._mean_sessions = self._interval = 0.0
        self._since_report = 0.0

    @property
    def budget(self) -> float:
        """Wall time for each session's steps in one frame [s]."""
        return budget_of(self.sessions, self._drawing)

    def drew(self, stepping: float) -> None:
        """Count a session's frame. `stepping`: wall time of the session's steps [s]."""
        self._drawn += 1
        self._stepping += stepping

    def note(self, work: float, elapsed: float) -> None:
        """Record a round. `work`: wall time of the round; `elapsed`: time to the next one's beginning [s]."""
        part = min(elapsed / MEMORY, 1.0) if self._interval else 1.0
        self._work += (work - self._work) * part
        self._mean_sessions += (self._drawn - self._mean_sessions) * part
        self._interval += (elapsed - self._interval) * part
        # The next round's drawing is assumed to take as long.
        self._drawing = work - self._stepping
        self.sessions, self._drawn, self._stepping = self._drawn, 0, 0.0
        if self._corrected and self._mean_sessions >= ENOUGH:
            measured = affordable(self._work / self._mean_sessions) * self._loops
            if abs(measured - self.places) > BAND * self.places:
                self.places = measured
        self._since_report += elapsed
        if self._since_report >= REPORT:
            self._since_report = 0.0
            frames, load = round(1.0 / max(self._interval, 1e-9)), round(100.0 * self._work / SLOWEST)
            self.report = ServerLoad(frames, self.sessions, max(self.places // self._loops, 1), load)


DRAWING: Final = 36.0
"""Cost of a frame besides steps [steps of the usual room]."""

BATCHES, BATCH = 5, 20
"""Timed batches, and steps of each; the quickest batch counts."""


def step_seconds() -> float:
    """Processor time of one step, measured within about 50 ms [s]; an estimate until the loops are compiled,
    which takes too long for a first picture.
    """
    run = RunSettings()
    simulation, least = Simulation(run), math.inf
    source = simulation.source()
    for _ in range(BATCHES):
        begin = time.thread_time()
        for _ in range(BATCH):
            simulation.step(source.target(simulation.time))
        least = min(least, (time.thread_time() - begin) / BATCH)
    return least if all_loaded() else least / GAIN


def places(step: float, loops: int = 1) -> int:
    """Estimated real-time sessions at 1 / `SLOWEST` frames a second. `step`: see `step_seconds` [s]."""
    session = (SLOWEST / RunSettings().dt + DRAWING) * step
    return affordable(session) * loops


def affordable(session: float) -> int:
    """Sessions in one frame loop, at least one. `session`: its share of a round [s]."""
    return max(int(SLOWEST / max(session, 1e-9)), 1)
