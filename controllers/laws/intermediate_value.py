"""Intermediate desired values: the first task fades in, the second is solved in its true null space; Lee, Mansard & Park 2012."""

from dataclasses import dataclass
from typing import ClassVar, Final

from controllers.kinematics import Array
from controllers.laws.row_law import BlendLaw
from controllers.laws.situation import AUTHORITY, Situation, along_row, row_damping
from controllers.laws.task_space import free_part, mostly_free_part

TASK_DAMPING: Final = 0.2
"""μ where the hand leaves no freedom at all [m/rad]: joint motion then counts as much as 0.2 m of hand motion a radian."""


@dataclass(frozen=True)
class IntermediateValue(BlendLaw):
    """q̇ = J_a^# ẋ_aⁱ + (J_b N_a)^# (ẋ_b − J_b J_a^# ẋ_aⁱ), with ẋ_aⁱ = λ ẋ_a + (1 − λ) J_a q̇_n, J_a = J_d and ẋ_a = v.

    J. Lee, N. Mansard and J. Park, Intermediate desired value approach for task transition of robots in kinematic control, IEEE
    Trans. Robotics 28(6), 2012. The first task is not asked for v at once, but for a value between v and what it would do anyway;
    with the paper's λ, eq. (31), the distance rate is the paper's, J_d q̇ = λ v − (1 − λ) u.

    The difference is in the second task. The paper cuts J_b^# ẋ_b to the null space of J_d and thereby moves the hand even if other
    joints could have made up for it. Here the hand's task is solved again in the null space of J_d: of all q̇ with that distance rate,
    the one nearest to the hand's velocity, and of these the one nearest to q̇_n. With a task that uses every joint, J_b = I, nothing
    can make up for anything, and the law is the paper's.

    Written as a change of q̇_n, so that motion of the joints that the hand does not feel passes through: Δ along (J_d N_b)ᵀ, scaled to
    J_d Δ = λ (v + u). Where |J_d N_b| < 0.12 m/rad the hand and the obstacle compete for the same joints (an algorithmic singularity)
    and (J_b N_a)^# would explode. There the hand gives way by degrees: Δ has the least |J_b Δ|² + μ² |Δ|², with μ growing from 0 to
    0.2 m/rad. The hand is never moved more than by the paper's law, and the distance rate is not affected.
    """

    wants_task: ClassVar[bool] = True

    def __call__(self, situation: Situation) -> Array:
        """Return q̇ (n,) [rad/s]."""
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
