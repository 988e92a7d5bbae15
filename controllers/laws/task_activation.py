"""An inequality task has priority as far as it is active."""

import math
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from controllers.activation import buffered_activation
from controllers.kinematics import Array
from controllers.laws.row_law import RetreatLaw
from controllers.laws.situation import Situation, row_damping, row_dampings

DIRECTION_WEIGHT: Final = 1.0
"""η [m²/rad²]: cost of the second task's motion against the first."""


@dataclass(frozen=True)
class TaskActivation(RetreatLaw):
    """Level by level, from ρ_0 = q̇_n and Q_0 = I: ρ_k = ρ_{k−1} + Q_{k−1} X^{#,A,I} W_k (ẋ_k − J_k ρ_{k−1}),
    with X = J_k Q_{k−1}, Q_k = Q_{k−1} (I − X^{#,A,I} X),  W_k = X X^{#,A,Q},  X^{#,A,Q} = (Xᵀ A X + η
    (I−Q)ᵀ(I−Q) + Vᵀ P V)^{−1} Xᵀ A A,  Q = Q_{k−1}.

    Simetti & Casalino, J. Intelligent & Robotic Systems 84, 2016. The activation A rises from 0 to 1 in a
    buffer before the threshold. An inactive task uses no freedom, an active one all that it needs; in between
    three regularisations make q̇ continuous. Level 1 is the distance, A = a(d), J_1 = J_d, ẋ_1 = v. Level 2
    is the hand, A = I, J_2 = J (I without a `task_jacobian`), ẋ_2 = J q̇_n. Theirs begins at ρ_0 = 0; here
    unused joints follow q̇_n.

    For one row, J_d^{#,a,I} = a J_d^# and W_1 = a, so that J_d ρ_1 = a² v − (1 − a²) u, and Q_1 = I − a J_d^#
    J_d is the paper's N', eq. (13). While a < 1, the hand uses the share 1 − a of J_d to undo its own error:
    J_d q̇ is between −u and a² (v + u) − u, which is reached where the hand does not feel the row. At a = 1
    it is v. If the hand needs J_d itself, η makes it yield gradually as a → 1.

    P is the damping of `row_damping`, for the row and the singular values of the hand's level.

    Attributes:
        critical_distance: d_m [m], where a = 1.
        influence_distance: d_0 [m], where a = 0.
    """

    wants_task: ClassVar[bool] = True

    critical_distance: float
    influence_distance: float
    nominal_velocity: float

    def row_activation(self, distance: float) -> float:
        return buffered_activation(distance, self.critical_distance, self.influence_distance)

    def activation(self, distance: float) -> float:
        """a², the share of v in level 1."""
        return self.row_activation(distance) ** 2

    def __call__(self, situation: Situation) -> Array:
        nominal, row, J = situation.nominal, situation.row, situation.task_jacobian
        a, square = self.row_activation(situation.distance), float(row.dot(row))
        if a == 0.0 or square == 0.0:
            return nominal
        if J is None:
            # Of J = I only the direction of the row is disturbed.
            J = row[None, :] / math.sqrt(square)
        inverse = row / (square + row_damping(square))
        change = inverse * self.correction(situation.distance, situation.pull, situation.approach)
        X = J - np.outer(J.dot(inverse), a * row)
        # (I − Q_1)ᵀ(I − Q_1) of Q_1 = I − a J_d^# J_d is wᵀ w with this row w.
        w = inverse * (a * math.sqrt(square))
        smoothed = X.dot(
            _damped(np.vstack([X, math.sqrt(DIRECTION_WEIGHT) * w]), np.append(J.dot(change), 0.0))
        )
        second = _damped(X, smoothed)
        return nominal + change - second + inverse * (a * float(row.dot(second)))


def _damped(X: Array, velocity: Array) -> Array:
    """(Xᵀ X + Vᵀ P V)^{−1} Xᵀ ẋ (n,) for X (m, n) and ẋ (m,)."""
    squares, directions = np.linalg.eigh(X.dot(X.T))
    return directions.dot(directions.T.dot(velocity) / (squares + row_dampings(squares))).dot(X)
