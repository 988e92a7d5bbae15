"""Avoidance only where the task would leave the valid set."""

from dataclasses import dataclass

from controllers.laws.row_law import RowLaw


@dataclass(frozen=True)
class SetBasedTask(RowLaw):
    """q̇ = q̇_n while d > d_m or −u is in the tangent cone of the set d ≥ d_m; else q̇ = (I − J_d^# J_d) q̇_n
    + J_d^# ẋ_a.

    Moe, Antonelli, Teel, Pettersen & Schrimpf, Frontiers in Robotics and AI 3:16, 2016. On and below d_m
    (extended cone [0, ∞)) the task's own solution is used while it does not leave the set; otherwise the
    distance is frozen, ẋ_a = 0, and the task has the null space.

    It is discontinuous by design: at d_m the distance rate jumps from −u to 0, and an arm pulled there
    switches for ever, with steps of q̇ that do not shrink with dt.

    If the obstacle approaches at w, a restoring velocity ẋ_a = k_r (d_m − d) limits the loss to w / k_r; the
    test is then whether the task returns at least as fast.

    Attributes:
        critical_distance: d_m [m].
        restoring_gain: k_r [1/s]; 0 freezes.
        feed_forward: ours: include the obstacle's approach, ḋ = J_d q̇ − w.
    """

    critical_distance: float
    restoring_gain: float
    feed_forward: bool = False

    def activation(self, distance: float) -> float:
        return 1.0 if distance <= self.critical_distance else 0.0

    def correction(self, distance: float, pull: float, approach: float) -> float:
        """c [m/s] to the least rate that does not leave the set."""
        if distance > self.critical_distance:
            return 0.0
        least = self.restoring_gain * (self.critical_distance - distance)
        if self.feed_forward:
            least += approach
        return max(least + pull, 0.0)
