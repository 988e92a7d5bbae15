"""Strict task priority: the order of the tasks is fixed, or thrown over at one distance; eq. (11)."""

import math
from dataclasses import dataclass

from controllers.laws.row_law import RowLaw


@dataclass(frozen=True)
class StrictPriority(RowLaw):
    """q̇ = J_a^# ẋ_a + N_a J_b^# ẋ_b, eq. (11) of Petrič & Žlajpah 2011, with J_a = J_d and ẋ_a = v: J_d q̇ = v exactly.

    It comes in two kinds.

    Always on, avoidance comes first at every distance. The distance then grows at v for ever, however far the obstacle is and
    whatever the task wants along the line of contact: the arm leaves its place, and nothing but its reach or its joint limits ends
    the retreat. That is what a fixed order of the two tasks means, and why the paper lets the order change.

    Switched, avoidance comes first below d_m and does not exist above. J_d q̇ jumps from −u to v at d_m; an arm whose task pulls it
    there switches at every tick, and its accelerations grow as 1 / dt.

    Attributes:
        nominal_velocity: v [m/s].
        critical_distance: d_m [m], at which it is switched; ∞ for always on.
    """

    nominal_velocity: float
    critical_distance: float = math.inf

    def activation(self, distance: float) -> float:
        """Return 1 where avoidance comes first, else 0; 0 if there is no obstacle, d = ∞."""
        return 1.0 if distance <= self.critical_distance and distance < math.inf else 0.0

    def correction(self, distance: float, pull: float, approach: float) -> float:
        """Return c = v + u [m/s] where avoidance comes first, else 0."""
        del approach
        return self.nominal_velocity + pull if self.activation(distance) > 0.0 else 0.0
