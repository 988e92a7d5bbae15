"""A person without a camera."""

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.linalg import norm

from controllers.kinematics import Array
from scenes.person.angles import (
    FOREARM,
    SIGN,
    UPPER_ARM,
    arm_directions,
    arm_points,
    arm_rotation,
    direction_angles,
)
from scenes.person.clips import REST
from scenes.settings import ArmName

MOST_BENT: Final = float(np.radians(150.0))
"""Largest elbow angle [rad]."""

TRUSTED_SINE: Final = 1e-3
"""So small that a dragged hand holds the point exactly."""


SETTLING: Final = 4
"""Corrections of the wrist for the forearm's turn."""


class Grasp(NamedTuple):
    """Grasped point of an arm.

    Attributes:
        forearm: True beyond the forearm's middle.
        along: beyond the wrist, along the forearm [m].
        aside: off the bone's axis (3,), or off the elbow [m].
    """

    side: ArmName
    forearm: bool
    along: float
    aside: Array


class Figure:
    """A figure with draggable wrists and elbows; a `PersonSource`. Points are in the torso frame.

    Args:
        start: angles (2, 4) [rad].
    """

    def __init__(self, start: Array = REST) -> None:
        self._start = start.copy()
        self.reset()

    def reset(self) -> None:
        self._angles = dict(zip(SIGN, self._start, strict=True))

    def angles(self, time: float = 0.0) -> Array:
        return np.array(list(self._angles.values()))

    def points(self, side: ArmName) -> tuple[Array, Array, Array]:
        return arm_points(self._angles[side], side)

    def drag_wrist(self, side: ArmName, point: Array) -> None:
        """Move a wrist to a finite point (3,) [m], or as near as the arm reaches, with the least swivel of
        the elbow.
        """
        shoulder, elbow, wrist = self.points(side)
        a, b = UPPER_ARM, FOREARM
        way = np.asarray(point, float) - shoulder
        distance = norm(way)
        if not math.isfinite(distance):
            return
        if distance < 1e-6:
            way, distance = wrist - shoulder, norm(wrist - shoulder)
        toward = way / distance
        reach = min(max(distance, math.sqrt(a * a + b * b + 2.0 * a * b * math.cos(MOST_BENT))), a + b)
        along = (a * a + reach * reach - b * b) / (2.0 * reach)
        out = _across(elbow - shoulder, toward, 1e-3 * a)
        if out is None:
            # A straight elbow bends with the forearm going to the arm's own x, so the elbow itself goes the other way. That x is
            # square to the upper arm, which lies along `toward` here.
            out = _across(-arm_rotation(self._angles[side], side)[:, 0], toward, 0.0)
        assert out is not None
        bent = shoulder + along * toward + math.sqrt(max(a * a - along * along, 0.0)) * out
        self._take(side, bent - shoulder, shoulder + reach * toward - bent)

    def drag_elbow(self, side: ArmName, point: Array) -> None:
        """Point the upper arm at a finite point (3,) [m] off the shoulder; the forearm keeps its direction if
        possible.
        """
        shoulder, _, _ = self.points(side)
        way = np.asarray(point, float) - shoulder
        distance = norm(way)
        if not 1e-6 < distance < math.inf:
            return
        upper = way / distance
        before, forearm = arm_directions(self._angles[side], side)
        if float(upper @ forearm) < math.cos(MOST_BENT):
            out = _across(forearm, upper, 1e-6)
            if out is None:
                out = _across(-before, upper, 0.0)
            if out is None:
                return
            forearm = math.cos(MOST_BENT) * upper + math.sin(MOST_BENT) * out
        self._take(side, upper, forearm)

    def grasp(self, side: ArmName, forearm: bool, point: Array) -> Grasp:
        """Grasp at a point (3,) [m]; a forearm near its elbow is held at the elbow."""
        shoulder, elbow, wrist = self.points(side)
        if not forearm:
            upper = (elbow - shoulder) / UPPER_ARM
            way = point - shoulder
            return Grasp(side, False, 0.0, way - upper * float(upper @ way))
        axis = (wrist - elbow) / FOREARM
        way = point - wrist
        along = float(axis @ way)
        if along < -0.5 * FOREARM:
            return Grasp(side, False, 0.0, point - elbow)
        return Grasp(side, True, along, way - axis * along)

    def pull(self, grasp: Grasp, point: Array) -> None:
        """Move the grasped point to a point (3,) [m], or as near as the arm reaches."""
        goal = np.asarray(point, float) - grasp.aside
        if not grasp.forearm:
            self.drag_elbow(grasp.side, goal)
            return
        for _ in range(SETTLING):
            _, elbow, wrist = self.points(grasp.side)
            self.drag_wrist(grasp.side, goal - (wrist - elbow) * (grasp.along / FOREARM))

    def _take(self, side: ArmName, upper: Array, forearm: Array) -> None:
        upper, forearm = upper / norm(upper), forearm / norm(forearm)
        self._angles[side] = direction_angles(upper, forearm, side, self._angles[side], TRUSTED_SINE)


def _across(vector: Array, axis: Array, least: float) -> Array | None:
    """Unit vector of the part normal to a unit axis; None if that is not longer than `least`."""
    rest = vector - float(vector @ axis) * axis
    length = norm(rest)
    return rest / length if length > least else None
