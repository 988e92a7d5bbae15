"""The paper's blend of retreat and pull with λ from a lever."""

import math
from dataclasses import dataclass

from controllers.laws.row_law import RetreatLaw


@dataclass(frozen=True)
class HandLever(RetreatLaw):
    """J_d q̇ = λ v − (1 − λ) u, with λ independent of the distance.

    Attributes:
        hand_lever: λ, in [0, 1].
    """

    hand_lever: float
    nominal_velocity: float

    def activation(self, distance: float) -> float:
        return 0.0 if distance == math.inf else self.hand_lever
