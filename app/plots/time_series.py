"""The rolling time series of the live plots: the last 20 s of a run in bins."""

import math
from typing import Final

import numpy as np

from app.custom_law.custom_law import CustomLaw
from app.session.elbow_swivel import Swivel
from controllers.budget import resting_distance
from controllers.kinematics import Array
from scenes.history import COLUMN, History
from scenes.settings import RunSettings
from scenes.simulation import Simulation

WINDOW: Final = 20.0
"""Length of the time axis [s]."""

POINTS: Final = 160
"""Bins of the time axis. A bin keeps the smallest d and the largest e² in it, so that no dip between two points is lost."""

JOINTS: Final = 7
"""Columns for the joints of an arm; one with fewer leaves the last of them empty."""

DRIVEN: Final = 4
"""Joints of an arm that are shown beside those they follow, as in Figs 6 and 7."""


def _names(stem: str, count: int) -> tuple[str, ...]:
    return tuple(f"{stem}{i + 1}" for i in range(count))


NAMES: Final = (
    *("t", "d", "d_m", "d*", "e2", "lambda", "u", "v", "w"),
    *_names("q", JOINTS),
    *_names("dq", JOINTS),
    *("e", "e2_b", "pair", "changes", "elbow"),
    *_names("qd", DRIVEN),
    *_names("other_q", DRIVEN),
    *_names("other_qd", DRIVEN),
)
"""Columns: time, then what is written beside `scenes.history.SCALARS`; q and q̇ of the avoiding arm, its elbow's angle [rad], what it
follows; and the same of the other arm. `changes`: how often another pair became the closest one."""

COLUMNS: Final = {name: i for i, name in enumerate(NAMES)}

FARTHEST: Final = 0.8
"""A resting distance beyond this is none: nothing pulls, and its line leaves the axis at the top [m]."""


RESTING: Final = ("smooth_priority", "intermediate_value")
"""Laws with a resting distance in closed form."""


def resting(settings: RunSettings, pull: float, approach: float, second_pull: float | None) -> float:
    """Return d* [m] of the present law, inf if nothing pulls, nan if it has none in closed form or d falls for ever.

    Args:
        pull: u of the arm that keeps clear, or of both as one if they are coupled [m/s].
        approach: w [m/s].
        second_pull: u of the second arm if it keeps clear by a row of its own, else None [m/s].
    """
    law = settings.law
    d_m, n, v = law.critical_distance, law.order, law.nominal_velocity
    if law.law not in RESTING:
        return math.nan
    if second_pull is not None:
        # 2 λ v = (1 − λ)(u_L + u_R) is the rest of one arm that is pulled by their mean.
        return resting_distance(d_m, n, v, (pull + second_pull) / 2.0)
    if law.feed_forward and law.law == "smooth_priority":
        v += approach
    return resting_distance(d_m, n, v, pull, approach)


