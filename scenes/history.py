"""Recorded steps in a ring of fixed size."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from controllers.kinematics import Array

SCALARS: Final = (
    *("t", "d", "lambda", "e2", "u", "w", "pair", "law_d", "w_law", "authority", "joint", "lever"),
    *("e2_b", "u_b", "w_b", "w_law_b", "authority_b", "joint_b", "lever_b"),
)
"""Columns before the joints: time [s], true distance [m], λ, squared error of the task [m² or rad²], pull and
approach [m/s], closest pair or −1, the law's distance [m], approach along the law's row [m/s], `Authority`,
its joint, and s of `controllers.laws.situation.lever`. _b: of the second arm that keeps clear, else nan.
"""

COLUMN: Final = {name: i for i, name in enumerate(SCALARS)}
_HEAD: Final = len(SCALARS)
_FIRST: Final = COLUMN["e2_b"]


def unit_of(column: str, error_unit: str, unit: str = "m") -> str:
    """Unit of a column, or "". `error_unit`: of the squared error; `unit`: of the first task."""
    known = {"t": "s", "d": unit, "law_d": unit, "e2": error_unit, "e2_b": error_unit}
    known |= dict.fromkeys(("u", "w", "w_law", "u_b", "w_b", "w_law_b"), f"{unit}/s")
    if column in known or column in SCALARS:
        return known.get(column, "")
    length = column.endswith(("_x", "_y", "_z"))
    if "_dq" in column:
        return "m/s" if length else "rad/s"
    return "m" if length else "rad"


@dataclass(frozen=True)
class ArmSample:
    """Signals of an arm that keeps clear, as in `SCALARS`."""

    squared_error: float
    pull: float
    approach: float
    law_approach: float
    authority: int
    joint: int
    lever: float


@dataclass(frozen=True)
class Sample(ArmSample):
    """One step, for the first arm that keeps clear. Arrays (nv,) include everything that moves, left first;
    `desired` is nan if nothing is followed.
    """

    time: float
    distance: float
    activation: float
    pair: int
    law_distance: float
    second: ArmSample | None
    positions: Array
    velocities: Array
    desired: Array

    @property
    def error(self) -> float:
        """|e| of the task [m or rad]."""
        return self.squared_error**0.5


_FIRST_ROWS: Final = 256
"""Initial capacity [steps]; a full history has 8 MB."""


class History:
    """The last `capacity` steps of a run. `joints`: nv."""

    def __init__(self, capacity: int, joints: int) -> None:
        self._rows = np.full((min(capacity, _FIRST_ROWS), _HEAD + 3 * joints), np.nan)
        self._capacity, self._with_second = capacity, False
        self._middle, self._end = _HEAD + joints, _HEAD + 2 * joints
        self.count = 0
        """Recorded steps; may exceed the kept ones."""

    def begin_with(self, table: Array) -> None:
        """Replace the history by a table (rows ≤ `capacity`, columns)."""
        self.count = len(table)
        if self.count:
            self._rows, self._with_second = table.copy(), True

    def append(
        self,
        scalars: tuple[float, ...],
        positions: Array,
        velocities: Array,
        desired: Array | None = None,
        second: tuple[float, ...] | None = None,
    ) -> None:
        """Record one step.

        Args:
            scalars: `SCALARS` without those of the second arm.
            positions, velocities: q and q̇ (nv,).
            desired: q_d (nv,); None if nothing is followed.
            second: `SCALARS` of the second arm.
        """
        place = self.count % self._capacity
        if place == len(self._rows):
            more = np.full((min(place, self._capacity - place), self._rows.shape[1]), np.nan)
            self._rows = np.concatenate((self._rows, more))
        row = self._rows[place]
        middle, end = self._middle, self._end
        row[:_FIRST] = scalars
        if second is not None:
            row[_FIRST:_HEAD] = second
            self._with_second = True
        elif self._with_second:
            row[_FIRST:_HEAD] = math.nan
        row[_HEAD:middle] = positions
        row[middle:end] = velocities
        if desired is not None:
            row[end:] = desired
        self.count += 1

    def last(self) -> Sample:
        """Newest step.

        Raises:
            IndexError: nothing is recorded.
        """
        if self.count == 0:
            raise IndexError("the history is empty: no step was made yet")
        row = self._rows[(self.count - 1) % self._capacity]
        t, d, lam, e2, u, w, pair, law_d, law_w, authority, joint, lever = row[:_FIRST].tolist()
        first = e2, u, w, law_w, int(authority), int(joint), lever
        e2, u, w, law_w, authority, joint, lever = row[_FIRST:_HEAD].tolist()
        second = (
            None if math.isnan(authority) else ArmSample(e2, u, w, law_w, int(authority), int(joint), lever)
        )
        q, dq, desired = (
            row[_HEAD : self._middle].copy(),
            row[self._middle : self._end].copy(),
            row[self._end :].copy(),
        )
        return Sample(*first, t, d, lam, int(pair), law_d, second, q, dq, desired)

    def table(self, newest: int | None = None, but: int = 0) -> Array:
        """Kept rows, oldest first (rows, columns), a copy: at most `newest`, without the last `but`."""
        return self._rows[self._kept(newest, but)]

    def column(self, name: str) -> Array:
        """One of `SCALARS`, oldest first (rows,), a copy."""
        return self._rows[self._kept(None, 0), COLUMN[name]]

    def _kept(self, newest: int | None, but: int) -> NDArray[np.int64]:
        kept = min(self.count, self._capacity)
        kept = kept if newest is None else min(kept, newest)
        return np.arange(self.count - kept, self.count - but) % self._capacity

    def positions(self, table: Array) -> Array:
        """q (rows, nv)."""
        return table[:, _HEAD : self._middle]

    def velocities(self, table: Array) -> Array:
        """q̇ (rows, nv)."""
        return table[:, self._middle : self._end]

    def desired(self, table: Array) -> Array:
        """q_d (rows, nv), nan if nothing was followed."""
        return table[:, self._end :]
