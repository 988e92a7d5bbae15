"""What the laws have in common that change nothing but the speed along the line of contact."""

from abc import abstractmethod
from dataclasses import dataclass

from controllers.activation import activation
from controllers.kinematics import Array
from controllers.laws.situation import Law, Situation, along_row


class RowLaw(Law):
    """q̇ = q̇_n + J_d^# c: one row, one number c, everything orthogonal to J_d untouched.

    A law of this kind is defined by c(d, u, w) alone. Where it takes another way through the joints to the same distance rate, it
    replaces `__call__` and keeps the rest.
    """

    @abstractmethod
    def correction(self, distance: float, pull: float, approach: float) -> float:
        """Return c [m/s], what the law adds to the distance rate J_d q̇_n = −u, at d [m], u [m/s] and w [m/s]."""

    def line_rate(self, distance: float, pull: float, approach: float, square: float) -> float:
        """Return J_d q̇ = c − u [m/s]."""
        del square
        return self.correction(distance, pull, approach) - pull

    def __call__(self, situation: Situation) -> Array:
        """Return q̇ (n,) [rad/s]."""
        c = self.correction(situation.distance, situation.pull, situation.approach)
        return along_row(situation.nominal, situation.row, c)


class RetreatLaw(RowLaw):
    """J_d q̇ = λ(d) v − (1 − λ(d)) u: as far as avoidance has taken over, retreat at v takes the place of the pull.

    Attributes:
        nominal_velocity: v [m/s].
    """

    nominal_velocity: float

    def correction(self, distance: float, pull: float, approach: float) -> float:
        """Return c = λ (v + u) [m/s]."""
        del approach
        return self.activation(distance) * (self.nominal_velocity + pull)


@dataclass(frozen=True)
class BlendLaw(RetreatLaw):
    """J_d q̇ = λ(d) v − (1 − λ(d)) u: a law with the activation of the paper, eq. (31), that blends retreat and pull.

    Attributes:
        critical_distance: d_m [m].
        order: n.
        nominal_velocity: v [m/s].
    """

    critical_distance: float
    order: float
    nominal_velocity: float

    def activation(self, distance: float) -> float:
        """Return λ(d), eq. (31)."""
        return activation(distance, self.critical_distance, self.order)
