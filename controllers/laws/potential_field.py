"""Artificial potential field: the obstacle pushes, independent of the task."""

from dataclasses import dataclass

from controllers.kinematics import Array
from controllers.laws.situation import Law, Situation


@dataclass(frozen=True)
class PotentialField(Law):
    """q̇ = q̇_n + J_dᵀ f(d), f = η (1/d − 1/d₀) / d² below d₀ and 0 above: minus the gradient of ½ η (1/d −
    1/d₀)².

    Khatib, Int. J. Robotics Research 5(1), 1986; there f is a force, here a velocity. It ignores the task's
    speed u, so neither the resting distance nor the least distance can be chosen.

    Attributes:
        influence_distance: d₀ [m], where the push begins.
        field_strength: η [m²·rad²/s].
        least_distance: the push is constant below this distance [m], also in overlap, where 1/d changes sign.
    """

    influence_distance: float
    field_strength: float
    least_distance: float = 0.05

    def push(self, distance: float) -> float:
        """f(d) [rad²/(m·s)], never negative."""
        d0 = self.influence_distance
        if distance >= d0 or self.least_distance >= d0:
            return 0.0
        d = max(distance, self.least_distance)
        return self.field_strength * (1.0 / d - 1.0 / d0) / (d * d)

    def activation(self, distance: float) -> float:
        """f(d) as a share of the largest push; the task is never reduced."""
        largest = self.push(self.least_distance)
        return self.push(distance) / largest if largest > 0.0 else 0.0

    def line_rate(self, distance: float, pull: float, approach: float, square: float) -> float:
        """J_d q̇ = |J_d|² f(d) − u [m/s]."""
        del approach
        return square * self.push(distance) - pull

    def __call__(self, situation: Situation) -> Array:
        return situation.nominal + situation.row * self.push(situation.distance)
