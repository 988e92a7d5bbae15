"""Cameras of experiments, and the nearest camera that sees a set of balls."""

import math
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from controllers.kinematics import Array
from scenes.ball import BALL_RADIUS
from scenes.given_robots import GIVEN
from scenes.rigs import Camera
from scenes.robots import Robot
from scenes.robots.example_data import EXAMPLES, PANDA
from scenes.robots.start_search import arm_reach
from scenes.simulation import Simulation

NEAREST: Final = 0.3
"""Least distance of a ball from the eye [m]."""


class Pose(NamedTuple):
    """Upright camera: eye and target point (3,) [m], vertical angle of view [rad]."""

    eye: Array
    look_at: Array
    fov: float


class Balls(NamedTuple):
    """Balls for one part of the picture.

    Attributes:
        centres: (k, 3) [m].
        radii: (k,) [m].
        part: left, top, right, bottom from the picture's top left corner [px].
    """

    centres: Array
    radii: Array
    part: tuple[float, float, float, float]


def axes(toward: Array) -> tuple[Array, Array, Array]:
    """Unit vectors (3,) to the right, up and towards the eye. `toward`: any length, not upright."""
    x, y, z = (float(part) for part in toward)
    length, across = math.sqrt(x * x + y * y + z * z), math.hypot(x, y)
    right, ahead = -y / across, x / across
    x, y, z = x / length, y / length, z / length
    return (
        np.array([right, ahead, 0.0]),
        np.array([-z * ahead, z * right, x * ahead - y * right]),
        np.array([x, y, z]),
    )


def fit(toward: Array, fov: float, size: tuple[float, float], groups: tuple[Balls, ...]) -> Pose:
    """Nearest camera that looks along −toward and has every ball inside its part; remaining space is shared
    evenly.

    A shifted camera sees x at f (x − c_x) / (c_z − z) px from the middle. These bounds are linear in c, so
    the least c_z for which all agree on a c_x, and on a c_y, is the largest over pairs of bounds.

    Args:
        toward: from the scene to the eye (3,).
        fov: vertical angle [rad].
        size: width and height [px].
        groups: at least one with a ball.
    """
    right, up, back = axes(toward)
    centres, radii = (np.concatenate(parts) for parts in list(zip(*groups, strict=True))[:2])
    parts = np.repeat([group.part for group in groups], [len(group.centres) for group in groups], axis=0)
    pixel, (x, y) = np.tan(fov / 2.0) * 2.0 / size[1], (size[0] / 2.0, size[1] / 2.0)
    depth = centres @ back
    sideways = [
        (centres @ right, pixel * (parts[:, 0] - x), pixel * (parts[:, 2] - x)),
        (centres @ up, pixel * (y - parts[:, 3]), pixel * (y - parts[:, 1])),
    ]
    away = float((depth + radii).max()) + NEAREST
    for place, low, high in sideways:
        # place − high (c_z − depth) ≤ c ≤ place − low (c_z − depth), for every ball.
        least, most = place + radii + high * depth, place - radii + low * depth
        away = max(away, float(((least[:, None] - most[None, :]) / (high[:, None] - low[None, :])).max()))
    middle = [
        (
            float((place + radii - high * (away - depth)).max())
            + float((place - radii - low * (away - depth)).min())
        )
        / 2.0
        for place, low, high in sideways
    ]
    eye = middle[0] * right + middle[1] * up + away * back
    return Pose(eye, eye - (away - float(depth.mean())) * back, fov)


def pose_of(camera: Camera, aspect: float) -> Pose:
    """Pose that shows all of a camera's view. `aspect`: width over height."""
    away = max(camera.height, camera.width / aspect) / (2.0 * math.tan(camera.fov / 2.0))
    centre = np.array(camera.centre)
    return Pose(centre + axes(np.array(camera.toward))[2] * away, centre, camera.fov)


def project(pose: Pose, size: tuple[float, float], points: Array) -> Array:
    """Pixels (k, 2) of points (k, 3) [m], from the picture's top left corner; nan behind the eye. `size`:
    width and height [px].
    """
    right, up, back = axes(np.asarray(pose.eye) - np.asarray(pose.look_at))
    from_eye = np.asarray(points, float) - pose.eye
    depth = -(from_eye @ back)
    pixels = size[1] / 2.0 / np.tan(pose.fov / 2.0) / np.where(depth > 0.0, depth, np.nan)
    return np.stack(
        [size[0] / 2.0 + pixels * (from_eye @ right), size[1] / 2.0 - pixels * (from_eye @ up)], axis=-1
    )


