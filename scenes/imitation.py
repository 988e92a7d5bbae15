"""Imitation (Figs 7, 8): a person's two arms drive both robots by four angles an arm, and both keep clear of each other."""

from scenes.arm_tasks.follow_task import JointFollower
from scenes.arm_tasks.imitated_person import ImitatedPerson
from scenes.person.clips import Clip
from scenes.roles import Roles, TargetSource
from scenes.room import SIDES
from scenes.settings import RunSettings
from scenes.targets import AnglesTarget
from scenes.world import World


def roles(world: World, settings: RunSettings) -> Roles:
    """Return the roles. The arm that is called the person's own is driven like the other one."""
    room = world.room
    imitated = ImitatedPerson(world)
    followers = {side: JointFollower(world, room.arm(side), imitated.arm(i)) for i, side in enumerate(SIDES)}
    own, other = room.arm(settings.guided), room.other(settings.guided)
    task, held = followers[SIDES[room.arms.index(other)]], followers[settings.guided]
    return Roles((followers["left"], followers["right"]), own, other, task, held, (task, held))


def source(world: World, settings: RunSettings) -> TargetSource:
    """Return the built-in clip as a person."""
    del world
    return ClipPerson(settings)


class ClipPerson:
    """Makes the gestures of a built-in clip. `settings`: which clip, and which person by the seed."""

    def __init__(self, settings: RunSettings) -> None:
        self._clip = Clip(settings.clip, settings.seed)

    def target(self, time: float) -> AnglesTarget:
        """Return how the person's arms are at a time [s]."""
        return AnglesTarget(self._clip.angles(time))
