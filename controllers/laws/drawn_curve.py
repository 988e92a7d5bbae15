"""The paper's blend of retreat and pull with a drawn λ(d)."""

import math
from dataclasses import dataclass

from controllers.curve import curve_through
from controllers.laws.row_law import RetreatLaw


@dataclass(frozen=True)
class DrawnCurve(RetreatLaw):
    """J_d q̇ = λ(d) v − (1 − λ(d)) u with λ(d) through given points.

    Attributes:
        curve: the points, see `controllers.curve`; constant beyond both ends.
    """

    curve: str
    nominal_velocity: float

    def activation(self, distance: float) -> float:
        return 0.0 if distance == math.inf else curve_through(self.curve).height(distance)
