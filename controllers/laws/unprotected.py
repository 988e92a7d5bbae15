"""No avoidance: the task alone, for comparison."""

from dataclasses import dataclass

from controllers.kinematics import Array
from controllers.laws.row_law import RowLaw
from controllers.laws.situation import Situation


@dataclass(frozen=True)
class Unprotected(RowLaw):
    """q̇ = q̇_n: eq. (12) with λ ≡ 0."""

    def activation(self, distance: float) -> float:
        del distance
        return 0.0

    def correction(self, distance: float, pull: float, approach: float) -> float:
        del distance, pull, approach
        return 0.0

    def __call__(self, situation: Situation) -> Array:
        return situation.nominal
