"""What happened: one row a step in a ring of fixed size."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from controllers.kinematics import Array

SCALARS: Final = ("t", "d", "lambda", "e2", "u", "w", "pair", "law_d", "w_law", "authority", "joint")
"""Columns before the joints: time [s], true distance [m], λ, squared position error [m²], pull and approach [m/s], closest pair,
distance the law acts on [m], approach along the law's row [m/s], `Authority`, its joint."""

COLUMN: Final = {name: i for i, name in enumerate(SCALARS)}
_HEAD: Final = len(SCALARS)


@dataclass(frozen=True)
class Sample:
    """One step. Names and units as in `SCALARS`; positions and velocities (nv,) are those of all arms, left first."""

    time: float
    distance: float
    activation: float
    squared_error: float
    pull: float
    approach: float
    pair: int
    law_distance: float
    law_approach: float
    authority: int
    joint: int
    positions: Array
    velocities: Array

    @property
    def error(self) -> float:
        """|e| of the hand's position [m]."""
        return self.squared_error**0.5


class History:
    """The last `capacity` steps.

    Args:
        capacity: rows kept.
        joints: nv, joints of all arms.
    """

    def __init__(self, capacity: int, joints: int) -> None:
        self._rows = np.full((capacity, _HEAD + 2 * joints), np.nan)
        self._capacity, self._joints = capacity, joints
        self.count = 0
        """Steps recorded since the last `clear`; may exceed what is kept."""

    def clear(self) -> None:
        """Forget everything."""
        self.count = 0

    def append(self, scalars: tuple[float, ...], positions: Array, velocities: Array) -> None:
        """Record one step: scalars in the order of `SCALARS`, q and q̇ (nv,)."""
        row = self._rows[self.count % self._capacity]
        middle = _HEAD + self._joints
        row[:_HEAD] = scalars
        row[_HEAD:middle] = positions
        row[middle:] = velocities
        self.count += 1

    def last(self) -> Sample:
        """Return the newest step.

        Raises:
            IndexError: nothing is recorded yet.
        """
        if self.count == 0:
            raise IndexError("the history is empty: no step was made yet")
        row = self._rows[(self.count - 1) % self._capacity]
        t, d, lam, e2, u, w, pair, law_d, law_w, authority, joint = row[:_HEAD].tolist()
        q, dq = row[_HEAD : _HEAD + self._joints].copy(), row[_HEAD + self._joints :].copy()
        return Sample(t, d, lam, e2, u, w, int(pair), law_d, law_w, int(authority), int(joint), q, dq)

    def table(self, newest: int | None = None) -> Array:
        """Return the rows kept, oldest first (rows, columns), a copy; at most the `newest` ones."""
        kept = min(self.count, self._capacity)
        kept = kept if newest is None else min(kept, newest)
        return self._rows[np.arange(self.count - kept, self.count) % self._capacity]

    def positions(self, table: Array) -> Array:
        """Return q (rows, nv) of a table."""
        return table[:, _HEAD : _HEAD + self._joints]

    def velocities(self, table: Array) -> Array:
        """Return q̇ (rows, nv) of a table."""
        return table[:, _HEAD + self._joints :]
