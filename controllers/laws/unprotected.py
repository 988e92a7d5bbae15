"""No avoidance at all: the task alone. It is there so that the difference can be felt."""

from dataclasses import dataclass

from controllers.kinematics import Array
from controllers.laws.row_law import RowLaw
from controllers.laws.situation import Situation


@dataclass(frozen=True)
class Unprotected(RowLaw):
    """q̇ = q̇_n: eq. (12) with λ ≡ 0."""

    def activation(self, distance: float) -> float:
        """Return 0: avoidance never takes over."""
        del distance
        return 0.0

    def correction(self, distance: float, pull: float, approach: float) -> float:
        """Return 0: nothing is ever added."""
        del distance, pull, approach
        return 0.0

    def __call__(self, situation: Situation) -> Array:
        """Return q̇_n (n,) [rad/s]."""
        return situation.nominal
