"""Situations for the charts of a student's law."""

import numpy as np
from numpy.typing import NDArray

from controllers.laws.situation import Situation

Array = NDArray[np.float64]
"""As in `controllers.kinematics`, whose libraries the law's process does without."""

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
