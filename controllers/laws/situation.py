"""What a law knows in one tick, and the interface of a law.

The process of a custom law imports this file: it must need only NumPy.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar, Final, NamedTuple, Protocol

import numpy as np

if TYPE_CHECKING:
    from controllers.kinematics import Array

AUTHORITY: Final = 0.12
"""|J_d| [m/rad] below which the pseudo-inverse of J_d is damped."""

FIRM_LEVER: Final = 0.95
"""s below which the lever is weak, see `lever`."""

ROW_DAMPING: Final = 0.06
"""Damping at J_d = 0 [m/rad]: |J_d^#| stays below 11 rad/m, largest near 0.07 m/rad."""


class Situation(NamedTuple):
    """One arm, one tick; or both arms with concatenated joints (n = 14), if they share one row.

    Attributes:
        positions: q (n,) [rad].
        nominal: q̇_n (n,) of the task, within the arm's velocity bounds [rad/s].
        row: J_d (n,), gradient of the distance by this arm's joints, positive away from the obstacle [m/rad].
        distance: d that the law acts on [m], signed.
        approach: w, speed of the obstacle's closest point towards the arm [m/s].
        task_jacobian: J (m, n) of the task of `nominal` [m/rad, rad/rad]; None if the task uses every joint,
            J = I.
        lower, upper: bounds of q̇ (n,) [rad/s]; None if unbounded.
        rows: J_d (pairs, n) of every pair [m/rad]; None if only `row` is known.
        distances: d (pairs,) of every pair, signed [m]; given with `rows`.
        approaches: w (pairs,) of every pair [m/s]; None if the obstacles are at rest.
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
        """u = −J_d q̇_n [m/s]: the task's speed towards the obstacle."""
        return -float(self.row.dot(self.nominal))


class Unanswered(Exception):
    """A law computed in another process has not answered yet; repeat the call later."""


class Law(Protocol):
    """A map from a situation to joint velocities (n,) [rad/s].

    Attributes:
        wants_all_pairs: it reads `rows`, `distances` and `approaches`.
        wants_task: it reads `task_jacobian`.
    """

    wants_all_pairs: ClassVar[bool] = False
    wants_task: ClassVar[bool] = False

    @abstractmethod
    def __call__(self, situation: Situation) -> Array:
        """q̇ (n,) [rad/s]; may be the array `situation.nominal` itself.

        Raises:
            Unanswered: only a law that is computed elsewhere.
        """
        ...

    @abstractmethod
    def activation(self, distance: float) -> float:
        """Activation λ of the avoidance at a distance [m], in [0, 1]; 0 at d = ∞.

        Raises:
            Unanswered: as a call.
        """
        ...

    @abstractmethod
    def line_rate(self, distance: float, pull: float, approach: float, square: float) -> float:
        """J_d q̇ [m/s] of the law for one pair, without bounds and with a regular J_d.

        Args:
            distance, pull, approach: d, u, w, see `Situation`.
            square: |J_d|² [m²/rad²]; only for a law that pushes instead of prescribing a speed.
        """
        ...


def along_row(nominal: Array, row: Array, correction: float) -> Array:
    """q̇_n + J_d^# c (n,) [rad/s], for a row J_d (n,) [m/rad] and a change c of the distance rate [m/s].

    J_d^# = J_dᵀ / (J_d J_dᵀ + μ²), eq. (5), with μ = 0 for |J_d| ≥ 0.12 m/rad, smoothly to 0.06 m/rad
    at J_d = 0, so that speeds stay bounded.
    """
    square = float(row.dot(row))
    return nominal + row * (correction / (square + row_damping(square)))


def lever(square: float) -> float:
    """s = |J_d|² / (|J_d|² + μ²) for |J_d|² = `square`: the share of a rate change that J_d^# achieves."""
    return square / (square + row_damping(square))


def row_damping(square: float) -> float:
    """μ² [m²/rad²] for |J_d|² = `square`; 0 from 0.12 m/rad upwards, continuously differentiable."""
    ratio = square / (AUTHORITY * AUTHORITY)
    if ratio >= 1.0:
        return 0.0
    return (ROW_DAMPING * (1.0 - ratio)) ** 2


def row_dampings(squares: Array) -> Array:
    """`row_damping` of many rows (pairs,) [m²/rad²]."""
    dampings = squares * (-ROW_DAMPING / (AUTHORITY * AUTHORITY))
    dampings += ROW_DAMPING
    np.maximum(dampings, 0.0, out=dampings)
    dampings *= dampings
    return dampings