class RollingSeries:
    """The last 20 s in bins, one column for every entry of `NAMES`."""

    def __init__(self) -> None:
        self._bins = np.full((POINTS, len(NAMES)), np.nan)
        self._history: History | None = None
        self._swivel: Swivel | None = None
        self._seen = 0
        self._last_row: Array | None = None
        self._last_bin = -1
        self._last_pair = -1.0

    def clear(self) -> None:
        self._bins[:] = np.nan
        self._seen, self._last_row, self._last_bin, self._last_pair = 0, None, -1, -1.0

    def feed(self, simulation: Simulation) -> None:
        """Take in every step made since the last call."""
        history = simulation.history
        if history is not self._history or self._restarted(history):
            self.clear()
            self._history = history
            self._swivel = Swivel(simulation.room, simulation.avoiding) if simulation.settings.scene == "solo" else None
        if history.count == self._seen:
            return
        table = history.table(history.count - self._seen)
        self._seen, self._last_row = history.count, table[-1].copy()
        numbers = (table[:, COLUMN["t"]] * (POINTS / WINDOW)).astype(int)
        for number in np.unique(numbers).tolist():
            rows = np.flatnonzero(numbers == number)
            if number != self._last_bin:
                # A long step may jump over a bin; what is left in the ring from 20 s ago must go.
                first = max(self._last_bin + 1, number - POINTS + 1)
                for skipped in range(first, number + 1):
                    self._bins[skipped % POINTS] = np.nan
                self._last_bin = number
            self._fill(self._bins[number % POINTS], simulation, table[rows[0] : rows[-1] + 1])

    def _restarted(self, history: History) -> bool:
        """Return whether the history was cleared since the last call, even if it has as many steps again by now."""
        new = history.count - self._seen
        if new < 0 or self._last_row is None:
            return new < 0
        table = history.table(new + 1)
        # With more new steps than the history stores, none of the old bins is left.
        return len(table) == new + 1 and not np.array_equal(table[0], self._last_row, equal_nan=True)

    def _fill(self, b: Array, simulation: Simulation, table: Array) -> None:
        """Take the rows of one bin into it."""
        run, last = simulation.settings, table[-1]
        law, c, s = run.law, COLUMNS, COLUMN
        d, e2 = float(table[:, s["d"]].min()), float(table[:, s["e2"]].max())
        u, w, u_b = float(last[s["u"]]), float(last[s["w_law"]]), float(last[s["u_b"]])
        rest = math.nan if isinstance(simulation.law, CustomLaw) else resting(run, u, w, None if u_b != u_b else u_b)
        b[c["t"]] = last[s["t"]]
        b[c["d"]] = d if not b[c["d"]] < d else b[c["d"]]
        b[c["d_m"]] = law.critical_distance
        b[c["d*"]] = min(rest, FARTHEST)
        b[c["e2"]] = e2 if not b[c["e2"]] > e2 else b[c["e2"]]
        b[c["e"]] = math.sqrt(b[c["e2"]])
        b[c["lambda"] : c["w"] + 1] = last[s["lambda"]], u, law.nominal_velocity, last[s["w"]]
        b[c["e2_b"]], b[c["pair"]] = last[s["e2_b"]], last[s["pair"]]
        pairs = table[:, s["pair"]]
        changes = int(np.count_nonzero(pairs[1:] != pairs[:-1])) + int(pairs[0] != self._last_pair >= 0.0)
        b[c["changes"]] = changes if b[c["changes"]] != b[c["changes"]] else b[c["changes"]] + changes
        self._last_pair = float(pairs[-1])
        history, row = simulation.history, table[-1:]
        q, dq, desired = history.positions(row)[0], history.velocities(row)[0], history.desired(row)[0]
        own = simulation.avoiding.joints
        count = min(own.stop - own.start, JOINTS)
        b[c["q1"] : c["q1"] + count] = q[own][:count]
        b[c["dq1"] : c["dq1"] + count] = dq[own][:count]
        if self._swivel is not None:
            b[c["elbow"]] = self._swivel.angle(q)
        if desired[own.start] == desired[own.start]:
            other = simulation.guided.joints
            b[c["qd1"] : c["qd1"] + DRIVEN] = desired[own][:DRIVEN]
            b[c["other_q1"] : c["other_q1"] + DRIVEN] = q[other][:DRIVEN]
            b[c["other_qd1"] : c["other_qd1"] + DRIVEN] = desired[other][:DRIVEN]

    def series(self, columns: tuple[int, ...], scale: float = 1.0) -> tuple[Array, ...]:
        """Return time and the columns asked for, oldest first, in equal lengths; columns times `scale`."""
        rows = self._rows()
        if len(rows) < 2:
            # uPlot needs an extent; nothing but the axes of the second to come is drawn.
            begin = 0.0 if not len(rows) else float(rows[-1, 0])
            return (np.array([begin, begin + 1.0]), *(np.full(2, np.nan) for _ in columns))
        return (rows[:, 0], *(rows[:, c] * scale for c in columns))

    def beside(self, leader: "RollingSeries", columns: tuple[int, ...], scale: float = 1.0) -> tuple[Array, ...]:
        """Return the columns asked for at the leader's bins, of the lengths of its `series`; nan where there is nothing yet.

        Up to where this run begins it was the leader's.
        """
        numbers = leader._numbers()
        if len(numbers) < 2:
            return tuple(np.full(2, np.nan) for _ in columns)
        rows = self._bins[numbers % POINTS]
        rows[(numbers > self._last_bin) | (numbers <= self._last_bin - POINTS)] = np.nan
        known = ~np.isnan(rows[:, 0])
        # The page finds no range for an axis if a line's first value is missing.
        before = numbers[: int(known.argmax())] if self._last_bin >= 0 else numbers
        rows[: len(before)] = leader._bins[before % POINTS]
        return tuple(rows[:, c] * scale for c in columns)

    def along(self, curve: "Curve", column: int) -> Array:
        """Return another curve at the bins of this one, nan where there is nothing; of the length of its `series`.

        Up to where it begins it was this run's column.
        """
        numbers = self._numbers()
        if len(numbers) < 2:
            return np.full(2, np.nan)
        found = np.full(len(numbers), np.nan)
        places = np.searchsorted(curve.numbers, numbers)
        inside = places < len(curve.numbers)
        inside[inside] = curve.numbers[places[inside]] == numbers[inside]
        found[inside] = curve.values[places[inside]]
        before = numbers < curve.numbers[0]
        found[before] = self._bins[numbers[before] % POINTS, column]
        return found

    def _rows(self) -> Array:
        return self._bins[self._numbers() % POINTS]

    def _numbers(self) -> np.ndarray:
        """Return the numbers of the bins that hold something, oldest first."""
        newest = self._last_bin
        numbers = np.arange(newest - POINTS + 1, newest + 1)
        return numbers[~np.isnan(self._bins[numbers % POINTS, 0])]


def drawable(line: Array, follows: bool) -> Array:
    """Return a line as the page can draw it: an empty one if there is nothing on it.

    The page finds no range for an axis that follows the data, and then draws none of the plot's lines, if the first value of one of
    them is missing; so such a line stays level up to its first value.

    Args:
        line: (k,), nan where there is nothing.
        follows: whether the axis follows the data.
    """
    known = np.isfinite(line) if follows else ~np.isnan(line)
    if not known.any():
        return np.empty(0)
    if not follows or known[0]:
        return line
    line = line.copy()
    first = int(known.argmax())
    line[:first] = line[first]
    return line


class Curve:
    """A curve over time in the bins of a `RollingSeries`.

    Args:
        times: (k,) ascending [s].
        values: (k,).
        smallest: whether a bin keeps its smallest value, or its largest.
    """

    def __init__(self, times: Array, values: Array, smallest: bool) -> None:
        numbers = (times * (POINTS / WINDOW)).astype(int)
        self.numbers, starts = np.unique(numbers, return_index=True)
        self.values: Array = (np.minimum if smallest else np.maximum).reduceat(values, starts)
