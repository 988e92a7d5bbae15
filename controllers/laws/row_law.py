"""Laws that change only the speed along the line of contact."""

from abc import abstractmethod
from dataclasses import dataclass

from controllers.activation import activation
from controllers.kinematics import Array
from controllers.laws.situation import Law, Situation, along_row


class RowLaw(Law):
    """q̇ = q̇_n + J_d^# c, with everything orthogonal to J_d unchanged.

    A law that reaches the same distance rate by other joints overrides only `__call__`.
    """

    @abstractmethod
    def correction(self, distance: float, pull: float, approach: float) -> float:
        """c [m/s], added to the distance rate J_d q̇_n = −u, at d [m], u [m/s] and w [m/s]."""

    def line_rate(self, distance: float, pull: float, approach: float, square: float) -> float:
        del square
        return self.correction(distance, pull, approach) - pull

    def __call__(self, situation: Situation) -> Array:
        c = self.correction(situation.distance, situation.pull, situation.approach)
        return along_row(situation.nominal, situation.row, c)


class RetreatLaw(RowLaw):
    """J_d q̇ = λ(d) v − (1 − λ(d)) u: c = λ (v + u).

    Attributes:
        nominal_velocity: v [m/s].
    """

    nominal_velocity: float

    def correction(self, distance: float, pull: float, approach: float) -> float:
        del approach
        return self.activation(distance) * (self.nominal_velocity + pull)


@dataclass(frozen=True)
class BlendLaw(RetreatLaw):
    """A `RetreatLaw` with the paper's activation, eq. (31).

    Attributes:
        critical_distance: d_m [m].
    """

    critical_distance: float
    order: float
    nominal_velocity: float

    def activation(self, distance: float) -> float:
        return activation(distance, self.critical_distance, self.order)
