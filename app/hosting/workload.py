"""What the rounds of a frame loop take, and how many sessions a machine carries: estimated from the speed of its steps, then corrected."""

import math
import time
from typing import Final

from app.page.panels.server_load import ServerLoad
from app.session.clock import SLOWEST, budget_of
from controllers.compiled import GAIN, all_loaded
from scenes.settings import RunSettings
from scenes.simulation import Simulation

MEMORY: Final = 3.0
"""Rounds are averaged over about so long [s]."""

ENOUGH: Final = 2.5
"""With fewer sessions than this on average, rounds say little about what one more would take."""

BAND: Final = 0.1
"""The number of places changes when the measured one differs by more than this part."""

REPORT: Final = 1.0
"""Time between two reports [s]."""


class Workload:
    """Belongs to the frame loop's thread; `places` and `report` may be read from any.

    Args:
        places: sessions at once; to begin with, where they are corrected.
        loops: frame loops that share them.
        corrected: whether the measured rounds correct them.

    Attributes:
        sessions: that had a frame in the last round.
        report: of this frame loop, for the teacher.
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
        """Wall time that each session may use for its steps in one frame [s]."""
        return budget_of(self.sessions, self._drawing)

    def drew(self, stepping: float) -> None:
        """Count a session that had a frame in this round. `stepping`: wall time of its steps [s]."""
        self._drawn += 1
        self._stepping += stepping

    def note(self, work: float, elapsed: float) -> None:
        """Take note of a round. `work`: wall time that it took; `elapsed`: from its beginning to that of the next one [s]."""
        part = min(elapsed / MEMORY, 1.0) if self._interval else 1.0
        self._work += (work - self._work) * part
        self._mean_sessions += (self._drawn - self._mean_sessions) * part
        self._interval += (elapsed - self._interval) * part
        # What comes next is drawn like this.
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
"""What drawing and sending one session's frame costs, in steps of the room that a newcomer sees."""

BATCHES, BATCH = 5, 20
"""The steps that are timed: the quickest batch counts, as whatever else runs makes it slower only."""


def step_seconds() -> float:
    """Measure how much processor time one step takes here, in some 50 ms [s].

    Before the loops of a step are machine code, which takes longer to load than a first picture may wait, this is how long it will take.
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
    """Estimate how many sessions have 1 / `SLOWEST` frames a second at once, each at real time.

    Args:
        step: see `step_seconds` [s].
        loops: frame loops, and a core for each.
    """
    session = (SLOWEST / RunSettings().dt + DRAWING) * step
    return affordable(session) * loops


def affordable(session: float) -> int:
    """Number of sessions that fit into one frame loop, at least one. `session`: share of a round that each takes [s]."""
    return max(int(SLOWEST / max(session, 1e-9)), 1)
