"""A run's last 20 s in bins, for live plots."""

import math
from typing import Final

import numpy as np
import pinocchio as pin

from app.plots.bins import LAST, Bins, bin_numbers
from controllers.budget import resting_distance
from controllers.kinematics import Arm, Array
from scenes.history import COLUMN, History, Sample
from scenes.law_answers import LawOfFile
from scenes.room import Room
from scenes.settings import RunSettings
from scenes.simulation import Simulation


class Swivel:
    def __init__(self, room: Room, arm: Arm) -> None:
        self._model, self._data, self._arm = room.model, room.model.createData(), arm
        self._last = math.nan

    def angle(self, positions: Array) -> float:
        """Elbow angle at q (nv,) [rad], 0 if the elbow points straight up; continuous from call to call. nan
        while the arm is straight or points straight up.
        """
        pin.forwardKinematics(self._model, self._data, positions)
        shoulder, elbow, wrist = (
            self._data.oMi[joint].translation
            for joint in (self._arm.shoulder, self._arm.elbow, self._arm.wrist)
        )
        way = wrist - shoulder
        way /= math.sqrt(float(way.dot(way))) or 1.0
        out = elbow - shoulder
        out -= way * float(way.dot(out))
        up = np.array([0.0, 0.0, 1.0]) - way * float(way[2])
        if float(out.dot(out)) < 1e-8 or float(up.dot(up)) < 1e-8:
            return math.nan
        x, y, z = way.tolist()
        across = np.array([y * up[2] - z * up[1], z * up[0] - x * up[2], x * up[1] - y * up[0]])
        angle = math.atan2(float(out.dot(across)), float(out.dot(up)))
        if self._last == self._last:
            angle += 2.0 * math.pi * round((self._last - angle) / (2.0 * math.pi))
        self._last = angle
        return angle


JOINTS: Final = 7
"""Joint columns; smaller arms leave the last ones empty."""

DRIVEN: Final = 4
"""Joints shown with their desired positions, as in Figs 6 and 7."""


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
"""Time; signals of `scenes.history.SCALARS`; q, q̇ and elbow angle [rad] of the avoiding arm, and what it
follows; the same of the other arm. `changes`: of the closest pair so far.
"""

COLUMNS: Final = {name: i for i, name in enumerate(NAMES)}

_SAME: Final = ("t", "d", "e2", "lambda", "u", "w", "e2_b", "pair")
_SAME_COLUMNS: Final = [COLUMNS[name] for name in _SAME]
_SAME_SCALARS: Final = [COLUMN[name] for name in _SAME]

FARTHEST: Final = 0.8
"""A larger resting distance means that nothing pulls [m]."""


TURNS: Final = 0.25
"""Time within which closest pairs count as alternating [s]."""


def rows_of_turns(settings: RunSettings) -> int:
    return max(1, round(TURNS / settings.dt)) if settings.law.pairs == "single" else 1


_REST: Final = [COLUMN[name] for name in ("d", "law_d", "u", "w_law", "lever", "u_b", "lever_b")]


def resting_rows(settings: RunSettings, table: Array) -> list[float]:
    """True resting distance d [m] of each row of a history (rows, columns): d* + (d − d_law), as the law
    rests at d* of its own distance d_law. inf if nothing pulls, nan if the law has no rest in closed form or
    d falls for ever.
    """
    return [_resting(settings, *row) for row in table[:, _REST].tolist()]


def resting_at_end(settings: RunSettings, table: Array) -> float:
    """True resting distance d [m] if everything continues as in the last row of a history (rows, columns);
    the mean over time if two closest pairs alternate.
    """
    if settings.law.pairs == "single":
        # In a replay rows may be further apart.
        turns = table[table[:, COLUMN["t"]] > table[-1, COLUMN["t"]] - TURNS]
        if np.ptp(turns[:, COLUMN["pair"]]) > 0.0:
            return float(np.mean(resting_rows(settings, turns)))
    return resting_rows(settings, table[-1:])[0]


def resting_now(simulation: Simulation, sample: Sample) -> float:
    """`resting_at_end` [m]. `sample`: newest step, or the measurement before the first."""
    settings, history = simulation.settings, simulation.history
    if history.count:
        return resting_at_end(settings, history.table(rows_of_turns(settings)))
    second = sample.second
    others = (math.nan, math.nan) if second is None else (second.pull, second.lever)
    now = sample.distance, sample.law_distance, sample.pull, sample.law_approach, sample.lever
    return _resting(settings, *now, *others)


