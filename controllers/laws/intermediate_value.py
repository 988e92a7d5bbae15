"""The first task fades in, the second is solved in its true null space."""

from dataclasses import dataclass
from typing import ClassVar, Final

from controllers.kinematics import Array
from controllers.laws.row_law import BlendLaw
from controllers.laws.situation import AUTHORITY, Situation, along_row, row_damping
from controllers.laws.task_space import free_part, mostly_free_part

TASK_DAMPING: Final = 0.2
"""μ where the hand leaves no freedom [m/rad]: 1 rad costs as much as 0.2 m of hand motion."""


@dataclass(frozen=True)
class IntermediateValue(BlendLaw):
    """q̇ = J_a^# ẋ_aⁱ + (J_b N_a)^# (ẋ_b − J_b J_a^# ẋ_aⁱ), with ẋ_aⁱ = λ ẋ_a + (1 − λ) J_a q̇_n, J_a = J_d
    and ẋ_a = v.

    Lee, Mansard & Park, IEEE Trans. Robotics 28(6), 2012. With λ of eq. (31) the distance rate is the
    paper's, J_d q̇ = λ v − (1 − λ) u.

    The paper cuts J_b^# ẋ_b to the null space of J_d, which moves the hand even if other joints could
    compensate. Here the hand's task is solved again there: of all q̇ with that distance rate, those nearest
    to the hand's velocity, and of these the one nearest to q̇_n. For J_b = I the law is the paper's.

    Written as a change Δ of q̇_n, so that joint motion without effect on the hand is kept: along (J_d N_b)ᵀ,
    scaled to J_d Δ = λ (v + u). Where |J_d N_b| < 0.12 m/rad (an algorithmic singularity), the hand yields
    gradually, as (J_b N_a)^# would grow without bound: Δ has the least |J_b Δ|² + μ² |Δ|², with μ growing
    from 0 to 0.2 m/rad. The distance rate is unaffected, and the hand never moves more than with the paper's
    law.
    """

    wants_task: ClassVar[bool] = True

    def __call__(self, situation: Situation) -> Array:
        nominal, row, J = situation.nominal, situation.row, situation.task_jacobian
        c = self.correction(situation.distance, situation.pull, situation.approach)
        if J is None or c == 0.0:
            return along_row(nominal, row, c)
        way = free_part(row, J)
        freedom = float(way.dot(way)) / (AUTHORITY * AUTHORITY)
        if freedom < 1.0:
            way = mostly_free_part(row, J, (TASK_DAMPING * (1.0 - freedom)) ** 2)
        lever, square = float(row.dot(way)), float(row.dot(row))
        if lever <= 0.0:
            return nominal
        # A short row is damped as in `along_row`: the same distance rate as the paper's law, whatever the way through the joints.
        return nominal + way * (c * square / ((square + row_damping(square)) * lever))
