"""A law in which a lever gives λ: the paper's blend of retreat and pull without eq. (31)."""

import math
from dataclasses import dataclass

from controllers.laws.row_law import RetreatLaw


@dataclass(frozen=True)
class HandLever(RetreatLaw):
    """J_d q̇ = λ v − (1 − λ) u with λ from a lever, independent of the distance.

    Attributes:
        hand_lever: λ, in [0, 1].
        nominal_velocity: v [m/s].
    """

    hand_lever: float
    nominal_velocity: float

    def activation(self, distance: float) -> float:
        return 0.0 if distance == math.inf else self.hand_lever
