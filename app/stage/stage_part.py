"""Parts of the 3-D view, and conversion of poses."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from typing import Final, TypeVar

import numpy as np
import pinocchio as pin
import viser

from app.session.frame import Frame
from app.settings import PageSettings
from controllers.kinematics import Array

KeepFree = Callable[[Array, tuple[float, float]], tuple[Array, bool]]

LABEL_TEXT: Final = (8.6, 18.0)
"""Width of a character and height of a label, at 1.15 times viser's font size [CSS px]."""


class StagePart(ABC):
    """A part of the 3-D view.

    Attributes:
        nodes: removed from the scene together.
        withheld: a question waits for its run; the drawing must hide the law's effect.
        keep_free: (place (3,) [m], label size [CSS px]) → place where the label is not clipped, and True if
            it was not clipped before; None if the picture is unknown.
    """

    nodes: Sequence[viser.SceneNodeHandle] = ()
    withheld: bool = False
    keep_free: KeepFree | None = None

    def dress(self, page: PageSettings) -> None:  # noqa: B027 (some look the same in every theme)
        """Apply a theme and a profile."""

    @abstractmethod
    def show(self, frame: Frame) -> None: ...

    def remove(self) -> None:
        for node in self.nodes:
            node.remove()


ROOM: Final = 2.5
"""Half the edge of the box of possible targets [m]."""

Node = TypeVar("Node", bound=viser.SceneNodeHandle)

Quaternion = tuple[float, float, float, float]
"""(w, x, y, z)"""


def quaternion(rotation: Array) -> Quaternion:
    turn = pin.Quaternion(rotation)
    return turn.w, turn.x, turn.y, turn.z


def in_room(position: Iterable[float]) -> Array:
    """A browser's valid position (3,), see `app.web.schemas`, clipped to the room."""
    return np.clip(np.array([*position], float), -ROOM, ROOM)


def rotation_of(wxyz: Iterable[float]) -> Array:
    """A browser's quaternion of about unit length as a rotation (3, 3)."""
    w, x, y, z = map(float, wxyz)
    return pin.Quaternion(w, x, y, z).normalized().toRotationMatrix()


def fresh(handle: Node) -> Node:
    """Send a new node's pose even if it is the default: otherwise it keeps, in the browser, that of a node of
    the same name removed in the same frame.
    """
    wxyz, position = np.array(handle.wxyz, float), np.array(handle.position, float)
    # Only changes are sent; of several in one frame the last one.
    handle.wxyz, handle.position = np.roll(wxyz, 1), position + 1.0
    handle.wxyz, handle.position = wxyz, position
    return handle