class PointView:
    """`project` for single points, without the cost of arrays."""

    def __init__(self, pose: Pose) -> None:
        self.pose = pose
        self.axes = axes(pose.eye - pose.look_at)
        self._rows = tuple((*axis.tolist(), float(axis @ pose.eye)) for axis in self.axes)
        self._focal = 0.5 / math.tan(pose.fov / 2.0)

    def pixel(self, place: Array, width: float, height: float) -> tuple[float, float, float]:
        """Pixel (x, y) of a point (3,) [m] and size of a pixel there [m]; nan behind the eye. `width`,
        `height`: [px].
        """
        px, py, pz = place.tolist()
        right, up, back = (x * px + y * py + z * pz - eye for x, y, z, eye in self._rows)
        if back >= 0.0:
            return math.nan, math.nan, math.nan
        metre = -back / (height * self._focal)
        return width / 2.0 + right / metre, height / 2.0 - up / metre, metre


AHEAD: Final = 6.0
"""Shown time of the hand's coming path [s]."""

HAND: Final = 0.06
CONTACT: Final = 0.03
RING: Final = 0.10
"""Radii around a hand, a closest point and the ring's middle [m]."""


def contact_points(simulation: Simulation) -> Array:
    """Closest points (2, 3) [m]; (0, 3) if nothing is near."""
    near = simulation.detector.detect("single")
    return np.array(simulation.detector.witness_points(near.pair)) if near.pair >= 0 else np.zeros((0, 3))


def hands(simulation: Simulation) -> Array:
    """Hand positions (k, 3) [m]."""
    return np.array([simulation.kinematics.hand_pose(arm).translation for arm in simulation.room.arms])


def joints(simulation: Simulation) -> Array:
    """Positions of all shoulders, elbows and wrists (k, 3) [m]."""
    point = simulation.kinematics.joint_point
    return np.array(
        [point(joint) for arm in simulation.room.arms for joint in (arm.shoulder, arm.elbow, arm.wrist)]
    )


def framed_now(simulation: Simulation) -> tuple[Array, Array]:
    """Centres (k, 3) and radii (k,) that must be visible [m]: closest points, then hands."""
    contact, places = contact_points(simulation), hands(simulation)
    centres, radii = [*contact, *places], [CONTACT] * len(contact) + [HAND] * len(places)
    if simulation.keeper is not None:
        centres.append(simulation.keeper.place)
        radii.append(RING)
    if simulation.room.ball is not None:
        centres.append(simulation.positions[simulation.room.ball])
        radii.append(BALL_RADIUS)
    return np.array(centres), np.array(radii)


PANDA_REACH: Final = 1.15
"""From shoulder to hand [m]."""


def view_of(simulation: Simulation) -> Camera:
    """An experiment's view: its rig's, wider for longer arms."""
    room, camera = simulation.room, simulation.room.rig.camera
    if len(room.arms) == 2:
        x, y, own = camera.centre
        views = [_seen(made, room.rig.name) or (own, camera.width, camera.height) for made in room.robots]
        # Everything that either view shows.
        if views[0] == views[1]:
            z, width, height = views[0]
        else:
            low, high = min(z - h / 2.0 for z, _, h in views), max(z + h / 2.0 for z, _, h in views)
            z, width, height = (low + high) / 2.0, max(w for _, w, _ in views), high - low
        return replace(camera, centre=(x, y, z), width=width, height=height)
    return camera


def _seen(made: Robot, rig: str) -> tuple[float, float, float] | None:
    """Height of the middle, width and height of a make's view; None for the rig's own."""
    if made.key not in GIVEN:
        return EXAMPLES[made.key].views.get(rig) if made.key in EXAMPLES else None
    if rig not in PANDA.views:
        return None
    z, width, height = PANDA.views[rig]
    scale = max(arm_reach(made) / PANDA_REACH, 0.85)
    return z, width * scale, height * scale
