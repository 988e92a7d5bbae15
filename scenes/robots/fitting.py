"""Fits a few capsules around an arm's collision meshes."""

import contextlib
from typing import Final

import coal
import numpy as np
import pinocchio as pin
from scipy.optimize import minimize
from scipy.spatial import ConvexHull, QhullError

from controllers.kinematics import Array
from scenes.robots.description import Capsule, joint_axis
from scenes.robots.example_data import COLUMN_RADIUS, Example, load_example

TURNS: Final = 32

BALL_POINTS: Final = 400

FLAT: Final = 1e-9
"""Relative spread of points that is only rounding."""

FINE: Final = 0.008
"""Longest triangle edge of a link in two capsules [m]."""


def fit_example(example: Example) -> tuple[Capsule, ...]:
    """Capsules of a robot of the package.

    Raises:
        BadSetting: as `load_example`.
    """
    model, collision = load_example(example, pin.GeometryType.COLLISION)
    shapes = [link_triangles(collision, joint) for joint in range(model.njoints)]
    data = model.createData()
    pin.forwardKinematics(model, data, pin.neutral(model))
    capsules = []
    for segment in example.segments:
        points = [shapes[segment.joint].reshape(-1, 3)]
        if segment.joint == 0 and example.column:
            points.append(column_rim(example.column))
        if segment.rolled is not None:
            rolled = shapes[segment.rolled]
            if segment.without:
                fine = _refined(rolled)
                rolled = fine[np.linalg.norm(fine, axis=2).max(axis=1) > segment.without]
            points.append(swept(model, rolled.reshape(-1, 3), segment.rolled, segment.joint))
        if segment.ball is not None:
            joint, radius = segment.ball
            points.append(data.oMi[segment.joint].actInv(data.oMi[joint]).translation + _sphere(radius))
        capsules.append(Capsule(segment.name, segment.joint, *enclosing_capsule(np.vstack(points))))
    return tuple(capsules)


def link_triangles(shapes: pin.GeometryModel, joint: int) -> Array:
    """Triangles (k, 3, 3) that move with a joint, in its frame [m]."""
    found = [np.zeros((0, 3, 3))]
    for body in shapes.geometryObjects:
        if body.parentJoint == joint:
            corners = _triangles(body.geometry)
            found.append(corners @ body.placement.rotation.T + body.placement.translation)
    return np.concatenate(found)


def _triangles(shape: coal.CollisionGeometry) -> Array:
    if isinstance(shape, coal.Box):
        corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * shape.halfSide
        return corners[ConvexHull(corners).simplices]
    faces = [
        [triangle[0], triangle[1], triangle[2]] for triangle in map(shape.tri_indices, range(shape.num_tris))
    ]
    return np.array(shape.vertices())[np.array(faces)]


def _refined(triangles: Array) -> Array:
    done = []
    while len(triangles):
        long = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1) > FINE
        done.append(triangles[~long])
        a, b, c = np.moveaxis(triangles[long], 1, 0)
        ab, bc, ca = (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0
        triangles = np.concatenate(
            [np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        )
    return np.concatenate(done)


def _sphere(radius: float) -> Array:
    """Points (k, 3) whose hull contains a sphere about the origin."""
    k = np.arange(BALL_POINTS)
    z, turn = 1.0 - (2.0 * k + 1.0) / BALL_POINTS, k * np.pi * (3.0 - np.sqrt(5.0))
    points = np.column_stack([np.sqrt(1.0 - z * z) * np.cos(turn), np.sqrt(1.0 - z * z) * np.sin(turn), z])
    # The planes of the hull's faces lie nearer than its corners.
    return points * (radius / -float(ConvexHull(points).equations[:, 3].max()))


def column_rim(height: float) -> Array:
    """Points (k, 3) whose hull contains the lower rim of a column."""
    angle = 2.0 * np.pi * np.arange(TURNS) / TURNS
    r = COLUMN_RADIUS / np.cos(np.pi / TURNS)
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), np.zeros(TURNS)])


