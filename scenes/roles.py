"""Which task moves which arm in an experiment, and which arms avoid."""

from collections.abc import Callable
from dataclasses import dataclass
from pkgutil import resolve_name
from typing import Final, Protocol

import numpy as np

from controllers.errors import BadSetting
from controllers.kinematics import Arm, Array
from controllers.row_stage import RowStage
from scenes.arm_tasks.arm_task import ArmTask
from scenes.room import Room, World
from scenes.settings import AvoidChoice, RunSettings
from scenes.targets import Target


@dataclass(frozen=True)
class Roles:
    """Tasks and arms of an experiment.

    Attributes:
        tasks: in the order of evaluation; together they move every column of q once.
        guided: the arm that the person moves, or the only one.
        avoiding: the arm that plots and numbers show.
        task: of that arm.
        held: of the guided arm; None with one arm.
        paper: tasks that avoid in the paper's experiment, in the order of their history columns.
    """

    tasks: tuple[ArmTask, ...]
    guided: Arm
    avoiding: Arm
    task: ArmTask
    held: ArmTask | None
    paper: tuple[ArmTask, ...]

    def avoiders(self, choice: AvoidChoice) -> tuple[ArmTask, ...]:
        if choice == "paper" or self.held is None:
            return self.paper
        return {"free": (self.task,), "guided": (self.held,), "both": (self.task, self.held)}[choice]


class TargetSource(Protocol):
    def target(self, time: float) -> Target | None:
        """Target at a time [s]; None for no change."""
        ...


@dataclass(frozen=True)
class Scripted:
    """A target as a function of time [s]."""

    motion: Callable[[float], Target | None]

    def target(self, time: float) -> Target | None:
        return self.motion(time)


NO_TARGETS: Final = Scripted(lambda _: None)


def paced(source: TargetSource, factor: float) -> Scripted:
    return Scripted(lambda time: source.target(factor * time))


class Scenario:
    def room(self, settings: RunSettings) -> Room:
        raise NotImplementedError

    def roles(self, world: World, settings: RunSettings) -> Roles:
        raise NotImplementedError

    def source(self, world: World, settings: RunSettings) -> TargetSource:
        return NO_TARGETS

    def opening(self, world: World, settings: RunSettings) -> TargetSource | None:
        """Source for a page that starts without other requests, or None."""
        return None

    def stages(self, world: World, settings: RunSettings) -> tuple[RowStage, ...]:
        """Further first tasks of the avoiding arm; each overrides the law and those before it."""
        return ()

    def problem(self, world: World, settings: RunSettings) -> BadSetting | None:
        """Reason why the start cannot keep the settings, with its remedy, or None."""
        return None

    def way(self, settings: RunSettings, home: Array) -> Array:
        """Prescribed path (k, 3) of the hand from `home` (3,) [m]; (0, 3) without one."""
        return np.zeros((0, 3))


def scenario_of(settings: RunSettings) -> Scenario:
    scenario: Scenario = resolve_name(f"scenes.{settings.experiment.made_by}")()
    return scenario


def room_of(settings: RunSettings) -> Room:
    """Room of an experiment.

    Raises:
        MissingPackage: a robot comes from a package that is not installed.
    """
    return scenario_of(settings).room(settings)
