"""What the parts of the stage have in common: how a part is drawn, and poses: what viser takes, and what a browser sends, which is kept in
the room."""

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
"""See `StagePart`."""

LABEL_TEXT: Final = (8.6, 18.0)
"""Width of a character and height of a label in the scene, at 1.15 times viser's font size [CSS px]."""


class StagePart(ABC):
    """Something on the stage, drawn in the scene that it is made with.

    Attributes:
        nodes: what is drawn, and taken out of the scene together.
        withheld: true while a question waits for its run, so that nothing drawn says what the law does.
        keep_free: (place (3,) [m], width and height of a label [CSS px]) → where the label is not cut, and whether it is not
            cut where it was; None where the picture is not known.
    """

    nodes: Sequence[viser.SceneNodeHandle] = ()
    withheld: bool = False
    keep_free: KeepFree | None = None

    def dress(self, page: PageSettings) -> None:  # noqa: B027 (some look the same in every theme)
        """Take on a theme and a profile."""

    @abstractmethod
    def show(self, frame: Frame) -> None:
        """Draw a frame."""

    def remove(self) -> None:
        """Take it out of the scene."""
        for node in self.nodes:
            node.remove()


ROOM: Final = 2.5
"""Half the edge of the box in which anything can be wanted [m]; whatever is dragged beyond counts as its edge."""

Node = TypeVar("Node", bound=viser.SceneNodeHandle)

Quaternion = tuple[float, float, float, float]
"""(w, x, y, z)"""


def quaternion(rotation: Array) -> Quaternion:
    """Return a rotation (3, 3) as viser takes it."""
    turn = pin.Quaternion(rotation)
    return turn.w, turn.x, turn.y, turn.z


def in_room(position: Iterable[float]) -> Array:
    """Return a place (3,) that a browser sent, inside the room; it is one, see `app.web.schemas`."""
    return np.clip(np.array([*position], float), -ROOM, ROOM)


def rotation_of(wxyz: Iterable[float]) -> Array:
    """Return a turn that a browser sent, a quaternion about as long as 1, as a rotation (3, 3)."""
    w, x, y, z = map(float, wxyz)
    return pin.Quaternion(w, x, y, z).normalized().toRotationMatrix()


def fresh(handle: Node) -> Node:
    """Return a node that was just made, after telling the browser its pose even if it is the usual one.

    A node that takes the name of one removed in the same frame would otherwise stand, in the browser, where that one stood.
    """
    wxyz, position = np.array(handle.wxyz, float), np.array(handle.position, float)
    # Only news is sent; of several pieces of news in one frame the last one.
    handle.wxyz, handle.position = np.roll(wxyz, 1), position + 1.0
    handle.wxyz, handle.position = wxyz, position
    return handle
