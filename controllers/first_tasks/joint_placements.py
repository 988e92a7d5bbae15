"""Placements of some joints as one array that a loop reads."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
import pinocchio as pin

from controllers.kinematics import Array, Kinematics


class Moved(Protocol):
    """Anything that some columns of q move."""

    @property
    def joints(self) -> slice:
        """Its columns in q."""
        ...


class JointPlacements:
    """Placements of some joints of an arm.

    Args:
        joints: ids in the model.

    Attributes:
        moving: number of the arm's joints that move each of them (k,).
    """

    def __init__(self, kinematics: Kinematics, arm: Moved, joints: Sequence[int]) -> None:
        first = arm.joints.start
        self.moving = np.array(
            [kinematics.model.joints[joint].idx_v - first + 1 for joint in joints], np.int64
        )
        # Live views of Pinocchio's memory; its matrices are stored by columns.
        placed = [kinematics.data.oMi[joint] for joint in joints]
        self._views = [view for M in placed for view in (M.rotation.T.reshape(-1), M.translation)]
        self._read = np.empty((len(joints), 12))
        self._live = one_view(placed)

    def read(self) -> Array:
        """Rotation by columns, then origin [m], of each joint, world (k, 12); reused."""
        if self._live is not None:
            return self._live
        np.concatenate(self._views, out=self._read.reshape(-1))
        return self._read


def one_view(placed: Sequence[pin.SE3]) -> Array | None:
    """Rotation by columns, then origin [m], as one live view (k, 12).

    None unless the placements are adjacent in Pinocchio's memory, like those of adjacent joints.
    """
    parts = [part.__array_interface__["data"][0] for M in placed for part in (M.rotation, M.translation)]
    if not parts or parts != [parts[0] + 96 * i + offset for i in range(len(placed)) for offset in (0, 72)]:
        return None
    return np.lib.stride_tricks.as_strided(placed[0].rotation.T.reshape(-1), (len(placed), 12), (96, 8))
