"""Strict task priority, fixed or switched at a distance."""

import math
from dataclasses import dataclass

from controllers.laws.row_law import RowLaw


@dataclass(frozen=True)
class StrictPriority(RowLaw):
    """q̇ = J_a^# ẋ_a + N_a J_b^# ẋ_b, eq. (11) of Petrič & Žlajpah 2011, with J_a = J_d and ẋ_a = v: J_d q̇ =
    v exactly.

    Always on, the distance grows at v until reach or joint limits end the retreat, whatever the task wants.

    Switched, avoidance has priority up to d_m and does nothing above. J_d q̇ jumps from −u to v at d_m; an
    arm pulled there switches at every tick, with accelerations of order 1 / dt.

    Attributes:
        nominal_velocity: v [m/s].
        critical_distance: d_m [m] of the switch; ∞ for always on.
    """

    nominal_velocity: float
    critical_distance: float = math.inf

    def activation(self, distance: float) -> float:
        return 1.0 if distance <= self.critical_distance and distance < math.inf else 0.0

    def correction(self, distance: float, pull: float, approach: float) -> float:
        del approach
        return self.nominal_velocity + pull if self.activation(distance) > 0.0 else 0.0
