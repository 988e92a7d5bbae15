"""The roles of an experiment: which task moves which arm, and which arms avoid."""

from dataclasses import dataclass
from typing import Protocol

from controllers.kinematics import Arm, Array
from scenes.arm_tasks.arm_task import ArmTask
from scenes.settings import AvoidChoice
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


class NoSource:
    """Never asks for anything."""

    def target(self, time: float) -> Target | None:
        """Return None."""
        del time


def mirror_signs(axes: Array) -> Array:
    """Return (n,) +1 for every joint that keeps its sign in a mirror between left and right, −1 for the others.

    Args:
        axes: (3, n) of the joints at q = 0 in the base's frame, where y points to the left. A mirror turns the sense of a rotation
            about an axis that lies in it.
    """
    return 1.0 - 2.0 * (abs(axes[1]) < 0.5)
