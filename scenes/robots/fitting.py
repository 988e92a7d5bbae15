"""Collision meshes of an arm → a few capsules around them; links that only roll against each other share one."""

from typing import Final

import coal
import numpy as np
import pinocchio as pin
from scipy.spatial import ConvexHull

from controllers.kinematics import Array
from scenes.robots.description import Capsule, Robot, joint_axis
from scenes.robots.enclosing import enclosing_capsule
from scenes.robots.example_data import COLUMN_RADIUS, Example, load_example

TURNS: Final = 32
"""In how many steps a link is turned about its joint to find what it sweeps."""

BALL_POINTS: Final = 400
"""On a sphere that a capsule must contain."""

FINE: Final = 0.008
"""Longest edge of the triangles when a link is covered by two capsules [m]."""


def build_example(example: Example) -> Robot:
    """Return a robot of the package.

    Raises:
        BadSetting: the package is not installed, or not all of it.
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
                rolled = _beyond(_refined(rolled), segment.without)
            points.append(swept(model, rolled.reshape(-1, 3), segment.rolled, segment.joint))
        if segment.ball is not None:
            joint, radius = segment.ball
            points.append(data.oMi[segment.joint].actInv(data.oMi[joint]).translation + _sphere(radius))
        capsules.append(Capsule(segment.name, segment.joint, *enclosing_capsule(np.vstack(points))))
    return example.robot(model, tuple(capsules))


def link_triangles(shapes: pin.GeometryModel, joint: int) -> Array:
    """Return the corners (k, 3, 3) of the triangles of all shapes that move with a joint, in its frame [m]."""
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
    faces = [[triangle[0], triangle[1], triangle[2]] for triangle in map(shape.tri_indices, range(shape.num_tris))]
    return np.array(shape.vertices())[np.array(faces)]


def _refined(triangles: Array) -> Array:
    """Split triangles (k, 3, 3) in four until no edge is longer than FINE."""
    done = []
    while len(triangles):
        long = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1) > FINE
        done.append(triangles[~long])
        a, b, c = np.moveaxis(triangles[long], 1, 0)
        ab, bc, ca = (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0
        triangles = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return np.concatenate(done)


def _sphere(radius: float) -> Array:
    """Return points (k, 3) just outside a sphere about the origin, on a golden spiral; their hull contains it."""
    k = np.arange(BALL_POINTS)
    z, turn = 1.0 - (2.0 * k + 1.0) / BALL_POINTS, k * np.pi * (3.0 - np.sqrt(5.0))
    points = np.column_stack([np.sqrt(1.0 - z * z) * np.cos(turn), np.sqrt(1.0 - z * z) * np.sin(turn), z])
    # The planes of the hull's faces lie nearer than its corners.
    return points * (radius / -float(ConvexHull(points).equations[:, 3].max()))


def column_rim(height: float) -> Array:
    """Return points (k, 3) around the foot of a column under a base; their hull contains its lower rim."""
    angle = 2.0 * np.pi * np.arange(TURNS) / TURNS
    r = COLUMN_RADIUS / np.cos(np.pi / TURNS)
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), np.zeros(TURNS)])


def _beyond(triangles: Array, radius: float) -> Array:
    """Return the triangles that are not wholly inside a ball about the origin."""
    return triangles[np.linalg.norm(triangles, axis=2).max(axis=1) > radius]


def swept(model: pin.Model, points: Array, joint: int, carrier: int) -> Array:
    """Return points, in the frame of a neighbouring carrier, with a hull around all that a joint's link sweeps against it."""
    points = points[ConvexHull(points).vertices]
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
