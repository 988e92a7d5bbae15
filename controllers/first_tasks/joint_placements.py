"""Placements of some joints as one array that a loop reads."""

from collections.abc import Sequence

import numpy as np

from controllers.kinematics import Arm, Array, Kinematics


class JointPlacements:
    """Placements of some joints of an arm.

    Args:
        kinematics: of all arms.
        arm: with these joints.
        joints: ids of joints of the model.

    Attributes:
        moving: number of the arm's joints that move each of them (k,).
    """

    def __init__(self, kinematics: Kinematics, arm: Arm, joints: Sequence[int]) -> None:
        first = arm.joints.start
        self.moving = np.array([kinematics.model.joints[joint].idx_v - first + 1 for joint in joints], np.int64)
        # Live views of Pinocchio's memory; its matrices are stored by columns.
        placed = [kinematics.data.oMi[joint] for joint in joints]
        self._views = [view for M in placed for view in (M.rotation.T.reshape(-1), M.translation)]
        self._read = np.empty((len(joints), 12))

    def read(self) -> Array:
        """Rotation by columns, then origin [m], of each joint in the world (k, 12); the array is reused."""
        np.concatenate(self._views, out=self._read.reshape(-1))
        return self._read
