"""The nearest camera from which every ball of a set is seen inside its rectangle of the picture, and the projection of a point."""

import math
from typing import Final, NamedTuple

import numpy as np

from controllers.kinematics import Array

NEAREST: Final = 0.3
"""No ball comes nearer to the eye than this [m]."""


class Pose(NamedTuple):
    """Of a camera that stands upright: eye and the point that it looks at (3,) [m], and the vertical angle of view [rad]."""

    eye: Array
    look_at: Array
    fov: float


class Balls(NamedTuple):
    """What is to be seen in one part of the picture.

    Attributes:
        centres: (k, 3) [m].
        radii: (k,) [m].
        part: left, top, right, bottom of a rectangle [px], from the picture's top left corner.
    """

    centres: Array
    radii: Array
    part: tuple[float, float, float, float]


def axes(toward: Array) -> tuple[Array, Array, Array]:
    """Return which way is right, up and towards the eye, as unit vectors (3,). `toward`: any length, not upright."""
    x, y, z = (float(part) for part in toward)
    length, across = math.sqrt(x * x + y * y + z * z), math.hypot(x, y)
    x, y, z, right, ahead = x / length, y / length, z / length, -y / across, x / across
    return np.array([right, ahead, 0.0]), np.array([-z * ahead, z * right, x * ahead - y * right]), np.array([x, y, z])


def fit(toward: Array, fov: float, size: tuple[float, float], groups: tuple[Balls, ...]) -> Pose:
    """Return the nearest camera that looks along −toward and has every ball inside its part; the rest of the room is shared evenly.

    A camera that may only be shifted sees x at f (x − c_x) / (c_z − z) px from the middle: that this lies between two bounds is linear
    in c, so that the least c_z for which all agree on a c_x, and on a c_y, is the largest over pairs of bounds.

    Args:
        toward: from what is seen to the eye (3,).
        fov: vertical angle of view [rad].
        size: width and height of the picture [px].
        groups: at least one with a ball.
    """
    right, up, back = axes(np.asarray(toward, float))
    centres, radii = (
        np.concatenate([np.asarray(part, float) for part in parts]) for parts in list(zip(*groups, strict=True))[:2]
    )
    parts = np.repeat([group.part for group in groups], [len(group.centres) for group in groups], axis=0)
    tangents = (
        np.tan(fov / 2.0)
        * 2.0
        / size[1]
        * np.stack(
            [parts[:, 0] - size[0] / 2.0, parts[:, 2] - size[0] / 2.0, size[1] / 2.0 - parts[:, 3], size[1] / 2.0 - parts[:, 1]]
        )
    )
    depth = centres @ back
    sideways = [(centres @ right, tangents[0], tangents[1]), (centres @ up, tangents[2], tangents[3])]
    away = float((depth + radii).max()) + NEAREST
    for place, low, high in sideways:
        # place − high (c_z − depth) ≤ c ≤ place − low (c_z − depth), for every ball.
        least, most = place + radii + high * depth, place - radii + low * depth
        away = max(away, float(((least[:, None] - most[None, :]) / (high[:, None] - low[None, :])).max()))
    middle = [
        (float((place + radii - high * (away - depth)).max()) + float((place - radii - low * (away - depth)).min())) / 2.0
        for place, low, high in sideways
    ]
    eye = middle[0] * right + middle[1] * up + away * back
    return Pose(eye, eye - (away - float(depth.mean())) * back, fov)


def project(pose: Pose, size: tuple[float, float], points: Array) -> Array:
    """Return where points (k, 3) [m] are seen (k, 2) [px], from the picture's top left corner; nan behind the eye.

    Args:
        size: width and height of the picture [px].
    """
    right, up, back = axes(np.asarray(pose.eye) - np.asarray(pose.look_at))
    from_eye = np.asarray(points, float) - pose.eye
    depth = -(from_eye @ back)
    pixels = size[1] / 2.0 / np.tan(pose.fov / 2.0) / np.where(depth > 0.0, depth, np.nan)
    return np.stack([size[0] / 2.0 + pixels * (from_eye @ right), size[1] / 2.0 - pixels * (from_eye @ up)], axis=-1)
