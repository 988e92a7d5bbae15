"""The motions of an arm that leave its hand where it is, to be gone along one by one."""

from typing import Final

import numpy as np

from controllers.kinematics import Arm, Array, Kinematics, null_space_basis, pseudo_inverse, swing_and_turns
from scenes.room import Room

MOTIONS: Final = 4
"""7 joints less 3 coordinates of the hand."""

STEP: Final = 0.01
"""Length of a step along a motion [rad]; the hand is put back after each."""

PUT_BACK: Final = 1e-3
"""Damping with which the hand is put back [m/rad]: next to a singular posture it may not make a leap."""


def has_null_motions(arm: Arm) -> bool:
    """Return whether an arm has four of them: the elbow's, and one for each axis about which the hand turns."""
    return arm.joints.stop - arm.joints.start == MOTIONS + 3


class NullMotions:
    """Goes along the four null-space motions of an arm of seven joints from a posture on.

    The basis is carried along from step to step, so that going back along a motion undoes it.

    Args:
        room: with the arm.
        arm: which.
        positions: q (nv,) to begin at [rad].

    Attributes:
        gone: how far it has gone along each motion (4,) [rad]; the length of the way in joint space.
    """

    def __init__(self, room: Room, arm: Arm, positions: Array) -> None:
        self._kinematics, self._arm = Kinematics(room.model, room.arms), arm
        self._positions = positions.copy()
        self._low, self._high = room.model.lowerPositionLimit[arm.joints], room.model.upperPositionLimit[arm.joints]
        self._kinematics.update(self._positions)
        self._hand = self._kinematics.hand_pose(arm).translation.copy()
        self.basis: Array = swing_and_turns(self._kinematics.hand_jacobian(arm))
        self.gone = np.zeros(MOTIONS)

    @property
    def joints(self) -> Array:
        """Return q of the arm (7,) [rad]."""
        return self._positions[self._arm.joints].copy()

    def go(self, motion: int, way: float) -> Array:
        """Go along a motion, from 0, to a way from where everything began [rad]; return q of the arm (7,) [rad].

        It ends earlier where a joint comes to its limit.
        """
        while abs(left := way - self.gone[motion]) > 1e-9 and self._step(motion, min(max(left, -STEP), STEP)):
            pass
        return self.joints

    def _step(self, motion: int, way: float) -> bool:
        """Make a step; return False, and make none, where a joint would pass its limit."""
        kinematics, arm, before = self._kinematics, self._arm, self.joints
        self._put(before + self.basis[:, motion] * way)
        error = self._hand - kinematics.hand_pose(arm).translation
        self._put(self.joints + pseudo_inverse(kinematics.hand_jacobian(arm, 3), PUT_BACK).dot(error))
        joints = self.joints
        if (joints < self._low).any() or (joints > self._high).any():
            self._put(before)
            return False
        self.basis = null_space_basis(kinematics.hand_jacobian(arm, 3), self.basis)
        self.gone[motion] += way
        return True

    def _put(self, joints: Array) -> None:
        self._positions[self._arm.joints] = joints
        self._kinematics.update(self._positions)
