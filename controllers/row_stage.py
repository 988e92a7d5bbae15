"""A stage: a first task, its law and the joints' bounds; and ordered stages, of which the last wins.

Eq. (12) of Petrič & Žlajpah 2011, applied again to its own result, gives a third task priority over both: q̇₁
= law₁(q̇_n), q̇₂ = law₂(q̇₁), … Every stage ends within the joints' bounds, so the last one's promise,

    ḣ = λ v − (1 − λ) u − w     with u = −J_a q̇ of the stage before,

holds whatever the earlier stages did. Their ḣ changes by J Δq̇ of the later stages.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from controllers.first_tasks.first_task import FirstTask, Margin
from controllers.kinematics import Array
from controllers.laws.row_law import RowLaw
from controllers.laws.situation import AUTHORITY, along_row
from controllers.laws.smooth_priority import SmoothPriority
from controllers.limits import Bounded, VelocityBox, bounded_row


@dataclass(frozen=True)
class RowStage:
    """Keeps a first task of one arm.

    Attributes:
        law: in the unit of the task.
        box: bounds of q̇.
    """

    task: FirstTask
    law: RowLaw
    box: VelocityBox

    def bounded(self, nominal: Array, margin: Margin) -> Bounded:
        """q̇ (n,) within the bounds [rad/s], with the law's rate of h as far as joints can reach it.

        Args:
            nominal: q̇_n (n,) [rad/s]; returned itself if nothing changes.
            margin: of `task` now.
        """
        row, u = margin.row, -float(margin.row.dot(nominal))
        c = self.law.correction(margin.value, u, margin.approach)
        # Rows of every unit meet the same damping: it begins where |J_a| is the task's `authority`.
        scale = AUTHORITY / self.task.authority
        scaled = row if scale == 1.0 else scale * row
        wanted = nominal if c == 0.0 else along_row(nominal, scaled, scale * c)
        if self.box.contains(wanted):
            return Bounded(wanted)
        return bounded_row(self.box.clip(wanted), scaled, float(scaled.dot(wanted)), self.box)

    def __call__(self, nominal: Array) -> Array:
        """q̇ (n,) at the last `Kinematics.update`, for q̇_n (n,) [rad/s]."""
        return self.bounded(nominal, self.task.margin()).velocities


def smooth_stage(task: FirstTask, box: VelocityBox, order: float = 6.0, one_sided: bool = False) -> RowStage:
    """Stage with the paper's law, eq. (32), and the task's own h_m and v.

    Args:
        box: bounds of q̇.
        order: n.
        one_sided: never slow down a value that already rises faster than v.
    """
    return RowStage(
        task, SmoothPriority(task.critical_value, order, task.nominal_rate, one_sided=one_sided), box
    )


def through_stages(nominal: Array, stages: Sequence[RowStage]) -> Array:
    """q̇ (n,) after all stages, the last with priority, for q̇_n (n,) [rad/s]."""
    for stage in stages:
        nominal = stage(nominal)
    return nominal
