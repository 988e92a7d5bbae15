"""Hold (Fig. 5): a person moves one arm at random, the other keeps its hand in place and gets out of the way."""

from scenes.arm_tasks.guided_task import GuidedTask
from scenes.arm_tasks.hold_task import HoldTask
from scenes.autopilot import Autopilot
from scenes.roles import Roles, TargetSource
from scenes.settings import RunSettings
from scenes.world import World


def roles(world: World, settings: RunSettings) -> Roles:
    """Return the roles."""
    room = world.room
    guided, avoiding = room.arm(settings.guided), room.other(settings.guided)
    held = GuidedTask(world, guided, room.robots[room.arms.index(guided)])
    keeper = HoldTask(world, avoiding)
    return Roles((held, keeper), guided, avoiding, keeper, held, (keeper,))


def source(world: World, settings: RunSettings) -> TargetSource:
    """Return the autopilot of the arm that the person moves, starting where its hand is."""
    start = world.kinematics.hand_pose(world.room.arm(settings.guided)).translation.copy()
    return Autopilot(world.room, settings.guided, settings.seed, start)