def _resting(
    settings: RunSettings,
    d: float,
    d_law: float,
    u: float,
    w: float,
    s: float,
    second_u: float,
    second_s: float,
) -> float:
    law = settings.law
    d_m, n, v = law.critical_distance, law.order, law.nominal_velocity
    if not law.entry.rests:
        return math.nan
    if second_u == second_u:
        # λ [s_1 (v + u_1) + s_2 (v + u_2)] = u_1 + u_2 is the rest of one arm that has their mean pull.
        mean = (u + second_u) / 2.0
        asked = 2.0 * (v + mean)
        share = (s * (v + u) + second_s * (v + second_u)) / asked if asked > 0.0 else 1.0
        return resting_distance(d_m, n, v, mean, lever=share) + (d - d_law)
    if settings.adds_w:
        v += w
    return resting_distance(d_m, n, v, u, w, s) + (d - d_law)


def signals(simulation: Simulation, run: RunSettings, table: Array) -> Array:
    """Columns `NAMES` (rows, columns) for rows of a history, nan for missing values. Elbow angle and pair
    changes stay nan: they depend on earlier rows.
    """
    history, c, s = simulation.history, COLUMNS, COLUMN
    found = np.full((len(table), len(NAMES)), np.nan)
    found[:, _SAME_COLUMNS] = table[:, _SAME_SCALARS]
    found[:, c["d_m"]], found[:, c["v"]] = run.law.critical_distance, run.law.nominal_velocity
    found[:, c["e"]] = np.sqrt(table[:, s["e2"]])
    if run.law.entry.rests and not isinstance(simulation.law, LawOfFile):
        found[:, c["d*"]] = [min(rest, FARTHEST) for rest in resting_rows(run, table)]
    q, dq, desired = history.positions(table), history.velocities(table), history.desired(table)
    own, other = simulation.avoiding.joints, simulation.guided.joints
    count = min(own.stop - own.start, JOINTS)
    found[:, c["q1"] : c["q1"] + count] = q[:, own][:, :count]
    found[:, c["dq1"] : c["dq1"] + count] = dq[:, own][:, :count]
    followed = ~np.isnan(desired[:, own.start])
    for name, what, joints in (("qd1", desired, own), ("other_q1", q, other), ("other_qd1", desired, other)):
        found[followed, c[name] : c[name] + DRIVEN] = what[followed, joints][:, :DRIVEN]
    return found


class RollingSeries:
    """One column per entry of `NAMES`."""

    def __init__(self) -> None:
        self.bins = Bins(len(NAMES))
        self._history: History | None = None
        self._swivel: Swivel | None = None
        self._seen = 0
        self._last_pair, self._changes = -1.0, 0.0

    def feed(self, simulation: Simulation) -> None:
        history = simulation.history
        if history is not self._history:
            self._history, self.bins = history, Bins(len(NAMES))
            self._seen, self._last_pair, self._changes = 0, -1.0, 0.0
            self._swivel = (
                Swivel(simulation.room, simulation.avoiding)
                if simulation.settings.experiment.obstacle == "nothing"
                else None
            )
        if history.count == self._seen:
            return
        table = history.table(history.count - self._seen)
        self._seen = history.count
        self.bins.take(table[:, COLUMN["t"]], self._signals(simulation, table))

    def _signals(self, simulation: Simulation, table: Array) -> Array:
        found, c = signals(simulation, simulation.settings, table), COLUMNS
        pairs = found[:, c["pair"]]
        before = np.concatenate([[self._last_pair if self._last_pair >= 0.0 else pairs[0]], pairs[:-1]])
        found[:, c["changes"]] = self._changes + np.cumsum(pairs != before)
        self._changes, self._last_pair = float(found[-1, c["changes"]]), float(pairs[-1])
        if self._swivel is not None:
            # It needs the whole arm and is as smooth as the arm: once per bin is enough.
            positions = simulation.history.positions(table)
            for row in np.flatnonzero(np.diff(bin_numbers(table[:, COLUMN["t"]]), append=-1)).tolist():
                found[row, c["elbow"]] = self._swivel.angle(np.ascontiguousarray(positions[row]))
        return found

    def newest(self, columns: list[int]) -> tuple[Array, ...]:
        """Times and newest values, oldest bin first."""
        numbers = self.bins.numbers
        return self.bins.ends(numbers), *self.bins.at(numbers, columns)[LAST]


def drawable(line: Array, follows: bool) -> Array:
    """A line (k,) for the page, nan for missing values; empty without values.

    It is level up to its first value if the axis follows the data: otherwise the page finds no range and
    draws no line of the plot.
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
