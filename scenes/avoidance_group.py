"""Avoidance by one row of J_d."""

import numpy as np

from controllers.choices import BoundsTreatment
from controllers.kinematics import Array
from controllers.laws.situation import Law, Situation
from controllers.limits import Bounded, bounded_row, shortened_row
from controllers.null_space_saturation import saturated
from controllers.proximity import Proximity
from scenes.arm_tasks.arm_task import ArmTask
from scenes.room import World
from scenes.world_stages import WorldStage


class AvoidanceGroup:
    """One or more arms that avoid together.

    Args:
        tasks: with adjacent columns of q.

    Attributes:
        joints: columns of q.
        nominal: q̇_n (n,), filled before `situation` [rad/s].
        velocities: q̇ (n,), a view of the world's.
        stages: avoid the surroundings, after the law; columns count from the group's first.
    """

    def __init__(self, world: World, tasks: tuple[ArmTask, ...], all_tasks: tuple[ArmTask, ...]) -> None:
        self.tasks = tasks
        self.joints = slice(min(m.joints.start for m in tasks), max(m.joints.stop for m in tasks))
        self.velocities = world.velocities[self.joints]
        self.box = world.bounds.part(self.joints)
        self._positions = world.positions[self.joints]
        others = [other for other in all_tasks if other not in tasks]
        self._others = [(other, other.joints, world.velocities[other.joints]) for other in others]
        self.nominal = np.zeros(self.joints.stop - self.joints.start)
        self._detector = world.detector
        self.stages: list[tuple[slice, WorldStage]] = []

    def part(self, task: ArmTask) -> Array:
        """A task's part of `nominal`, a view."""
        first = self.joints.start
        return self.nominal[task.joints.start - first : task.joints.stop - first]

    def approach(self, row: Array) -> float:
        """w along a row (nv,): the others' speed towards it [m/s]."""
        w = 0.0
        for _, columns, velocities in self._others:
            w -= float(row[columns].dot(velocities))
        return w

    def _approaches(self, rows: Array, adds_w: bool) -> Array:
        """w (…,) along rows (…, nv) [m/s].

        A slave copies this group's last velocity. A law that adds w would get it back as −w and alternate
        with the root −λ, so only the slave's own approach counts; w ≤ v is still enough for the promise.
        """
        w, copied = np.zeros(rows.shape[:-1]), False
        for task, columns, velocities in self._others:
            own = task.own_velocity(self.joints) if adds_w else None
            copied |= own is not None
            w -= rows[..., columns].dot(velocities if own is None else own)
        return np.maximum(w, 0.0) if copied else w

    def situation(self, law: Law, near: Proximity, error: float = 0.0, adds_w: bool = False) -> Situation:
        """Situation for a law. `error`: of all measured distances [m]; `near` includes it."""
        w = float(self._approaches(near.row, True)) if adds_w else self.approach(near.row)
        plain = (self._positions, self.nominal, near.row[self.joints], near.law_distance, w)
        if not (law.wants_task or law.wants_all_pairs):
            return Situation(*plain)
        rows = distances = approaches = None
        if law.wants_all_pairs and self._detector.count:
            all_rows = self._detector.rows()
            rows, distances = all_rows[:, self.joints], self._detector.distances()
            approaches = self._approaches(all_rows, adds_w)
            if error:
                distances += error
        J = self._task_jacobian() if law.wants_task else None
        return Situation(*plain, J, self.box.lower, self.box.upper, rows, distances, approaches)

    def _task_jacobian(self) -> Array | None:
        """J (m, n) of all tasks, stacked; None if they leave no joint free."""
        if len(self.tasks) == 1:
            return self.tasks[0].task_jacobian
        blocks = [task.task_jacobian for task in self.tasks]
        sizes = [task.joints.stop - task.joints.start for task in self.tasks]
        if all(block is None for block in blocks):
            return None
        filled = [np.eye(size) if block is None else block for block, size in zip(blocks, sizes, strict=True)]
        J, row = np.zeros((sum(len(block) for block in filled), len(self.nominal))), 0
        for task, block in zip(self.tasks, filled, strict=True):
            first = task.joints.start - self.joints.start
            J[row : row + len(block), first : first + block.shape[1]] = block
            row += len(block)
        return J

    def bounded(self, row: Array, wanted: Array, treatment: BoundsTreatment) -> Bounded:
        """The law's velocity, brought inside the bounds; see `controllers.limits`.

        Args:
            row: J_d (n,) [m/rad].
            wanted: the law's q̇ (n,) [rad/s].
        """
        if treatment == "scale":
            return shortened_row(wanted, row, self.box)
        # Clipping first loses nothing: along the row, both ways meet the same bounds in the same order.
        bounded = bounded_row(self.box.clip(wanted), row, float(row.dot(wanted)), self.box)
        J = self._task_jacobian() if treatment == "null_space" else None
        if J is None:
            return bounded
        box = self.box
        return bounded._replace(
            velocities=saturated(J, wanted, box.lower, box.upper, bounded.velocities, row)[0]
        )
