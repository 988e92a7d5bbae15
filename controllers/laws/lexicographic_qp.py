"""One inequality a pair first, the hand second, the posture last; Kanoun, Lamiraux & Wieber 2011."""

from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from controllers.kinematics import Array
from controllers.laws.barrier_qp import BarrierQP, nearest, pair_rates
from controllers.laws.situation import Situation

POSTURE_WEIGHT: Final = 0.02
"""ε [m/rad]: a joint's motion counts as much as that of a hand which it moves by 20 mm a radian."""


@dataclass(frozen=True)
class LexicographicQP(BarrierQP):
    """min |J (q̇ − q̇_n)|² + ε² |q̇ − q̇_n|² over all q̇ that keep the rows of `BarrierQP` as well as they can be kept, and the bounds.

    O. Kanoun, F. Lamiraux and P.-B. Wieber, Kinematic control of redundant manipulators: generalizing the task-priority framework
    to inequality tasks, IEEE Trans. Robotics 27(4), 2011; solved faster by A. Escande, N. Mansard and P.-B. Wieber, Hierarchical
    quadratic programming, Int. J. Robotics Research 33(7), 2014. Level 1 are the inequalities of all pairs, level 2 is the hand's
    task, level 3 the velocity of the joints; the bounds hold throughout. A flat programme weighs hand and joints alike, so that the
    hand moves even where other joints could do without it. Here it moves only as far as the rows leave it no other way.

    Two programmes in n unknowns: the flat one finds how far every row can be kept, and that is then required of the second one.
    Level 3 is no level of its own but has the weight ε, which bounds the joints' velocities where the hand is singular, and moves
    the hand by some ε² of what they would save. A task that uses every joint (no `task_jacobian`) makes it the flat programme.
    """

    wants_task: ClassVar[bool] = True

    def __call__(self, situation: Situation) -> Array:
        """Return q̇ (n,) [rad/s], inside the bounds if there are any."""
        first, J = super().__call__(situation), situation.task_jacobian
        if J is None or np.array_equal(first, situation.nominal):
            return first
        rows, least = pair_rates(self, situation)
        weight = J.T.dot(J)
        weight.ravel()[:: len(weight) + 1] += POSTURE_WEIGHT * POSTURE_WEIGHT
        lower, upper = situation.lower, situation.upper
        velocities = nearest(situation.nominal, rows, np.minimum(least, rows.dot(first)), lower, upper, weight)
        if velocities is None:
            return first
        return velocities if lower is None or upper is None else np.clip(velocities, lower, np.maximum(lower, upper))
