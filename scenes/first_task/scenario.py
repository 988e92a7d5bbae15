"""Another first task (eqs 9–13) of one arm: a wall, its joint stops, a regular posture or its balance."""

from controllers.errors import BadSetting
from controllers.first_tasks.first_task import FirstTask
from controllers.laws.row_law import RowLaw
from controllers.laws.smooth_priority import SmoothPriority
from controllers.row_stage import RowStage
from scenes.arm_tasks.hold_task import HoldTask
from scenes.first_task.autopilot import autopilot
from scenes.first_task.detector import FirstTaskDetector
from scenes.first_task.place import build_first_task_room, start_problem
from scenes.first_task.wall import WallTask
from scenes.roles import Roles, Scenario, TargetSource
from scenes.room import Room, World
from scenes.settings import RunSettings


class AnotherFirstTask(Scenario):
    """The visitor draws the hand to a forbidden place, or brings the wall."""

    def room(self, settings: RunSettings) -> Room:
        return build_first_task_room(settings.first, settings.load, settings.together == "stages")

    def roles(self, world: World, settings: RunSettings) -> Roles:
        del settings
        arm, wall = world.room.arms[0], world.room.wall
        keeper = HoldTask(world, arm, movable=True)
        others = () if wall is None else (WallTask(world, wall),)
        return Roles((*others, keeper), arm, arm, keeper, None, (keeper,))

    def source(self, world: World, settings: RunSettings) -> TargetSource:
        hand = world.kinematics.hand_pose(world.room.arms[0]).translation.copy()
        return autopilot(settings.first, settings.seed, hand)

    def stages(self, world: World, settings: RunSettings) -> tuple[RowStage, ...]:
        detector = world.detector
        if settings.together != "stages" or not isinstance(detector, FirstTaskDetector):
            return ()
        law = settings.law.made()
        if not isinstance(law, RowLaw):
            # A law of all rows is one stage; those above it use the paper's law.
            law = SmoothPriority(
                settings.law.critical_distance, settings.law.order, settings.law.nominal_velocity
            )
        box = world.bounds.part(world.room.arms[0].joints)
        tasks: tuple[FirstTask, ...] = detector.tasks[1:]
        return tuple(RowStage(task, law, box) for task in tasks)

    def problem(self, world: World, settings: RunSettings) -> BadSetting | None:
        return start_problem(world, settings.law.critical_distance)
