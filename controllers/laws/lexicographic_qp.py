"""One inequality per pair first, the hand second, the posture last."""

from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from controllers.kinematics import Array
from controllers.laws.barrier_qp import BarrierQP, nearest, pair_rates
from controllers.laws.situation import Situation

POSTURE_WEIGHT: Final = 0.02
"""ε [m/rad]: a joint counts as a hand motion of 20 mm per radian."""


@dataclass(frozen=True)
class LexicographicQP(BarrierQP):
    """min |J (q̇ − q̇_n)|² + ε² |q̇ − q̇_n|² over all q̇ that satisfy the rows of `BarrierQP` as well as
    possible, and the bounds.

    Kanoun, Lamiraux & Wieber, IEEE Trans. Robotics 27(4), 2011; solved faster by Escande, Mansard & Wieber,
    Int. J. Robotics Research 33(7), 2014. Level 1: the inequalities of all pairs; level 2: the hand's task;
    level 3: the joint velocities. Unlike in `BarrierQP`, the hand moves only if the rows leave no other way.

    `BarrierQP` finds how well every row can be satisfied; a second programme requires it. Level 3 is only a
    weight ε, which bounds the joint velocities near a singular hand and moves the hand by about ε² of their
    saving. A task that uses every joint (no `task_jacobian`) gives `BarrierQP`.
    """

    wants_task: ClassVar[bool] = True

    def __call__(self, situation: Situation) -> Array:
        first, J = super().__call__(situation), situation.task_jacobian
        if J is None or np.array_equal(first, situation.nominal):
            return first
        rows, least = pair_rates(self, situation)
        weight = J.T.dot(J)
        weight.ravel()[:: len(weight) + 1] += POSTURE_WEIGHT * POSTURE_WEIGHT
        lower, upper = situation.lower, situation.upper
        velocities = nearest(
            situation.nominal, rows, np.minimum(least, rows.dot(first)), lower, upper, weight
        )
        if velocities is None:
            return first
        return (
            velocities
            if lower is None or upper is None
            else np.clip(velocities, lower, np.maximum(lower, upper))
        )
