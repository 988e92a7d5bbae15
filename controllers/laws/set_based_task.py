"""A set-based task: avoidance exists only where the task would leave the valid set; Moe, Antonelli, Teel, Pettersen & Schrimpf 2016."""

from dataclasses import dataclass

from controllers.laws.row_law import RowLaw


@dataclass(frozen=True)
class SetBasedTask(RowLaw):
    """q̇ = q̇_n while d > d_m or −u is in the tangent cone of the set d ≥ d_m; else q̇ = (I − J_d^# J_d) q̇_n
    + J_d^# ẋ_a.

    S. Moe, G. Antonelli, A. R. Teel, K. Y. Pettersen and J. Schrimpf, Set-based tasks within the
    singularity-robust multiple task-priority inverse kinematics framework, Frontiers in Robotics and AI 3:16,
    2016. The distance is a task of first priority that does nothing inside its set. At the boundary the
    task's own solution is used while it does not leave the set; otherwise the distance is frozen, ẋ_a = 0,
    and the task has the null space. The extended cone is [0, ∞) on and below d_m.

    It is discontinuous by design: at d_m the distance rate jumps from −u to 0, and an arm pulled there
    switches for ever, with steps of q̇ that do not shrink with dt. In return nothing changes earlier than
    necessary.

    An obstacle that approaches at w still reduces a frozen distance. A restoring velocity ẋ_a = k_r (d_m − d)
    limits the loss to w / k_r; k_r = 0 freezes. The test is then whether the task returns at least as fast.

    Attributes:
        critical_distance: d_m [m].
        restoring_gain: k_r [1/s].
        feed_forward: our addition: include the obstacle's approach in the distance rate, ḋ = J_d q̇ − w.
    """

    critical_distance: float
    restoring_gain: float
    feed_forward: bool = False

    def activation(self, distance: float) -> float:
        """1 at or below d_m, else 0."""
        return 1.0 if distance <= self.critical_distance else 0.0

    def correction(self, distance: float, pull: float, approach: float) -> float:
        """c [m/s]: what is missing to the least rate that does not leave the set, 0 inside it."""
        if distance > self.critical_distance:
            return 0.0
        least = self.restoring_gain * (self.critical_distance - distance)
        if self.feed_forward:
            least += approach
        return max(least + pull, 0.0)
