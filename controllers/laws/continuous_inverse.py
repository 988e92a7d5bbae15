"""The continuous inverse of a stack with variable rows."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from controllers.kinematics import Array
from controllers.laws.row_law import BlendLaw
from controllers.laws.situation import Situation, row_damping
from controllers.laws.task_space import free_part, mostly_free_part


@dataclass(frozen=True)
class ContinuousInverse(BlendLaw):
    """q̇ = S^⊕ [v; ẋ_b] with S = [J_d; J], H = diag(λ, I) and S^⊕ = (1 − λ) [0, J^#] + λ [J_d; J]^#.

    Mansard, Remazeilles & Chaumette, IEEE Trans. Automatic Control 54(11), 2009. The pseudo-inverse of H S
    jumps with its rank when a row of H becomes zero; theirs weights the inverses of all sets of rows by their
    activations.

    Distance and hand have no priority. With enough freedom both are reached: J_d q̇ = λ v − (1 − λ) u without
    motion of the hand. Otherwise [J_d; J]^# is the least-squares compromise, where 1 m/s of distance counts
    as much as 1 m/s (or 1 rad/s) of the task: d_m is not kept, and a task that uses every joint (J = I)
    leaves |J_d|² / (1 + |J_d|²) of the retreat.

    Written as a change of q̇_n, with ẋ_b = J q̇_n, so that unused joints follow q̇_n. If the hand leaves less
    than 0.12 m/rad of J_d, damping up to 0.06 m/rad bounds q̇.
    """

    wants_task: ClassVar[bool] = True

    def __call__(self, situation: Situation) -> Array:
        nominal, row, J = situation.nominal, situation.row, situation.task_jacobian
        c = self.correction(situation.distance, situation.pull, situation.approach)
        if c == 0.0:
            return nominal
        if J is None:
            J = np.eye(len(row))
        # [J_d; J]^# [c; 0] is c (SᵀS)^# J_dᵀ: along J_d N if that is regular, else the damped solution.
        way = free_part(row, J)
        damping = row_damping(float(way.dot(way)))
        if damping > 0.0:
            way = mostly_free_part(row, J, damping)
        return nominal + way * (c / (damping + float(row.dot(way))))
