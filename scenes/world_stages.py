"""The last stage of every arm: the paper's law once more, for its distance from table, stand, floor and its own links.

It acts on what the stages before it ask for: a person's hand, the law that keeps the arms apart. So an arm that is pressed against the
table stays clear of it, and its distance from the other arm gives way.
"""

from controllers.kinematics import Array
from scenes.room import World
from scenes.surroundings import world_stage


class WorldStages:
    """Keeps the arms of a room clear of their surroundings. `world`: the room as it stands now."""

    def __init__(self, world: World) -> None:
        made = ((arm.joints, world_stage(world, arm)) for arm in world.room.arms)
        self._stages = [(joints, stage) for joints, stage in made if stage is not None]

    def kept(self, joints: slice, velocities: Array) -> Array:
        """Return q̇ (n,) within the joints' bounds in place of what was asked for [rad/s], of some columns of q with whole arms."""
        kept = velocities
        for columns, stage in self._stages:
            if joints.start <= columns.start and columns.stop <= joints.stop:
                part = slice(columns.start - joints.start, columns.stop - joints.start)
                own = stage(kept[part])
                if kept is velocities:
                    kept = velocities.copy()
                kept[part] = own
        return kept
