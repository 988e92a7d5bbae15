"""What a law sees of the world in one tick, and what a law is."""

from typing import Final, NamedTuple, Protocol

import numpy as np

from controllers.kinematics import Array

AUTHORITY: Final = 0.12
"""|J_d| [m/rad] below which the pseudo-inverse of J_d is damped: one rad/s of every joint together moves the arm too little."""

ROW_DAMPING: Final = 0.06
"""Damping at J_d = 0 [m/rad]: |J_d^#| stays below 11 rad/m, its largest value being near |J_d| = 0.07 m/rad."""


class Situation(NamedTuple):
    """One arm, one tick.

    Attributes:
        positions: q (n,) [rad].
        nominal: q̇_n (n,), what the task asks for, already inside the arm's velocity bounds [rad/s].
        row: J_d (n,), gradient of the distance with respect to this arm's joints, positive away from the obstacle [m/rad].
        distance: d that the law acts on [m], signed.
        approach: w, speed of the obstacle's closest point towards the arm [m/s].
    """

    positions: Array
    nominal: Array
    row: Array
    distance: float
    approach: float

    @property
    def pull(self) -> float:
        """u = −J_d q̇_n [m/s]: how fast the task pulls the arm towards the obstacle."""
        return -float(self.row.dot(self.nominal))


class Law(Protocol):
    """Anything that turns a situation into joint velocities (n,) [rad/s]."""

    def __call__(self, situation: Situation) -> Array:
        """Return q̇ (n,) [rad/s]."""
        ...

    def activation(self, distance: float) -> float:
        """Return how far avoidance has taken over at a distance [m], in [0, 1]; what the page shows as λ."""
        ...


def along_row(nominal: Array, row: Array, correction: float) -> Array:
    """Return q̇_n + J_d^# c, where c [m/s] is the change wanted of the distance rate J_d q̇.

    J_d^# = J_dᵀ / (J_d J_dᵀ + μ²) with μ = 0 while |J_d| ≥ 0.12 m/rad, growing smoothly to 0.06 m/rad at J_d = 0: the exact
    pseudo-inverse, eq. (5), wherever the arm can do something, and bounded speeds where it cannot.
    """
    square = float(row.dot(row))
    return nominal + row * (correction / (square + row_damping(square)))


def row_damping(square: float) -> float:
    """Return μ² [m²/rad²] for |J_d|² = `square`; 0 from 0.12 m/rad upwards, continuously differentiable."""
    ratio = square / (AUTHORITY * AUTHORITY)
    if ratio >= 1.0:
        return 0.0
    return (ROW_DAMPING * (1.0 - ratio)) ** 2


def textbook_projector(row: Array, lam: float) -> Array:
    """Return N' = I − λ J_d^# J_d (n, n), eqs (13), (33), with the undamped pseudo-inverse; for analysis and tests."""
    return np.eye(len(row)) - lam * np.outer(row, row) / row.dot(row)
