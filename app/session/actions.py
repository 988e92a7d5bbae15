"""What a visitor can ask for with a key, a control or a handle, as typed values; each is done on the session's thread."""

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Literal

from controllers.kinematics import Array
from scenes.settings import SceneName


@dataclass(frozen=True)
class Pause:
    """Pause, or go on."""


@dataclass(frozen=True)
class SingleStep:
    """Pause, and make one step."""


@dataclass(frozen=True)
class Reset:
    """Start the run from its beginning."""


@dataclass(frozen=True)
class ChangeSpeed:
    """Take the next slower (−1) or faster (+1) speed."""

    by: Literal[-1, 1]


@dataclass(frozen=True)
class SetSetting:
    """Set one setting, named by its key."""

    key: str
    value: object


@dataclass(frozen=True)
class ChooseScene:
    """Change to another experiment; in a lesson, choose the answer of its number."""

    scene: SceneName


@dataclass(frozen=True)
class MoveJoint:
    """Hold the guided arm with one joint, counted from 0, at an angle [rad]."""

    joint: int
    angle: float


@dataclass(frozen=True, eq=False)
class Drag:
    """Pull at a handle of the stage.

    Attributes:
        handle: its name, or that of the node of the stage.
        phase: "start", "update" or "end".
        place: where it is pulled to (3,) [m]; None where the browser sent nothing possible.
        turn: how it is turned (3, 3); None where it cannot be, or as above.
        taken: where the mouse took hold of it (3,) [m]; None where that does not matter.
    """

    handle: str
    phase: str
    place: Array | None = None
    turn: Array | None = None
    taken: Array | None = None


@dataclass(frozen=True)
class Toggle:
    """Switch the autopilot, the avoidance, the ghost, the arrows or what the scene shows of λ on or off."""

    what: Literal["autopilot", "avoidance", "ghost", "gizmo", "contact"]


@dataclass(frozen=True)
class Hover:
    """Show the arrows on the hand or the ball while the pointer is there, or no more."""

    on: bool


@dataclass(frozen=True)
class Nudge:
    """Move the hand or the ball by one step along each axis of the visitor's view."""

    right: int = 0
    up: int = 0
    away: int = 0


@dataclass(frozen=True)
class SwingElbow:
    """Swing the elbow by one step to one side (+1) or the other (−1)."""

    sign: Literal[-1, 1]


@dataclass(frozen=True)
class FirstView:
    """Point the visitor's camera as at the start."""


Action = (
    Pause
    | SingleStep
    | Reset
    | ChangeSpeed
    | SetSetting
    | ChooseScene
    | MoveJoint
    | Drag
    | Toggle
    | Hover
    | Nudge
    | SwingElbow
    | FirstView
)


def control_of(action: Action) -> Hashable:
    """Return the control on which this action replaces an older one while both wait; None where every press counts."""
    match action:
        case SetSetting(key):
            return key
        case ChooseScene():
            return "scene"
        case MoveJoint(joint):
            return "joint", joint
        case Drag(handle, phase):
            return handle, phase
        case Reset() | FirstView() | Hover():
            return type(action)
        case _:
            return None
