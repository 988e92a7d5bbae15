"""The rolling time series of the live plots: the last 20 s of a run in bins, and the elbow's angle, which is one of them."""

import math
from typing import Final

import numpy as np
import pinocchio as pin

from app.plots.bins import LAST, Bins, bin_numbers
from controllers.budget import resting_distance
from controllers.kinematics import Arm, Array
from scenes.history import COLUMN, History
from scenes.law_answers import LawOfFile
from scenes.room import Room
from scenes.settings import RunSettings
from scenes.simulation import Simulation


class Swivel:
    """Measures the angle of one arm's elbow, at any posture.

    Args:
        room: with the arm.
        arm: which.
    """

    def __init__(self, room: Room, arm: Arm) -> None:
        self._model, self._data, self._arm = room.model, room.model.createData(), arm
        self._last = math.nan

    def angle(self, positions: Array) -> float:
        """Return the angle at q (nv,) [rad], 0 where the elbow points straight up; without jumps from one call to the next.

        nan while the arm is straight, or reaches straight up: the elbow then points nowhere, or there is no "up" across the line.
        """
        pin.forwardKinematics(self._model, self._data, positions)
        shoulder, elbow, wrist = (
            self._data.oMi[joint].translation for joint in (self._arm.shoulder, self._arm.elbow, self._arm.wrist)
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
follows; and the same of the other arm. `changes`: how often another pair has become the closest one so far."""

COLUMNS: Final = {name: i for i, name in enumerate(NAMES)}

_SAME: Final = ("t", "d", "e2", "lambda", "u", "w", "e2_b", "pair")
_SAME_COLUMNS: Final = [COLUMNS[name] for name in _SAME]
_SAME_SCALARS: Final = [COLUMN[name] for name in _SAME]

FARTHEST: Final = 0.8
"""A resting distance beyond this is none: nothing pulls, and its line leaves the axis at the top [m]."""


def resting(settings: RunSettings, pull: float, approach: float, second_pull: float | None) -> float:
    """Return d* [m] of the present law, inf if nothing pulls, nan if it has none in closed form or d falls for ever.

    Args:
        pull: u of the arm that keeps clear, or of both as one if they are coupled [m/s].
        approach: w [m/s].
        second_pull: u of the second arm if it keeps clear by a row of its own, else None [m/s].
    """
    law = settings.law
    d_m, n, v = law.critical_distance, law.order, law.nominal_velocity
    if not law.entry.rests:
        return math.nan
    if second_pull is not None:
        # 2 λ v = (1 − λ)(u_1 + u_2) is the rest of one arm that is pulled by their mean.
        return resting_distance(d_m, n, v, (pull + second_pull) / 2.0)
    if settings.adds_w:
        v += approach
    return resting_distance(d_m, n, v, pull, approach)


def signals(simulation: Simulation, run: RunSettings, table: Array) -> Array:
    """Return the columns of `NAMES` (rows, columns) of rows of a history in which these settings were in force; nan where there is nothing.

    The elbow's angle and the changes of the pair stay nan: they depend on the rows before.
    """
    history, c, s = simulation.history, COLUMNS, COLUMN
    found = np.full((len(table), len(NAMES)), np.nan)
    found[:, _SAME_COLUMNS] = table[:, _SAME_SCALARS]
    found[:, c["d_m"]], found[:, c["v"]] = run.law.critical_distance, run.law.nominal_velocity
    found[:, c["e"]] = np.sqrt(table[:, s["e2"]])
    if run.law.entry.rests and not isinstance(simulation.law, LawOfFile):
        columns = table[:, [s["u"], s["w_law"], s["u_b"]]].tolist()
        found[:, c["d*"]] = [min(resting(run, u, w, None if u_b != u_b else u_b), FARTHEST) for u, w, u_b in columns]
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
    """The last 20 s in bins, one column for every entry of `NAMES`."""

    def __init__(self) -> None:
        self.bins = Bins(len(NAMES))
        self._history: History | None = None
        self._swivel: Swivel | None = None
        self._seen = 0
        self._last_pair, self._changes = -1.0, 0.0

    def feed(self, simulation: Simulation) -> None:
        """Take in every step made since the last call."""
        history = simulation.history
        if history is not self._history:
            self._history, self.bins = history, Bins(len(NAMES))
            self._seen, self._last_pair, self._changes = 0, -1.0, 0.0
            self._swivel = (
                Swivel(simulation.room, simulation.avoiding) if simulation.settings.experiment.obstacle == "nothing" else None
            )
        if history.count == self._seen:
            return
        table = history.table(history.count - self._seen)
        self._seen = history.count
        self.bins.take(table[:, COLUMN["t"]], self._signals(simulation, table))

    def _signals(self, simulation: Simulation, table: Array) -> Array:
        """Return all columns (rows, columns) of so many steps."""
        found, c = signals(simulation, simulation.settings, table), COLUMNS
        pairs = found[:, c["pair"]]
        before = np.concatenate([[self._last_pair if self._last_pair >= 0.0 else pairs[0]], pairs[:-1]])
        found[:, c["changes"]] = self._changes + np.cumsum(pairs != before)
        self._changes, self._last_pair = float(found[-1, c["changes"]]), float(pairs[-1])
        if self._swivel is not None:
            # It takes a look at the whole arm, and moves as smoothly as the arm: once a bin is enough.
            positions = simulation.history.positions(table)
            for row in np.flatnonzero(np.diff(bin_numbers(table[:, COLUMN["t"]]), append=-1)).tolist():
                found[row, c["elbow"]] = self._swivel.angle(np.ascontiguousarray(positions[row]))
        return found

    def newest(self, columns: list[int]) -> tuple[Array, ...]:
        """Return time and the newest values of the columns, bin by bin, oldest first."""
        numbers = self.bins.numbers
        return self.bins.ends(numbers), *self.bins.at(numbers, columns)[LAST]


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
