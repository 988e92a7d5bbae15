"""Continuous inverse of a hierarchy with a unilateral constraint."""

from dataclasses import dataclass

from controllers.laws.intermediate_value import IntermediateValue


@dataclass(frozen=True)
class HierarchicalInverse(IntermediateValue):
    """q̇ = (1 − λ) q̇_b + λ q̇_ab where v > J_d q̇_b, else q̇_b: q̇_b solves the hand's task alone, q̇_ab
    behind the distance.

    Mansard, Khatib & Kheddar, IEEE Trans. Robotics 25(3), 2009. q̇_ab = J_d^# v + (J N)^# (ẋ_b − J J_d^# v)
    with N = I − J_d^# J_d. The solutions of all sets of constraints are weighted by their activations; one
    row makes two sets. A retreat faster than v is unchanged.

    Otherwise one row gives `IntermediateValue`, with the same damping and limits.
    """

    def correction(self, distance: float, pull: float, approach: float) -> float:
        return max(super().correction(distance, pull, approach), 0.0)
