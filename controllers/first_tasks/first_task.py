"""What a law can act on: any quantity of an arm with one row, eqs (9)–(13), Petrič & Žlajpah 2011.

Let h(q) be a quantity that must not fall below h_m, such as the distance of two arms, J_a = ∂h/∂q its row,
and w the speed at which h falls while the joints are at rest: ḣ = J_a q̇ − w. With λ = (h_m/h)ⁿ, eq. (31),
and u = −J_a q̇_n, eq. (32) is

    q̇ = q̇_n + J_a^# λ (v + u),      ḣ = λ v − (1 − λ) u − w,

while J_a is not singular and no joint bound acts. So `controllers.budget` holds in the unit of h: it rests at
h* = h_m ((u + v)/(u + w))^(1/n), and a step must be shorter than 2 h_m/[n (v + u)].
"""

from abc import ABC, abstractmethod
from typing import NamedTuple

from controllers.kinematics import Array
from controllers.laws.situation import AUTHORITY


class Margin(NamedTuple):
    """A first task at the present posture, in its unit.

    Attributes:
        value: h; negative beyond the limit.
        row: J_a = ∂h/∂q (n,) [unit/rad].
        approach: w [unit/s].
    """

    value: float
    row: Array
    approach: float = 0.0


class FirstTask(ABC):
    """A quantity of one arm that is kept at or above a threshold.

    Args:
        critical_value: h_m > 0 [unit], below which it has full priority.
        nominal_rate: v ≥ 0 [unit/s], its rate at full priority.

    Attributes:
        unit: of h; "" for a ratio.
        authority: |J_a| [unit/rad] below which its pseudo-inverse is damped.
    """

    name: str
    unit: str
    authority: float = AUTHORITY

    def __init__(self, critical_value: float, nominal_rate: float) -> None:
        self.critical_value, self.nominal_rate = critical_value, nominal_rate

    @abstractmethod
    def margin(self) -> Margin:
        """h, J_a and w at the last `Kinematics.update`; J_a is a new array."""
