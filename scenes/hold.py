"""Hold (Fig. 5): a person moves one arm at random, the other keeps its hand in place and gets out of the way."""

from scenes.autopilot import Autopilot
from scenes.cast import Cast, Person
from scenes.movers.guided import GuidedArm
from scenes.movers.keeper import Keeper
from scenes.settings import RunSettings
from scenes.world import World


def cast(world: World, settings: RunSettings) -> Cast:
    """Return who takes part."""
    room = world.room
    guided, avoiding = room.arm(settings.guided), room.other(settings.guided)
    held = GuidedArm(world, guided, room.robots[room.arms.index(guided)])
    keeper = Keeper(world, avoiding)
    return Cast((held, keeper), guided, avoiding, keeper, held, (keeper,))


def person(world: World, settings: RunSettings) -> Person:
    """Return who moves the guided arm by itself, beginning where its hand is."""
    start = world.kinematics.hand_pose(world.room.arm(settings.guided)).translation.copy()
    return Autopilot(world.room, settings.guided, settings.seed, start)
