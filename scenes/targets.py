"""Targets at one moment, by what is held; and motion between waypoints."""

from typing import Final, Literal, NamedTuple

import numpy as np

from controllers.kinematics import Array
from scenes.experiments import Moved


class HandTarget(NamedTuple):
    """Target of the held arm's hand.

    Attributes:
        position: (3,), world [m].
        rotation: (3, 3), or None if free.
        elbow: its goal (3,), world [m], or None.
    """

    position: Array
    rotation: Array | None = None
    elbow: Array | None = None


class JointTarget(NamedTuple):
    """Positions (n,) of the held arm's joints [rad]."""

    positions: Array


class LinkTarget(NamedTuple):
    """Pull at a point of a link of the held arm.

    Attributes:
        joint: of the link, counted from 1 along the arm.
        offset: of the point in the joint's frame (3,) [m].
        position: its goal (3,), world [m].
    """

    joint: int
    offset: Array
    position: Array


class BallTarget(NamedTuple):
    """Middle of the ball (3,), world [m]."""

    position: Array


class WallTarget(NamedTuple):
    """Position of the wall's middle (3,), world [m]; turn about the vertical, and tilt (2,) [rad]."""

    position: Array
    turn: Array


class AnglesTarget(NamedTuple):
    """Angles of a person's arms (2, 4), left first [rad], see `scenes.person.angles`; None while no person is
    seen.
    """

    angles: Array | None


HeldTarget = HandTarget | LinkTarget


class PairTarget(NamedTuple):
    """Targets of two people, or of one with a wall in one hand.

    Attributes:
        first: for the guided arm or the wall, or None.
        second: for the arm that keeps its place.
    """

    first: HeldTarget | WallTarget | None
    second: HeldTarget


Target = HandTarget | JointTarget | LinkTarget | BallTarget | WallTarget | AnglesTarget | PairTarget


def quintic(s: float) -> tuple[float, float]:
    """Share of a way from rest to rest at s in [0, 1], and its derivative by s."""
    return s * s * s * (10.0 + s * (6.0 * s - 15.0)), 30.0 * s * s * (1.0 - s) * (1.0 - s)


def between(times: Array, time: float) -> tuple[int, int, float]:
    """Samples before and after a time, and the share of the way between them; 0 beyond either end.

    Args:
        times: (k,) [s], strictly increasing.
    """
    i, last = max(int(np.searchsorted(times, time, side="right")) - 1, 0), len(times) - 1
    share = float((time - times[i]) / (times[i + 1] - times[i])) if i < last and time > times[i] else 0.0
    return i, min(i + 1, last), share


Led = Moved | Literal["wall and hand"]

SIZES: Final[dict[Led, int]] = {"arm": 3, "ball": 3, "person": 8, "wall and hand": 8}
"""Coordinates of a waypoint: a position [m]; the angles of a person's arms [rad]; or a wall [m, rad] and a
hand [m].
"""

OF_WALL: Final = slice(0, 5)
OF_HAND: Final = slice(5, 8)

SHORTEST: Final = 0.05
"""Least time between two waypoints [s]."""


class Waypoints:
    """A `TargetSource` at a steady speed, at rest at the last waypoint.

    Args:
        points: (k, size), the first at time 0; see `SIZES`.
        speed: [m/s or rad/s]; of a wall and a hand that of the faster one.
    """

    def __init__(self, moves: Led, points: Array, speed: float) -> None:
        parts = (OF_WALL, OF_HAND) if moves == "wall and hand" else (slice(None),)
        steps = np.diff(points, axis=0)
        ways = np.max([np.linalg.norm(steps[:, part], axis=1) for part in parts], axis=0)
        self._times = np.concatenate([[0.0], np.cumsum(np.maximum(ways / speed, SHORTEST))])
        self._moves, self._points = moves, points

    def target(self, time: float) -> Target:
        i, j, share = between(self._times, time)
        point = self._points[i] + (self._points[j] - self._points[i]) * share
        if self._moves == "person":
            return AnglesTarget(point.reshape(2, 4))
        if self._moves == "wall and hand":
            at = point[OF_WALL]
            return PairTarget(WallTarget(at[:3], at[3:]), HandTarget(point[OF_HAND]))
        return BallTarget(point) if self._moves == "ball" else HandTarget(point)
