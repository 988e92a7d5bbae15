"""Player of a recorded run, bit for bit.

`make_film` simulates the run once, in the background; `Replay` then seeks within a few milliseconds.
"""

import itertools
import math
import pickle
from bisect import bisect_right
from dataclasses import dataclass
from time import perf_counter
from typing import Final

import numpy as np

from controllers.kinematics import Array
from scenes.history import COLUMN, History
from scenes.inputs import Recorded, RecordedPerson
from scenes.rerun import LOOK, begun
from scenes.settings import RunSettings
from scenes.simulation import Simulation, Snapshot
from scenes.targets import Target
from scenes.wanted import while_wanted

SPACING: Final = 25

MOST_STATES: Final = 4_000

PERIOD: Final = 1.0 / 32.0
"""Simulated time per row of the curves, that of the smallest distance [s]. Four rows make one bin of the
plots."""

PAST: Final = 22.0
"""Length of the history before a moment [s], as of the plots' axis."""

BUDGET: Final = 0.02
"""Wall time for playing in one frame [s]."""

CAPACITY: Final = 8_000

AHEAD: Final = 10.0
"""Step of a long replay's time axis [s]; a run up to two steps long is drawn whole."""


@dataclass(frozen=True)
class RecordedFilm:
    """A recorded piece of a run, with snapshots.

    Attributes:
        spacing: steps between two snapshots.
        states: packed snapshots.
        rows: (k, columns of `scenes.history`), one every `PERIOD`.
        row_steps: (k,) step of each row, from 0.
    """

    recorded: Recorded
    spacing: int
    states: tuple[bytes, ...]
    rows: Array
    row_steps: np.ndarray


