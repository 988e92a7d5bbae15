"""The hand first: avoidance gets only the freedom that the hand leaves."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from controllers.activation import buffered_activation
from controllers.kinematics import Array
from controllers.laws.row_law import RetreatLaw
from controllers.laws.situation import Situation, row_damping
from controllers.laws.task_space import free_part


@dataclass(frozen=True)
class NullSpaceAvoidance(RetreatLaw):
    """q̇ = q̇_n + N (J_d N)^# α(d) (v + u), with N = I − J^# J of the hand's task and u = −J_d q̇_n.

    After Žlajpah & Nemec, IROS 2002, with the reverse order of the paper's tasks: J q̇ = J q̇_n always. The
    retreat at α = 1 is v. c = α (v + u) is reached if the hand leaves enough freedom, and damped where J_d N
    vanishes. A task that uses every joint (no `task_jacobian`) leaves q̇ = q̇_n.

    Bounds shorten the evasive motion to q̇_n + s Δ with the largest s ≤ 1; clipping joint by joint would move
    the hand.

    Attributes:
        critical_distance: d_m [m].
        influence_distance: d_i [m], where avoidance begins; d_i ≤ d_m makes a hard switch at d_m.
    """

    wants_task: ClassVar[bool] = True

    critical_distance: float
    influence_distance: float
    nominal_velocity: float

    def activation(self, distance: float) -> float:
        return buffered_activation(distance, self.critical_distance, self.influence_distance)

    def __call__(self, situation: Situation) -> Array:
        nominal, J = situation.nominal, situation.task_jacobian
        c = self.correction(situation.distance, situation.pull, situation.approach)
        if J is None or c == 0.0:
            return nominal
        free = free_part(situation.row, J)
        # N is symmetric and N² = N, so that N (J_d N)^# is the transpose of J_d N over its square, as for a row of its own.
        square = float(free.dot(free))
        change = free * (c / (square + row_damping(square)))
        if situation.lower is not None and situation.upper is not None:
            change *= _largest_share(nominal, change, situation.lower, situation.upper)
        return nominal + change


def _largest_share(nominal: Array, change: Array, lower: Array, upper: Array) -> float:
    velocities = nominal + change
    if not (np.count_nonzero(velocities < lower) or np.count_nonzero(velocities > upper)):
        return 1.0
    share = 1.0
    for q, dq, low, high in zip(
        nominal.tolist(), change.tolist(), lower.tolist(), upper.tolist(), strict=True
    ):
        if dq > 0.0:
            share = min(share, (high - q) / dq)
        elif dq < 0.0:
            share = min(share, (low - q) / dq)
    return max(share, 0.0)
