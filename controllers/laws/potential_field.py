"""Artificial potential field: the obstacle pushes, independent of the task; Khatib 1986."""

from dataclasses import dataclass

from controllers.kinematics import Array
from controllers.laws.situation import Law, Situation


@dataclass(frozen=True)
class PotentialField(Law):
    """q̇ = q̇_n + J_dᵀ f(d), f = η (1/d − 1/d₀) / d² below d₀ and 0 above: minus the gradient of ½ η (1/d −
    1/d₀)².

    O. Khatib, Real-time obstacle avoidance for manipulators and mobile robots, Int. J. Robotics Research
    5(1), 1986. There f is a force; here, on the kinematic level, a velocity. It ignores the task's speed u,
    so neither the resting distance nor the least distance can be chosen: J_d q̇ = |J_d|² f(d) − u, and a
    stronger pull comes closer. The transpose needs no inverse and no damping.

    Attributes:
        influence_distance: d₀ [m], where the push begins.
        field_strength: η [m²·rad²/s].
        least_distance: the push is constant below this distance [m], overlap included, where 1/d would change
            its sign.
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
        """f(d) as a share of the largest push: a measure of the field, since the task is never reduced."""
        largest = self.push(self.least_distance)
        return self.push(distance) / largest if largest > 0.0 else 0.0

    def line_rate(self, distance: float, pull: float, approach: float, square: float) -> float:
        """J_d q̇ = |J_d|² f(d) − u [m/s]; `square` is |J_d|² [m²/rad²]."""
        del approach
        return square * self.push(distance) - pull

    def __call__(self, situation: Situation) -> Array:
        return situation.nominal + situation.row * self.push(situation.distance)
