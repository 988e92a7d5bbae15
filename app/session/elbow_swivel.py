"""The elbow's angle about the line from shoulder to wrist: the freedom that is left when the hand stays where it is."""

import math

import numpy as np
import pinocchio as pin

from controllers.kinematics import Arm, Array
from scenes.room import Room


class Swivel:
    """Measures the angle of one arm's elbow, at any posture.

    Args:
        room: with the arm.
        arm: which.
    """

    def __init__(self, room: Room, arm: Arm) -> None:
        self._model, self._data, self._arm = room.model, room.model.createData(), arm
        self._last = math.nan

    def angle(self, positions: Array) -> float:
        """Return the angle at q (nv,) [rad], 0 where the elbow points straight up; without jumps from one call to the next.

        nan while the arm is straight, or reaches straight up: the elbow then points nowhere, or there is no "up" across the line.
        """
        pin.forwardKinematics(self._model, self._data, positions)
        shoulder, elbow, wrist = (
            self._data.oMi[joint].translation for joint in (self._arm.shoulder, self._arm.elbow, self._arm.wrist)
        )
        way = wrist - shoulder
        way /= math.sqrt(float(way.dot(way))) or 1.0
        out = elbow - shoulder
        out -= way * float(way.dot(out))
        up = np.array([0.0, 0.0, 1.0]) - way * float(way[2])
        if float(out.dot(out)) < 1e-8 or float(up.dot(up)) < 1e-8:
            return math.nan
        x, y, z = way.tolist()
        across = np.array([y * up[2] - z * up[1], z * up[0] - x * up[2], x * up[1] - y * up[0]])
        angle = math.atan2(float(out.dot(across)), float(out.dot(up)))
        if self._last == self._last:
            angle += 2.0 * math.pi * round((self._last - angle) / (2.0 * math.pi))
        self._last = angle
        return angle
