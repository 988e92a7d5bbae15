"""What an experiment is made of, and its roles: which task moves which arm, and which arms avoid."""

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
    """The roles of an experiment.

    Attributes:
        tasks: all tasks, in the order of evaluation; together they move every column of q once.
        guided: the arm that the person moves; the only one in a room with one arm.
        avoiding: the arm that the plots and numbers show.
        task: of that arm.
        held: task of the guided arm; None in a room with one arm.
        paper: the tasks that avoid in the paper's experiment, in the order of their columns in the history.
    """

    tasks: tuple[ArmTask, ...]
    guided: Arm
    avoiding: Arm
    task: ArmTask
    held: ArmTask | None
    paper: tuple[ArmTask, ...]

    def avoiders(self, choice: AvoidChoice) -> tuple[ArmTask, ...]:
        """Return the tasks that avoid."""
        if choice == "paper" or self.held is None:
            return self.paper
        return {"free": (self.task,), "guided": (self.held,), "both": (self.task, self.held)}[choice]


class TargetSource(Protocol):
    """A source of targets: a script, a person, a recording."""

    def target(self, time: float) -> Target | None:
        """Return the target at a time [s], or None for no change."""
        ...


@dataclass(frozen=True)
class Scripted:
    """A person with a target that is a function of time [s]."""

    motion: Callable[[float], Target | None]

    def target(self, time: float) -> Target | None:
        """Target at a time [s]."""
        return self.motion(time)


NO_TARGETS: Final = Scripted(lambda _: None)
"""Never asks for anything."""


def paced(source: TargetSource, factor: float) -> Scripted:
    """Person who does the same as another one, but `factor` times as fast."""
    return Scripted(lambda time: source.target(factor * time))


class Scenario:
    """What an experiment is made of: where it takes place, who does what, and who moves what can be moved."""

    def room(self, settings: RunSettings) -> Room:
        """Return the room."""
        raise NotImplementedError

    def roles(self, world: World, settings: RunSettings) -> Roles:
        """Return the roles."""
        raise NotImplementedError

    def source(self, world: World, settings: RunSettings) -> TargetSource:
        """Return the default source of targets, used while the visitor moves nothing. `world`: as it stands now."""
        return NO_TARGETS

    def opening(self, world: World, settings: RunSettings) -> TargetSource | None:
        """Source for the start of a page that nothing else was asked of; None if the experiment begins like any other time."""
        return None

    def stages(self, world: World, settings: RunSettings) -> tuple[RowStage, ...]:
        """Further first tasks of the arm that avoids, each with priority over the law and over those before it."""
        return ()

    def problem(self, world: World, settings: RunSettings) -> BadSetting | None:
        """Reason for which the settings cannot be kept from the start on, with its remedy; None if they can."""
        return None

    def way(self, settings: RunSettings, home: Array) -> Array:
        """Return points (k, 3) of the way that the task prescribes to the hand [m]; (0, 3) if it does not. `home`: where it begins."""
        return np.zeros((0, 3))


def scenario_of(settings: RunSettings) -> Scenario:
    """Scenario of the experiment that the settings name."""
    scenario: Scenario = resolve_name(f"scenes.{settings.experiment.made_by}")()
    return scenario


def room_of(settings: RunSettings) -> Room:
    """Room of the experiment that the settings name.

    Raises:
        MissingPackage: a robot comes from a package that is not installed.
    """
    return scenario_of(settings).room(settings)
