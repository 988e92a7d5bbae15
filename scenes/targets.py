"""Targets of a person, the autopilot or a recording at one moment, one type for each thing that can be held;
and a person who moves straight between waypoints.
"""

from typing import Final, Literal, NamedTuple

import numpy as np

from controllers.kinematics import Array
from scenes.experiments import Moved


class HandTarget(NamedTuple):
    """Target of the held arm's hand.

    Attributes:
        position: of the hand (3,), world [m].
        rotation: of the hand (3, 3), or None if it is free.
        elbow: point to which the elbow is pulled (3,), world [m], or None.
    """

    position: Array
    rotation: Array | None = None
    elbow: Array | None = None


class JointTarget(NamedTuple):
    """Target of the held arm's joints: positions (n,) [rad]."""

    positions: Array


class LinkTarget(NamedTuple):
    """Target of a point of a link of the held arm.

    Attributes:
        joint: joint of the link, counted from 1 along the arm.
        offset: of the point in the joint's frame (3,) [m].
        position: to which it is pulled (3,), world [m].
    """

    joint: int
    offset: Array
    position: Array


class BallTarget(NamedTuple):
    """Target of the ball's middle (3,), world [m]."""

    position: Array


class WallTarget(NamedTuple):
    """Where the person wants the wall.

    Attributes:
        position: of its middle (3,), world [m].
        turn: about the upright, and tilt (2,) [rad].
    """

    position: Array
    turn: Array


class AnglesTarget(NamedTuple):
    """Posture of a person's own arms.

    Attributes:
        angles: (2, 4), left arm first [rad], see `scenes.person.angles`; None while no person is seen.
    """

    angles: Array | None


HeldTarget = HandTarget | LinkTarget


class PairTarget(NamedTuple):
    """Targets of two people with one arm each.

    Attributes:
        first: for the guided arm, or None.
        second: for the arm that keeps its place.
    """

    first: HeldTarget | None
    second: HeldTarget


Target = HandTarget | JointTarget | LinkTarget | BallTarget | WallTarget | AnglesTarget | PairTarget


def quintic(s: float) -> tuple[float, float]:
    """Share of a way from rest to rest at s in [0, 1] of its time, and its derivative by s."""
    return s * s * s * (10.0 + s * (6.0 * s - 15.0)), 30.0 * s * s * (1.0 - s) * (1.0 - s)


def between(times: Array, time: float) -> tuple[int, int, float]:
    """Samples before and after a time, and the share of the way between them; 0 beyond either end.

    Args:
        times: (k,) [s], strictly increasing.
    """
    i, last = max(int(np.searchsorted(times, time, side="right")) - 1, 0), len(times) - 1
    share = float((time - times[i]) / (times[i + 1] - times[i])) if i < last and time > times[i] else 0.0
    return i, min(i + 1, last), share


SIZES: Final[dict[Moved | Literal["wall"], int]] = {"arm": 3, "ball": 3, "person": 8, "wall": 5}
"""Moved thing → number of coordinates of a waypoint: a position [m], the angles of both arms of a person [rad],
or a wall's position [m], turn and tilt [rad].
"""

SHORTEST: Final = 0.05
"""Least time between two waypoints [s]."""


class Waypoints:
    """A `TargetSource` through waypoints at a steady speed; at rest at the last one.

    Args:
        points: (k, size), from its place at time 0; see `SIZES`.
        speed: [m/s or rad/s].
    """

    def __init__(self, moves: Moved | Literal["wall"], points: Array, speed: float) -> None:
        ways = np.linalg.norm(np.diff(points, axis=0), axis=1)
        self._times = np.concatenate([[0.0], np.cumsum(np.maximum(ways / speed, SHORTEST))])
        self._moves, self._points = moves, points

    def target(self, time: float) -> Target:
        i, j, share = between(self._times, time)
        point = self._points[i] + (self._points[j] - self._points[i]) * share
        if self._moves == "person":
            return AnglesTarget(point.reshape(2, 4))
        if self._moves == "wall":
            return WallTarget(point[:3], point[3:])
        return BallTarget(point) if self._moves == "ball" else HandTarget(point)
