"""The KUKA LWR 4+ in numbers, for URDF, model and shells.

Kinematics: standard DH parameters a = 0, alpha = (+90, -90, -90, +90, +90, -90, 0) deg, d = (310, 0, 400, 0,
390, 0, 78) mm, here as joint origins along the previous z axis. Limits: KUKA LWR 4+ data sheet; velocity
limits as in the IJS RobotBlockSet. KUKA publishes no inertias: masses and centres of mass are common
estimates.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np


@dataclass(frozen=True)
class Joint:
    """A revolute joint; its frame is that of the link behind it, parallel to the base frame at q = 0.

    Attributes:
        name: KUKA's number, "j1" (A1) … "j7" (A6).
        origin: height above the joint before it, or the mounting face [m].
        axis: unit axis in the joint frame.
        position_limit: symmetric [rad].
        velocity_limit: [rad/s].
        torque_limit: [Nm].
    """

    name: str
    origin: float
    axis: tuple[int, int, int]
    position_limit: float
    velocity_limit: float
    torque_limit: float


def _joint(
    number: int, origin: float, axis: tuple[int, int, int], position: float, velocity: float, torque: float
) -> Joint:
    return Joint(f"j{number}", origin, axis, float(np.radians(position)), float(np.radians(velocity)), torque)


JOINTS: Final = (
    _joint(1, 0.110, (0, 0, 1), 170, 100, 176),
    _joint(2, 0.200, (0, -1, 0), 120, 110, 176),
    _joint(3, 0.200, (0, 0, 1), 170, 100, 100),
    _joint(4, 0.200, (0, 1, 0), 120, 130, 100),
    _joint(5, 0.200, (0, 0, 1), 170, 130, 100),
    _joint(6, 0.190, (0, -1, 0), 120, 180, 38),
    _joint(7, 0.078, (0, 0, 1), 170, 180, 38),
)

JOINT_LABELS: Final = (
    "base turn",
    "shoulder",
    "upper-arm roll",
    "elbow",
    "forearm roll",
    "wrist",
    "flange roll",
)

MASSES: Final = (1.210, 2.303, 2.303, 2.303, 2.303, 1.601, 1.493, 0.109)
"""Links 0 … 7 [kg]."""

CENTRES_OF_MASS: Final = (
    (0.0, 0.0, 0.048),
    (0.0, 0.023, 0.118),
    (0.0, -0.033, 0.074),
    (0.0, -0.023, 0.118),
    (0.0, 0.033, 0.074),
    (0.0, 0.021, 0.086),
    (0.0, -0.005, -0.003),
    (0.0, 0.0, -0.016),
)
"""In the frames of links 0 … 7 [m]."""


@dataclass(frozen=True)
class CapsuleFact:
    """A capsule along the z axis of a link frame.

    Attributes:
        link: 0 (base) … 7 (flange).
        start, end: z of the sphere centres in that frame [m].
        radius: [m].
    """

    name: str
    link: int
    start: float
    end: float
    radius: float


CAPSULES: Final = (
    CapsuleFact("pedestal", 0, 0.0, 0.310, 0.075),
    CapsuleFact("upper arm", 2, 0.0, 0.400, 0.070),
    CapsuleFact("forearm", 4, 0.0, 0.390, 0.065),
    CapsuleFact("hand", 6, 0.0, 0.128, 0.050),
)
"""A roll joint never moves these capsules: one per segment is enough. The hand includes the tool, 50 mm
beyond the flange.
"""
