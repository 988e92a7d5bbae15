"""Points → the smallest capsule around them, for arms with meshes as collision shapes."""

from typing import Final

import numpy as np
from scipy.optimize import minimize
from scipy.spatial import ConvexHull

from controllers.kinematics import Array

GRID: Final = 0.001
"""Ends lie on a grid of this pitch and the radius is rounded up to it [m]: last bits of a search differ from machine to machine,
a robot's capsules should not."""

SHORTEST: Final = 0.010
"""Shortest axis [m]: Coal's capsules are happier with one, and a sphere is nearly a capsule as short as this."""

RESTARTS: Final = 2
"""How often a search starts again from where it stopped, with smaller steps."""


def enclosing_capsule(points: Array) -> tuple[Array, Array, float]:
    """Return both sphere centres (3,) and the radius of a capsule around points (k, 3) [m], of least volume as far as was found.

    For a given axis line, the radius that reaches the farthest point and the ends that then suffice follow directly, so only
    the four numbers of the line are searched for (Nelder & Mead 1965), from each principal axis of the points.
    """
    hull = points[ConvexHull(points).vertices]
    centre = (hull.min(axis=0) + hull.max(axis=0)) / 2.0
    principal = np.linalg.svd(hull - hull.mean(axis=0), full_matrices=False)[2]
    candidates = [_searched(hull, centre, axis) for axis in principal]
    start, end = min(candidates, key=lambda ends: _volume(hull, *ends))
    start, end = _lengthened(_on_grid(start), _on_grid(end))
    # The tiny slack keeps a radius that is a whole number of grid steps from being rounded up by its last bit.
    return start, end, float(np.ceil(_radius(hull, start, end) / GRID - 1e-6) * GRID)


def _on_grid(point: Array) -> Array:
    # Adding zero turns −0 into 0.
    return np.round(point / GRID) * GRID + 0.0


def _searched(points: Array, centre: Array, axis: Array) -> tuple[Array, Array]:
    """Return the ends of the best capsule near an axis line through a centre."""
    # Any vector that is not along the axis gives two directions across it.
    x = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    x /= np.linalg.norm(x)
    y = np.cross(axis, x)

    def ends(line: Array) -> tuple[Array, Array]:
        direction = axis + line[0] * x + line[1] * y
        return _shortest(points, centre + line[2] * x + line[3] * y, direction / np.linalg.norm(direction))

    line = np.zeros(4)
    for attempt in range(1 + RESTARTS):
        steps = np.diag([0.3, 0.3, 0.02, 0.02]) / (1 + 2 * attempt)
        line = minimize(
            lambda line: _volume(points, *ends(line)),
            line,
            method="Nelder-Mead",
            options={"initial_simplex": np.vstack([line, line + steps]), "maxiter": 400, "xatol": 2e-4, "fatol": 1e-8},
        ).x
    return ends(line)


def _shortest(points: Array, centre: Array, direction: Array) -> tuple[Array, Array]:
    """Return the ends of the shortest capsule around an axis line that is as thick as the points need."""
    away = points - centre
    along = away @ direction
    square = np.maximum(np.einsum("ij,ij->i", away, away) - along * along, 0.0)
    cap = np.sqrt(square.max() - square)
    low, high = float((along + cap).min()), float((along - cap).max())
    if low > high:
        low = high = (low + high) / 2.0
    return centre + low * direction, centre + high * direction


def _radius(points: Array, start: Array, end: Array) -> float:
    axis = end - start
    length = float(axis @ axis)
    share = np.minimum(np.maximum((points - start) @ axis / length, 0.0), 1.0) if length else np.zeros(len(points))
    return float(np.linalg.norm(points - start - share[:, None] * axis, axis=1).max())


def _volume(points: Array, start: Array, end: Array) -> float:
    r = _radius(points, start, end)
    return np.pi * r * r * (float(np.linalg.norm(end - start)) + 4.0 / 3.0 * r)


def _lengthened(start: Array, end: Array) -> tuple[Array, Array]:
    """Return ends at least SHORTEST apart; what was inside stays inside."""
    axis = end - start
    length = float(np.linalg.norm(axis))
    if length >= SHORTEST:
        return start, end
    direction = axis / length if length else np.array([0.0, 0.0, 1.0])
    return start, start + SHORTEST * direction
