"""Who takes part in an experiment, and who of them keeps clear."""

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
        tasks: everybody who moves something, in the order in which they are asked; together they move every column of q once.
        guided: the arm that the person moves; the only one where one stands alone.
        avoiding: the arm whose joints and numbers are shown.
        task: task of that arm.
        held: task of the guided arm; None where one stands alone.
        paper: those who keep clear in the paper's experiment, the one whose numbers come first in the history first.
    """

    tasks: tuple[ArmTask, ...]
    guided: Arm
    avoiding: Arm
    task: ArmTask
    held: ArmTask | None
    paper: tuple[ArmTask, ...]

    def avoiders(self, choice: AvoidChoice) -> tuple[ArmTask, ...]:
        """Return who keeps clear."""
        if choice == "paper" or self.held is None:
            return self.paper
        return {"free": (self.task,), "guided": (self.held,), "both": (self.task, self.held)}[choice]


class TargetSource(Protocol):
    """Whoever moves what can be moved."""

    def target(self, time: float) -> Target | None:
        """Return what they want at a time [s], or None to leave everything alone."""
        ...


class NoSource:
    """Leaves everything alone."""

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
