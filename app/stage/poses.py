"""Poses between the browser and us: what it sends is kept in the room, and what it shows is written only when it differs."""

from collections.abc import Iterable
from typing import Final, TypeVar

import numpy as np
import pinocchio as pin
import viser

from controllers.kinematics import Array

ROOM: Final = 2.5
"""Half the edge of the box in which anything can be wanted [m]; whatever is dragged beyond counts as its edge."""

Node = TypeVar("Node", bound=viser.SceneNodeHandle)


def in_room(position: Iterable[float]) -> Array:
    """Return a place (3,) that a browser sent, inside the room; it is one, see `app.web.schemas`."""
    return np.clip(np.array([*position], float), -ROOM, ROOM)


def rotation_of(wxyz: Iterable[float]) -> Array:
    """Return a turn that a browser sent, a quaternion about as long as 1, as a rotation (3, 3)."""
    w, x, y, z = map(float, wxyz)
    return pin.Quaternion(w, x, y, z).normalized().toRotationMatrix()


def put(handle: viser.SceneNodeHandle, place: Array, rotation: Array | None = None) -> None:
    """Move a node, unless it is there already."""
    if np.abs(np.asarray(handle.position) - place).max() > 1e-5:
        handle.position = place
    if rotation is not None:
        turn = pin.Quaternion(rotation)
        wxyz = (turn.w, turn.x, turn.y, turn.z)
        if np.abs(np.asarray(handle.wxyz) - wxyz).max() > 1e-5:
            handle.wxyz = wxyz


def fresh(handle: Node) -> Node:
    """Return a node that was just made, after telling the browser its pose even if it is the usual one.

    A node that takes the name of one removed in the same frame would otherwise stand, in the browser, where that one stood.
    """
    wxyz, position = np.array(handle.wxyz, float), np.array(handle.position, float)
    # Only news is sent; of several pieces of news in one frame the last one.
    handle.wxyz, handle.position = np.roll(wxyz, 1), position + 1.0
    handle.wxyz, handle.position = wxyz, position
    return handle
