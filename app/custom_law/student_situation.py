"""The situation for a student's law: `controllers.laws.situation.Situation` without its libraries.

The law's process imports only NumPy and msgspec, so that it starts in a tenth of a second and takes little memory. A test compares
the two.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Situation(NamedTuple):
    """One arm, one tick; fields and units as in `controllers.laws.situation.Situation`.

    Every array belongs to the law: it may keep or change them.
    """

    positions: Array
    nominal: Array
    row: Array
    distance: float
    approach: float
    task_jacobian: Array | None = None
    lower: Array | None = None
    upper: Array | None = None
    rows: Array | None = None
    distances: Array | None = None
    approaches: Array | None = None

    @property
    def pull(self) -> float:
        """u = −J_d q̇_n [m/s]: how fast the task pulls the arm towards the obstacle."""
        return -float(self.row.dot(self.nominal))


JOINTS = 7
"""Of the arm in `one_joint`: laws like to build 7 × 7 matrices."""

LOOSE = 100.0
"""Bounds in `one_joint` [rad/s]: none that anything would meet."""


def one_joint(distance: float, pull: float, approach: float, square: float) -> Situation:
    """Return a situation in which only the first joint moves the distance, with |J_d|² = `square`, 1 if that is 0; see `Law.line_rate`."""
    length = square**0.5 if square > 0.0 else 1.0
    nominal, row = np.zeros(JOINTS), np.zeros(JOINTS)
    nominal[0], row[0] = -pull / length, length
    bound = np.full(JOINTS, LOOSE)
    near = np.array([distance]), np.array([approach])
    return Situation(np.zeros(JOINTS), nominal, row, distance, approach, None, -bound, bound, row[None, :].copy(), *near)
