"""What a law sees of the world in one tick, and what a law is.

The process of a student's law imports this file, so that it needs only NumPy when it runs.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar, Final, NamedTuple, Protocol

import numpy as np

if TYPE_CHECKING:
    from controllers.kinematics import Array

AUTHORITY: Final = 0.12
"""|J_d| [m/rad] below which the pseudo-inverse of J_d is damped: one rad/s of every joint together moves the arm too little."""

FIRM_LEVER: Final = 0.95
"""s below which an arm counts as without a lever, see `lever`."""

ROW_DAMPING: Final = 0.06
"""Damping at J_d = 0 [m/rad]: |J_d^#| stays below 11 rad/m, its largest value being near |J_d| = 0.07 m/rad."""


class Situation(NamedTuple):
    """One arm, one tick; or both arms with their joints one after the other, if one row is shared by both (n = 14).

    Attributes:
        positions: q (n,) [rad].
        nominal: q̇_n (n,), what the task asks for, already inside the arm's velocity bounds [rad/s].
        row: J_d (n,), gradient of the distance with respect to this arm's joints, positive away from the obstacle [m/rad].
        distance: d that the law acts on [m], signed.
        approach: w, speed of the obstacle's closest point towards the arm [m/s].
        task_jacobian: J (m, n) of the task that `nominal` comes from [m/rad, rad/rad]; None if the task uses every joint, J = I.
        lower, upper: bounds of q̇ (n,) [rad/s]; None if there are none.
        rows: J_d (pairs, n) of every pair, for laws that look at more than one [m/rad]; None if only `row` is known.
        distances: d (pairs,) of every pair, signed [m]; given with `rows`.
        approaches: w (pairs,) of every pair [m/s]; None if the obstacles stand still.
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


class Unanswered(Exception):
    """A law that is computed in another process has not answered yet: the same is to be asked again."""


class Law(Protocol):
    """Anything that turns a situation into joint velocities (n,) [rad/s].

    Attributes:
        wants_all_pairs: whether it reads `rows`, `distances` and `approaches`; they need not be computed for a law that does not.
        wants_task: whether it reads `task_jacobian`.
    """

    wants_all_pairs: ClassVar[bool] = False
    wants_task: ClassVar[bool] = False

    @abstractmethod
    def __call__(self, situation: Situation) -> Array:
        """Return q̇ (n,) [rad/s]; where nothing has to be changed it may be the very array `situation.nominal`.

        Raises:
            Unanswered: see there; only a law that is computed elsewhere.
        """
        ...

    @abstractmethod
    def activation(self, distance: float) -> float:
        """Activation λ of the avoidance at a distance [m], in [0, 1], as shown on the page.

        0 at d = ∞, which is the distance in a room without obstacles.

        Raises:
            Unanswered: as a call.
        """
        ...

    @abstractmethod
    def line_rate(self, distance: float, pull: float, approach: float, square: float) -> float:
        """Return J_d q̇ [m/s] that the law makes of one pair, on its own, without bounds and with a regular J_d.

        Args:
            distance: d [m], signed.
            pull: u [m/s].
            approach: w [m/s].
            square: |J_d|² [m²/rad²]; only a law that pushes instead of prescribing a speed depends on it.
        """
        ...


def along_row(nominal: Array, row: Array, correction: float) -> Array:
    """Return q̇_n + J_d^# c (n,) [rad/s], where c [m/s] is the change wanted of the distance rate J_d q̇, J_d a row (n,) [m/rad].

    J_d^# = J_dᵀ / (J_d J_dᵀ + μ²) with μ = 0 while |J_d| ≥ 0.12 m/rad, growing smoothly to 0.06 m/rad at J_d = 0: the exact
    pseudo-inverse, eq. (5), wherever the arm can do something, and bounded speeds where it cannot.
    """
    square = float(row.dot(row))
    return nominal + row * (correction / (square + row_damping(square)))


def lever(square: float) -> float:
    """Return s = |J_d|² / (|J_d|² + μ²) for |J_d|² = `square`: the share of a change of the distance rate that J_d^# achieves.

    1 while J_d is regular, towards 0 where no joint moves the closest point along the line of contact.
    """
    return square / (square + row_damping(square))


def row_damping(square: float) -> float:
    """Return μ² [m²/rad²] for |J_d|² = `square`; 0 from 0.12 m/rad upwards, continuously differentiable."""
    ratio = square / (AUTHORITY * AUTHORITY)
    if ratio >= 1.0:
        return 0.0
    return (ROW_DAMPING * (1.0 - ratio)) ** 2


def row_dampings(squares: Array) -> Array:
    """Return `row_damping` of many rows at once: |J_d|² (pairs,) → (pairs,) [m²/rad²]."""
    dampings = squares * (-ROW_DAMPING / (AUTHORITY * AUTHORITY))
    dampings += ROW_DAMPING
    np.maximum(dampings, 0.0, out=dampings)
    dampings *= dampings
    return dampings
