"""Continuous inverse of a hierarchy with a unilateral constraint in front; Mansard, Khatib & Kheddar 2009."""

from dataclasses import dataclass

from controllers.laws.intermediate_value import IntermediateValue


@dataclass(frozen=True)
class HierarchicalInverse(IntermediateValue):
    """q̇ = (1 − λ) q̇_b + λ q̇_ab where v > J_d q̇_b, else q̇_b: q̇_b solves the hand's task alone, q̇_ab
    behind the distance.

    N. Mansard, O. Khatib and A. Kheddar, A unified approach to integrate unilateral constraints in the stack
    of tasks, IEEE Trans. Robotics 25(3), 2009. With the constraint the hand is solved in the null space of
    J_d, q̇_ab = J_d^# v + (J N)^# (ẋ_b − J J_d^# v) with N = I − J_d^# J_d; without it, alone. The solutions
    of all sets of constraints are weighted by their activations; one row makes two sets. It is unilateral: a
    retreat faster than v is unchanged.

    Except for that, one row gives the law of Lee, Mansard & Park 2012, which avoids the enumeration of all
    sets, with the same damping and limits.
    """

    def correction(self, distance: float, pull: float, approach: float) -> float:
        """c = λ max(v + u, 0) [m/s]."""
        return max(super().correction(distance, pull, approach), 0.0)
