"""What a person, the autopilot or a recording wants at one moment: one kind of wish for each thing that can be taken hold of; and
a person who goes straight from one waypoint to the next, whatever it is that is moved."""

from typing import Final, NamedTuple

import numpy as np

from controllers.kinematics import Array
from scenes.experiments import Moved


class HandTarget(NamedTuple):
    """Where the person wants the arm that they hold.

    Attributes:
        position: of the hand (3,), world [m].
        rotation: of the hand (3, 3), or None if the person does not care.
        elbow: where the person pulls the elbow (3,), world [m], or None.
    """

    position: Array
    rotation: Array | None = None
    elbow: Array | None = None


class JointTarget(NamedTuple):
    """Where the person wants the joints of the arm that they hold: positions (n,) [rad]."""

    positions: Array


class LinkTarget(NamedTuple):
    """Where the person pulls a point of a link of the arm that they hold.

    Attributes:
        joint: that the link turns with, counted from 1 along the arm.
        offset: of the point in the joint's frame (3,) [m].
        position: where the point is pulled to (3,), world [m].
    """

    joint: int
    offset: Array
    position: Array


class BallTarget(NamedTuple):
    """Where the person wants the ball: its middle (3,), world [m]."""

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
    """How a person holds their own arms.

    Attributes:
        angles: (2, 4), left arm first [rad], see `scenes.person.angles`; None while no person is seen.
    """

    angles: Array | None


HeldTarget = HandTarget | LinkTarget
"""What either of two people may want of the arm that they hold."""


class PairTarget(NamedTuple):
    """Where two people want one arm each.

    Attributes:
        first: of the one who has the guided arm; None while they hold nothing.
        second: of the one who has the arm that keeps its place.
    """

    first: HeldTarget | None
    second: HeldTarget


Target = HandTarget | JointTarget | LinkTarget | BallTarget | WallTarget | AnglesTarget | PairTarget


def quintic(s: float) -> tuple[float, float]:
    """Return the share of a way from rest to rest that is done at s in [0, 1] of its time, and its derivative by s."""
    return s * s * s * (10.0 + s * (6.0 * s - 15.0)), 30.0 * s * s * (1.0 - s) * (1.0 - s)


def between(times: Array, time: float) -> tuple[int, int, float]:
    """Return the samples before and after a time, and the share of the way from one to the other; beyond either end there is no way.

    Args:
        times: (k,) [s], strictly increasing.
    """
    i, last = max(int(np.searchsorted(times, time, side="right")) - 1, 0), len(times) - 1
    share = float((time - times[i]) / (times[i + 1] - times[i])) if i < last and time > times[i] else 0.0
    return i, min(i + 1, last), share


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
        """Target at a time [s]."""
        i, j, share = between(self._times, time)
        point = self._points[i] + (self._points[j] - self._points[i]) * share
        if self._moves == "person":
            return AnglesTarget(point.reshape(2, 4))
        return BallTarget(point) if self._moves == "ball" else HandTarget(point)