def hull_corners(points: Array) -> Array:
    """Corners (k, 3) of the convex hull of points (n, 3), also coplanar, collinear or equal ones."""
    try:
        return points[ConvexHull(points).vertices]
    except (QhullError, ValueError):
        pass
    # Qhull does not take what is flat: drop the directions in which the points do not spread.
    away = points - points.mean(axis=0)
    _, spread, directions = np.linalg.svd(away, full_matrices=False)
    for kept in range(min(2, int((spread > FLAT * max(float(spread[0]), 1e-9)).sum())), 0, -1):
        flat = away @ directions[:kept].T
        if kept == 1:
            return points[[int(flat[:, 0].argmin()), int(flat[:, 0].argmax())]]
        with contextlib.suppress(QhullError, ValueError):
            return points[ConvexHull(flat).vertices]
    return points[:1]


def swept(model: pin.Model, points: Array, joint: int, carrier: int) -> Array:
    """Points in a neighbouring carrier's frame whose hull contains the swept volume of a joint's link."""
    points = hull_corners(points)
    turning = max(joint, carrier)
    placement = model.jointPlacements[turning]
    axis = joint_axis(model, turning)
    angles = 2.0 * np.pi * np.arange(TURNS) / TURNS
    if carrier == turning:
        points = (points - placement.translation) @ placement.rotation
    along = np.outer(points @ axis, axis)
    points = along + (points - along) / np.cos(np.pi / TURNS)
    turned = np.concatenate([points @ pin.exp3(axis * angle).T for angle in angles])
    return turned if carrier == turning else turned @ placement.rotation.T + placement.translation


GRID: Final = 0.001
"""Pitch of ends and radii [m]: the last bits of a search differ between machines."""

SHORTEST: Final = 0.010
"""Shortest axis [m]: Coal prefers one to a sphere."""

RESTARTS: Final = 2


def enclosing_capsule(points: Array) -> tuple[Array, Array, float]:
    """Sphere centres (3,) and radius of a capsule around points (k, 3) [m], of the least volume found.

    Radius and ends follow from the axis line, whose four numbers are searched for (Nelder & Mead 1965), from
    each principal axis.
    """
    hull = hull_corners(points)
    centre = (hull.min(axis=0) + hull.max(axis=0)) / 2.0
    principal = np.linalg.svd(hull - hull.mean(axis=0), full_matrices=False)[2]
    candidates = [_searched(hull, centre, axis) for axis in principal]
    best = min(candidates, key=lambda ends: _volume(hull, *ends))
    # Adding zero turns −0 into 0.
    start, end = (np.round(point / GRID) * GRID + 0.0 for point in best)
    length = float(np.linalg.norm(end - start))
    if length < SHORTEST:
        # What was inside stays inside.
        end = start + SHORTEST * ((end - start) / length if length else np.array([0.0, 0.0, 1.0]))
    # The tiny slack keeps a radius that is a whole number of grid steps from being rounded up by its last bit.
    return start, end, float(np.ceil(_radius(hull, start, end) / GRID - 1e-6) * GRID)


def _searched(points: Array, centre: Array, axis: Array) -> tuple[Array, Array]:
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
            options={
                "initial_simplex": np.vstack([line, line + steps]),
                "maxiter": 400,
                "xatol": 2e-4,
                "fatol": 1e-8,
            },
        ).x
    return ends(line)


def _shortest(points: Array, centre: Array, direction: Array) -> tuple[Array, Array]:
    """Ends of the shortest capsule about an axis line, as thick as the points need."""
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
    share = (
        np.minimum(np.maximum((points - start) @ axis / length, 0.0), 1.0)
        if length
        else np.zeros(len(points))
    )
    return float(np.linalg.norm(points - start - share[:, None] * axis, axis=1).max())


def _volume(points: Array, start: Array, end: Array) -> float:
    r = _radius(points, start, end)
    return np.pi * r * r * (float(np.linalg.norm(end - start)) + 4.0 / 3.0 * r)
