"""Last stage of every arm: the paper's law for its distance from table, stand, floor and its own links.

It changes what earlier stages ask for: an arm pressed against the table stays clear of it, and comes nearer
to the other arm.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from controllers.first_tasks.surroundings import Surroundings
from controllers.kinematics import Array
from controllers.limits import VelocityBox
from controllers.row_stage import smooth_stage
from scenes.furniture import FLOOR_BOX
from scenes.room import World
from scenes.surroundings import MARGIN, ball_surroundings, surroundings

ORDER: Final = 6.0
"""n."""


TOUCHED: Final = 1.6 * MARGIN
"""A nearer thing counts as touched; it slows the arm by 5 % and more [m]."""

Thing = Literal["table", "floor", "stand", "pedestal", "itself"]


@dataclass(frozen=True, eq=False)
class Touch:
    """Contact of an arm or a ball.

    Attributes:
        point: on the surface of the touched thing (3,), world [m].
    """

    thing: Thing
    point: Array


class WorldStage:
    """Keeps one arm clear of its surroundings by the paper's law, one-sided.

    Equals a `RowStage` by `SmoothPriority`, in one call of a loop unless a joint meets its bounds.
    """

    def __init__(self, task: Surroundings, box: VelocityBox) -> None:
        self.task = task
        self._law = task.law(ORDER, box.lower, box.upper)
        self._within_bounds = smooth_stage(task, box, ORDER, one_sided=True)

    def keep(self, velocities: Array) -> None:
        """Change q̇ (n,) in place to keep clear, within the joints' bounds [rad/s]."""
        if not self._law(velocities):
            velocities[:] = self._within_bounds(velocities)

    def touch(self, most: float = TOUCHED) -> Touch | None:
        """Contact at the last `Kinematics.update`; None if nothing is nearer than `most` [m]."""
        task = self.task
        # The smooth minimum is never above the least of the margins.
        if task.margin().value > most:
            return None
        nearest = int(task.contacts[:, 0].argmin())
        margin, *numbers = task.contacts[nearest].tolist()
        if margin > most:
            return None
        point, direction = np.array(numbers).reshape(2, 3)
        meeting, way = task.meetings[nearest], direction / max(float(np.linalg.norm(direction)), 1e-9)
        if meeting.over_box:
            radius = task.capsules[meeting.first].radius
            return Touch("floor" if meeting.second == FLOOR_BOX else "table", point - (radius + margin) * way)
        inner = task.inner_of(meeting)
        return Touch(
            _thing(task.names[inner], task.capsules[inner].joint), point + task.capsules[inner].radius * way
        )


def _thing(name: str, joint: int) -> Thing:
    if joint:
        return "itself"
    return "stand" if name.startswith("stand") else "pedestal"


def kept_clear(world: World) -> list[tuple[slice, Surroundings]]:
    """Columns in q and surroundings of each arm, and the ball, that can meet anything."""
    made = [(arm.joints, surroundings(world, arm)) for arm in world.room.arms]
    if world.room.ball is not None:
        made.append((world.room.ball, ball_surroundings(world)))
    return [(joints, task) for joints, task in made if task is not None]


def clearance(kept: Iterable[tuple[slice, Surroundings]]) -> float:
    """Least distance from anything at the last `Kinematics.update` [m], negative inside; ∞ if there is
    nothing.
    """
    least = np.inf
    for _, task in kept:
        task.margin()
        least = min(least, float(task.contacts[:, 0].min()))
    return least


class WorldStages:
    """Keeps the arms and the ball of a room clear of their surroundings.

    Attributes:
        stages: columns in q and stage of each one of `kept_clear`.
    """

    def __init__(self, world: World) -> None:
        self.stages = [
            (joints, WorldStage(task, world.bounds.part(joints))) for joints, task in kept_clear(world)
        ]

    def touches(self) -> tuple[Touch, ...]:
        return tuple(touch for columns, _ in self.stages if (touch := self.touch_of(columns)) is not None)

    def touch_of(self, joints: slice, most: float = TOUCHED) -> Touch | None:
        """Contact of the arm or ball in these columns of q, see `WorldStage.touch`."""
        return next((stage.touch(most) for columns, stage in self.stages if columns == joints), None)

    def inside(self, joints: slice) -> "list[tuple[slice, WorldStage]]":
        """Stages in these columns of q, with columns counted from the first one."""
        return [
            (slice(columns.start - joints.start, columns.stop - joints.start), stage)
            for columns, stage in self.stages
            if joints.start <= columns.start and columns.stop <= joints.stop
        ]
