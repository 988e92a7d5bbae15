"""The last stage of every arm: the paper's law once more, for its distance from table, stand, floor and its own links.

It acts on what the stages before it ask for: a person's hand, the law that keeps the arms apart. So an arm that is pressed against the
table stays clear of it, and its distance from the other arm gives way.
"""

from typing import Final

from controllers.first_tasks.surroundings import Surroundings
from controllers.kinematics import Array
from controllers.limits import VelocityBox
from controllers.row_stage import smooth_stage
from scenes.room import World
from scenes.surroundings import ball_surroundings, surroundings

ORDER: Final = 6.0
"""n."""


class WorldStage:
    """Keeps one arm clear of its surroundings by the paper's law, one-sided.

    The same as a `RowStage` by `SmoothPriority`, in one call of a loop unless a joint meets its bounds.

    Args:
        task: what is kept.
        box: bounds of q̇ of the arm.
    """

    def __init__(self, task: Surroundings, box: VelocityBox) -> None:
        self.task = task
        self._law = task.law(ORDER, box.lower, box.upper)
        self._within_bounds = smooth_stage(task, box, ORDER, one_sided=True)

    def keep(self, velocities: Array) -> None:
        """Replace what was asked for (n,) by q̇ within the joints' bounds [rad/s]."""
        if not self._law(velocities):
            velocities[:] = self._within_bounds(velocities)


class WorldStages:
    """Keeps the arms and the ball of a room clear of their surroundings.

    Args:
        world: its present state.

    Attributes:
        stages: columns in q of each arm, and of the ball, that can meet anything, and its stage.
    """

    def __init__(self, world: World) -> None:
        made = [(arm.joints, surroundings(world, arm)) for arm in world.room.arms]
        if world.room.ball is not None:
            made.append((world.room.ball, ball_surroundings(world)))
        self.stages = [(joints, WorldStage(task, world.bounds.part(joints))) for joints, task in made if task]

    def inside(self, joints: slice) -> "list[tuple[slice, WorldStage]]":
        """Stages of the arms in some columns of q, each with its columns counted from the first of them."""
        return [
            (slice(columns.start - joints.start, columns.stop - joints.start), stage)
            for columns, stage in self.stages
            if joints.start <= columns.start and columns.stop <= joints.stop
        ]
