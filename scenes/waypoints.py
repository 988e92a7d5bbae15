"""A person who goes straight from one waypoint to the next, whatever it is that the person moves in a scene."""

from typing import Final

import numpy as np

from controllers.kinematics import Array
from scenes.experiments import Moved
from scenes.targets import AnglesTarget, BallTarget, HandTarget, Target, between

SIZES: Final[dict[Moved, int]] = {"arm": 3, "ball": 3, "person": 8}
"""What is moved → how many numbers a waypoint has: a place [m], or the angles of both of a person's arms [rad]."""

SHORTEST: Final = 0.05
"""Time from one waypoint to the next at least [s]."""


class Waypoints:
    """A `TargetSource` through waypoints at a steady speed; at rest at the last one.

    Args:
        moves: what is moved.
        points: (k, size), from where it is at time 0; see `SIZES`.
        speed: [m/s or rad/s].
    """

    def __init__(self, moves: Moved, points: Array, speed: float) -> None:
        ways = np.linalg.norm(np.diff(points, axis=0), axis=1)
        self._times = np.concatenate([[0.0], np.cumsum(np.maximum(ways / speed, SHORTEST))])
        self._moves, self._points = moves, points

    def target(self, time: float) -> Target:
        """Return what is wanted at a time [s]."""
        i, j, share = between(self._times, time)
        point = self._points[i] + (self._points[j] - self._points[i]) * share
        if self._moves == "person":
            return AnglesTarget(point.reshape(2, 4))
        return BallTarget(point) if self._moves == "ball" else HandTarget(point)
