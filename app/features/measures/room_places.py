"""Positions in a room, for lessons."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pinocchio as pin

from controllers.errors import BadSetting
from controllers.kinematics import Array, Kinematics
from scenes.ball import BALL_RADIUS, BALL_ROOM, PATH, POINT_RADIUS
from scenes.room import Room
from scenes.solo import swing

Anchor = Literal["hand", "goal", "middle", "elbow"]
"""The hand at the start, end or middle of its path past the ball, or the elbow."""


@dataclass(frozen=True)
class RoomPlace:
    """Position of the ball.

    Attributes:
        toward: direction (3,), world, any length; or along the upper arm, from shoulder to elbow.
        gap: free space for an avoiding point at the origin [m].
        tilt: of the direction, from the upper arm upwards [rad].
    """

    origin: Anchor
    toward: tuple[float, float, float] | Literal["upper_arm"]
    gap: float
    tilt: float = 0.0


@dataclass(frozen=True)
class Start:
    """Ball position, or posture (n,) of all arms [rad]."""

    ball: RoomPlace | None = None
    posture: tuple[float, ...] | None = None


def _standing(room: Room) -> Kinematics:
    kinematics = Kinematics(room.model, room.arms)
    kinematics.update(room.start)
    return kinematics


def ball_centre(room: Room, place: RoomPlace) -> Array:
    """(3,) [m].

    Raises:
        BadSetting: no ball, no direction, or out of reach.
    """
    if room.ball is None:
        raise BadSetting("A place of the ball needs a room with a ball; set scene = ball.")
    kinematics, arm = _standing(room), room.arms[0]
    hand = kinematics.hand_pose(arm).translation.copy()
    shoulder, elbow = kinematics.joint_point(arm.shoulder), kinematics.joint_point(arm.elbow)
    origin = {"hand": hand, "goal": hand + PATH, "middle": hand + PATH / 2.0, "elbow": elbow}[place.origin]
    if place.toward == "upper_arm":
        along = (elbow - shoulder) / np.linalg.norm(elbow - shoulder)
        aside = np.cross(along, [0.0, 0.0, 1.0])
        if np.linalg.norm(aside) < 1e-6:
            aside = np.array([0.0, 1.0, 0.0])
        toward = pin.exp3(aside / np.linalg.norm(aside) * place.tilt) @ along
    else:
        toward = np.array(place.toward)
        length = float(np.linalg.norm(toward))
        if length < 1e-9:
            raise BadSetting("toward = [0, 0, 0] is not a direction; give one number that is not 0.")
        toward = toward / length
    centre = origin + toward * (place.gap + BALL_RADIUS + POINT_RADIUS)
    if np.abs(centre).max() > BALL_ROOM:
        raise BadSetting(
            f"gap = {place.gap:g} m takes the ball out of its room, {BALL_ROOM:g} m about the origin; give less."
        )
    return np.asarray(centre, np.float64)


def start_positions(room: Room, start: Start | None) -> Array | None:
    """q (nv,) [rad, m]; None for the room's own start.

    Raises:
        BadSetting: the room has no such place or posture.
    """
    if start is None:
        return None
    positions = room.start.copy()
    if start.posture is not None:
        arms = room.arms[-1].joints.stop
        if len(start.posture) != arms:
            raise BadSetting(
                f"posture has {len(start.posture)} angles, but the arms of this room have {arms} joints."
            )
        low, high = room.model.lowerPositionLimit[:arms], room.model.upperPositionLimit[:arms]
        beyond = np.flatnonzero((start.posture < low) | (start.posture > high))
        if len(beyond):
            j = int(beyond[0])
            raise BadSetting(
                f"posture: angle {j + 1} is {start.posture[j]:g}; it must be from {low[j]:.3f} to {high[j]:.3f} rad."
            )
        positions[:arms] = start.posture
    if start.ball is not None:
        positions[room.ball] = ball_centre(room, start.ball)
    return positions


def mark_places(room: Room, angles: Sequence[float]) -> Array:
    """Elbow at the start, turned about the line from shoulder to wrist by `angles` [rad] (k, 3) [m]."""
    turned = swing(_standing(room), room.arms[0])
    return np.array([turned(angle).elbow for angle in angles])
