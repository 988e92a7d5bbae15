"""Bases, start postures and camera of the arms."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import pinocchio as pin

from controllers.errors import BadSetting
from controllers.kinematics import Array
from scenes.setting_spec import add_choice

MIRROR: Final = np.array([-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
"""Turns a posture of one arm into the mirrored one of the other."""


@dataclass(frozen=True)
class Camera:
    """A view, described by what it must show.

    Attributes:
        centre: (3,), world [m].
        toward: from there to the eye (3,), any length.
        width, height: at the centre [m].
        fov: vertical [rad].
    """

    centre: tuple[float, float, float]
    toward: tuple[float, float, float]
    width: float
    height: float
    fov: float


@dataclass(frozen=True)
class Rig:
    """Bases and start postures of two arms, left first, or of one.

    Attributes:
        bases: poses in the world.
        starts: (7,) [rad]; () if unknown.
    """

    name: str
    bases: tuple[pin.SE3, ...]
    starts: tuple[Array, ...]
    camera: Camera


def _turn(roll: float, pitch: float, yaw: float) -> Array:
    """Ry(pitch) Rx(roll) Rz(yaw); degrees."""
    x, y, z = np.radians([roll, pitch, yaw])
    return (
        pin.rpy.rpyToMatrix(0.0, y, 0.0) @ pin.rpy.rpyToMatrix(x, 0.0, 0.0) @ pin.rpy.rpyToMatrix(0.0, 0.0, z)
    )


FIELD_OF_VIEW: Final = float(np.radians(32.0))

_torso_start = np.radians([-78.0, 58.0, 62.0, -84.0, 0.0, -35.0, 0.0])
# The authors' laboratory: bases from the second author's own two-LWR example.
_TORSO: Final = Rig(
    "torso",
    (
        pin.SE3(_turn(-60.0, 35.0, 120.0), np.array([0.0, 0.0765, 0.92])),
        pin.SE3(_turn(60.0, 35.0, -120.0), np.array([0.0, -0.0765, 0.92])),
    ),
    (_torso_start * MIRROR, _torso_start),
    Camera((0.30, 0.0, 0.93), (2.45, -0.45, 0.69), 1.70, 0.80, FIELD_OF_VIEW),
)


TABLE_HEIGHT: Final = 0.75
"""World z of the bases on the table [m]."""

TABLE_SEPARATION: Final = 1.1
"""Distance between the bases on the table [m]."""


_table_start = np.radians([0.0, 15.0, 0.0, 100.0, 0.0, -70.0, 0.0])
_TABLE: Final = Rig(
    "table",
    (
        pin.SE3(np.eye(3), np.array([-TABLE_SEPARATION / 2.0, 0.0, TABLE_HEIGHT])),
        pin.SE3(_turn(0.0, 0.0, 180.0), np.array([TABLE_SEPARATION / 2.0, 0.0, TABLE_HEIGHT])),
    ),
    (_table_start, _table_start),
    Camera((0.0, 0.0, 1.27), (0.45, -2.75, 0.67), 1.75, 1.32, FIELD_OF_VIEW),
)

TABLE_REACH: Final = 0.5
"""Arms of a shorter reach [m] get closer bases on the table, so that they can meet."""


def for_reach(rig: Rig, reach: float) -> Rig:
    """The rig; for short arms on the table with closer bases. `reach`: mean of both arms [m]."""
    if rig is not _TABLE or reach >= TABLE_REACH:
        return rig
    share, camera = reach / TABLE_REACH, rig.camera
    x, y, z = camera.centre
    nearer = replace(
        camera,
        centre=(share * x, share * y, TABLE_HEIGHT + share * (z - TABLE_HEIGHT)),
        width=share * camera.width,
        height=share * camera.height,
    )
    bases = tuple(
        pin.SE3(base.rotation, base.translation * np.array([share, share, 1.0])) for base in rig.bases
    )
    return replace(rig, bases=bases, camera=nearer)


RIGS: Final[dict[str, Rig]] = {"torso": _TORSO, "table": _TABLE}


def rig_named(name: str) -> Rig:
    """Rig of a name, or with bases "x,y,z,yaw:x,y,z,yaw" [m, degrees]."""
    if name in RIGS:
        return RIGS[name]
    (left, left_yaw), (right, right_yaw) = (
        (np.array(numbers[:3]), numbers[3])
        for numbers in ([float(n) for n in base.split(",")] for base in name.split(":"))
    )
    across = float(np.linalg.norm(right - left))
    x, y, z = ((left + right) / 2.0).tolist()
    # Seen along the ground line across the bases, so that neither arm hides the other.
    side = np.array([right[1] - left[1], left[0] - right[0], 0.0])
    toward = side / np.linalg.norm(side) if np.linalg.norm(side) > 1e-6 else np.array([1.0, 0.0, 0.0])
    camera = Camera(
        (x, y, z + 0.45),
        (float(2.75 * toward[0]), float(2.75 * toward[1]), 0.67),
        0.9 + across,
        1.45,
        FIELD_OF_VIEW,
    )
    return Rig(
        name, (pin.SE3(_turn(0, 0, left_yaw), left), pin.SE3(_turn(0, 0, right_yaw), right)), (), camera
    )


def place_bases(left: str, right: str) -> str:
    """Add bases to the choices of `rig` in this process; return their name.

    Args:
        left, right: x,y,z,yaw [m, degrees]; "" for the place on the table.

    Raises:
        BadSetting: not four numbers, or out of the room.
    """
    half = TABLE_SEPARATION / 2.0
    parts: list[str] = []
    for key, text, usual in (
        ("base-left", left, (-half, 0.0, TABLE_HEIGHT, 0.0)),
        ("base-right", right, (half, 0.0, TABLE_HEIGHT, 180.0)),
    ):
        try:
            numbers = [float(part) for part in text.split(",")] if text else list(usual)
        except ValueError:
            numbers = []
        # x, y, z [m] and yaw [degrees].
        low, high = (-2.0, -2.0, 0.0, -360.0), (2.0, 2.0, 2.0, 360.0)
        if len(numbers) != 4 or not all(a <= n <= b for a, n, b in zip(low, numbers, high, strict=True)):
            raise BadSetting(
                "{key} = {value!r} is not a place for a base; give x,y,z,yaw: x and y from -2 to 2 m, z from 0 to 2 m, yaw from -360 to "
                "360 degrees, as in --{key}=-0.5,0,0.75,0.",
                key=key,
                value=text[:60],
            )
        parts.append(",".join(f"{round(n, 3) + 0.0:g}" for n in numbers))
    name = ":".join(parts)
    add_choice("rig", name, "Given bases")
    return name


_alone_base = pin.SE3(np.eye(3), np.array([-0.35, 0.0, TABLE_HEIGHT]))
_alone_start = np.radians([0.0, 25.0, 0.0, 95.0, 0.0, -60.0, 0.0])
# From the front and the side: the way from A to B crosses the view, and the arm does not hide it.
_alone_camera = Camera((0.0, 0.0, 1.28), (2.3, -1.75, 0.72), 1.35, 1.2, FIELD_OF_VIEW)
ALONE: Final = Rig("table", (_alone_base,), (_alone_start,), _alone_camera)
"""A single arm, upright at the end of the table."""

CART: Final = replace(
    ALONE, name="cart", camera=replace(_alone_camera, centre=(-0.15, 0.0, 0.88), height=2.15)
)
"""A single arm on a cart, shown down to its foot."""

# Along the wall, a little from the arm's side: the wall hides nothing and shows the face that the arm meets.
_ALONG_WALL: Final = (-0.75, -2.65, 0.6)


def beside_wall(rig: Rig) -> Rig:
    """Rig of a single arm with a view past a wall."""
    return replace(rig, camera=replace(rig.camera, toward=_ALONG_WALL))
