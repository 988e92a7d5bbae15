"""Strict task priority: a fixed order of the tasks, or one that switches at a distance; eq. (11)."""

import math
from dataclasses import dataclass

from controllers.laws.row_law import RowLaw


@dataclass(frozen=True)
class StrictPriority(RowLaw):
    """q̇ = J_a^# ẋ_a + N_a J_b^# ẋ_b, eq. (11) of Petrič & Žlajpah 2011, with J_a = J_d and ẋ_a = v: J_d q̇ =
    v exactly.

    Always on, avoidance has priority at every distance: the distance grows at v until the arm's reach or
    joint limits end the retreat, whatever the task wants along the line of contact. The paper lets the order
    change to avoid this.

    Switched, avoidance has priority below d_m and does nothing above. J_d q̇ jumps from −u to v at d_m; an
    arm pulled there switches at every tick, and its accelerations grow as 1 / dt.

    Attributes:
        nominal_velocity: v [m/s].
        critical_distance: d_m [m] of the switch; ∞ for always on.
    """

    nominal_velocity: float
    critical_distance: float = math.inf

    def activation(self, distance: float) -> float:
        """1 where avoidance has priority, else 0; 0 without an obstacle, d = ∞."""
        return 1.0 if distance <= self.critical_distance and distance < math.inf else 0.0

    def correction(self, distance: float, pull: float, approach: float) -> float:
        """c = v + u [m/s] where avoidance has priority, else 0."""
        del approach
        return self.nominal_velocity + pull if self.activation(distance) > 0.0 else 0.0