def make_film(recorded: Recorded) -> RecordedFilm:
    """Raises BadSetting if it cannot be computed here."""
    steps = recorded.steps
    spacing = max(SPACING, -(-steps // MOST_STATES))
    # A row is only needed until the best one of its period is known.
    simulation = begun(recorded)
    states: list[bytes] = []
    rows: list[Array] = []
    row_steps: list[int] = []
    period = -1
    for made, target in enumerate(while_wanted(recorded.targets(simulation), LOOK)):
        if made % spacing == 0:
            s = simulation.snapshot()
            state = s.steps, s.time, s.positions, s.velocities, s.memories, s.robot
            states.append(pickle.dumps(state, pickle.HIGHEST_PROTOCOL))
        number = int(simulation.time / PERIOD)
        simulation.step(target)
        row = simulation.history.table(1)[0]
        if number != period:
            period = number
            rows.append(row)
            row_steps.append(made)
        elif row[COLUMN["d"]] < rows[-1][COLUMN["d"]]:
            rows[-1], row_steps[-1] = row, made
    return RecordedFilm(recorded, spacing, tuple(states), np.array(rows), np.array(row_steps))


def make_films(recorded: Recorded, beside: Recorded | None) -> tuple[RecordedFilm, RecordedFilm | None]:
    return make_film(recorded), None if beside is None else make_film(beside)


class Replay:
    """Player of a recorded run.

    Attributes:
        simulation: present state and history; read only.
        speed: simulated over wall time.
        step: number of steps made, from 1; read only.
        target: of the newest step; read only.
    """

    def __init__(self, film: RecordedFilm) -> None:
        self.recorded = recorded = film.recorded
        self.playing = False
        self.speed = 1.0
        self._film = film
        moments = [np.array([recorded.begin])]
        for stretch in recorded.stretches:
            moments.append(moments[-1][-1] + np.arange(1, stretch.targets.steps + 1) * stretch.settings.dt)
        self._moments = np.concatenate(moments)
        """Time after each number of steps [s]."""
        self._ends = list(itertools.accumulate(stretch.targets.steps for stretch in recorded.stretches))
        self._person = RecordedPerson(recorded)
        self._debt = 0.0
        self.step = 0
        self.target: Target | None = None
        self._traced: tuple[float, Simulation] | None = None
        self.simulation = begun(recorded, CAPACITY)
        self._go(1)

    @property
    def begin(self) -> float:
        """Earliest moment [s], on the run's clock."""
        return self.moment(1)

    @property
    def end(self) -> float:
        """Latest moment [s]."""
        return self.moment(self.steps)

    @property
    def steps(self) -> int:
        return self._ends[-1]

    @property
    def time(self) -> float:
        return self.moment(self.step)

    @property
    def traced(self) -> Simulation:
        """Run up to the end of the plots' time axis; only its history counts."""
        length = self.end - self.begin
        piece = AHEAD if length > 2.0 * AHEAD else length
        pieces = math.ceil((self.time - self.begin) / piece - 1e-9) if piece > 0.0 else 1
        until = min(self.begin + max(pieces, 1) * piece, self.end)
        if self._traced is None or self._traced[0] != until:
            simulation = begun(self.recorded, CAPACITY)
            step = self.nearest(until)
            simulation.apply(self._settings_of(step - 1))
            self._fill(simulation, step)
            self._traced = until, simulation
        return self._traced[1]

    @property
    def nearest_moment(self) -> float | None:
        """Time of the smallest d [s]; None without an obstacle."""
        d = self._film.rows[:, COLUMN["d"]]
        return self.moment(int(self._film.row_steps[d.argmin()]) + 1) if np.isfinite(d).all() else None

    def moment(self, step: int) -> float:
        """Time after `step` steps [s]."""
        return float(self._moments[step])

    def nearest(self, time: float) -> int:
        """Steps made at the moment nearest to a time [s]; nan gives the beginning."""
        if not time > self.begin:
            return 1
        step = min(int(np.searchsorted(self._moments, time)), self.steps)
        return step - 1 if time - self._moments[step - 1] < self._moments[step] - time else step

    def seek(self, time: float) -> None:
        """Go to the moment nearest to a time [s]."""
        self.seek_step(self.nearest(time))

    def seek_step(self, step: int) -> None:
        self._debt = 0.0
        self._go(max(1, min(step, self.steps)))

    def toggle(self) -> None:
        self.playing = not self.playing
        self._debt = 0.0
        if self.playing and self.step >= self.steps:
            self._go(1)

    def advance(self, elapsed: float) -> None:
        """Play `elapsed` seconds of wall time; pause at the end."""
        if not self.playing:
            return
        self._debt += elapsed * self.speed
        made, deadline = 0, perf_counter() + BUDGET
        while self.step < self.steps:
            dt = self._settings_of(self.step).dt
            if self._debt < dt * (1.0 - 1e-9):
                return
            self._debt -= dt
            self._make_step()
            made += 1
            if made % 8 == 0 and perf_counter() > deadline:
                self._debt = 0.0
                return
        self.playing = False

    def _settings_of(self, step: int) -> RunSettings:
        return self.recorded.stretches[bisect_right(self._ends, step)].settings

    def _go(self, step: int) -> None:
        # The state before the step itself, so that there always is a newest step.
        state = (step - 1) // self._film.spacing
        if not state * self._film.spacing <= self.step <= step:
            self._jump(state)
        while self.step < step:
            self._make_step()

    def _make_step(self) -> None:
        settings = self._settings_of(self.step)
        if settings is not self.simulation.settings:
            self.simulation.apply(settings)
        self.target = self._person.target_of_step(self.step)
        self.simulation.step(self.target)
        self.step += 1

    def _jump(self, state: int) -> None:
        self.step = state * self._film.spacing
        settings = self._settings_of(self.step)
        self.simulation.apply(settings)
        self.simulation.resume(Snapshot(settings, *pickle.loads(self._film.states[state])))
        self._fill(self.simulation, self.step)

    def _fill(self, simulation: Simulation, step: int) -> None:
        # Another one, so that its readers notice the jump.
        simulation.history = History(CAPACITY, len(simulation.positions))
        rows = self._film.rows[: np.searchsorted(self._film.row_steps, step)]
        first = int(np.searchsorted(rows[:, COLUMN["t"]], rows[-1, COLUMN["t"]] - PAST)) if len(rows) else 0
        simulation.history.begin_with(rows[first:])
