"""What of an experiment the camera has to show: the contact, the hands and their place, and where the hands go."""

from collections import deque
from typing import Final

import numpy as np

from app.stage.hand_path import circle_points
from controllers.kinematics import Array
from scenes.room import BALL_RADIUS, PATH
from scenes.simulation import Simulation

AHEAD: Final = 6.0
"""How far ahead the way of a hand is looked at [s]."""

MEMORY: Final = 25
"""Points of the recent way of each hand, and …"""

EVERY: Final = 0.2
"""… how far apart they are [s of wall time]."""

HAND: Final = 0.06
CONTACT: Final = 0.03
RING: Final = 0.10
"""Radii of what is shown around a hand, a closest point and the middle of the ring [m]."""


def contact_points(simulation: Simulation) -> Array:
    """Return the closest points (2, 3) [m]; (0, 3) where nothing is near."""
    near = simulation.detector.detect("single")
    return np.array(simulation.detector.witness_points(near.pair)) if near.pair >= 0 else np.zeros((0, 3))


def hands(simulation: Simulation) -> Array:
    """Return the places of all hands (k, 3) [m]."""
    return np.array([simulation.kinematics.hand_pose(arm).translation for arm in simulation.room.arms])


def joints(simulation: Simulation) -> Array:
    """Return the places of shoulder, elbow and wrist of every arm (k, 3) [m]."""
    point = simulation.kinematics.joint_point
    return np.array([point(joint) for arm in simulation.room.arms for joint in (arm.shoulder, arm.elbow, arm.wrist)])


def framed_now(simulation: Simulation) -> tuple[Array, Array]:
    """Return centres (k, 3) and radii (k,) of what has to be seen at this moment [m]: the closest points first, then the hands."""
    contact, places = contact_points(simulation), hands(simulation)
    centres, radii = [*contact, *places], [CONTACT] * len(contact) + [HAND] * len(places)
    if simulation.place is not None:
        centres.append(simulation.place)
        radii.append(RING)
    if simulation.room.ball is not None:
        centres.append(simulation.positions[simulation.room.ball])
        radii.append(BALL_RADIUS)
    return np.array(centres), np.array(radii)


def known_way(simulation: Simulation) -> Array:
    """Return points (k, 3) of the way that the task itself prescribes [m]: from A to B past the ball, or round a circle."""
    home, settings = simulation.home, simulation.settings
    if home is not None and settings.scene == "solo" and settings.path == "circle":
        return circle_points(home)[::8]
    if home is None or simulation.room.ball is None:
        return np.zeros((0, 3))
    return np.array([home, home + PATH])


class RecentWay:
    """Where the hands were in the last seconds."""

    def __init__(self) -> None:
        self._points: deque[Array] = deque(maxlen=MEMORY)
        self._next = 0.0

    def note(self, simulation: Simulation, now: float) -> None:
        """Note where the hands are. `now`: wall time [s]."""
        if now >= self._next:
            self._next = now + EVERY
            self._points.append(hands(simulation))

    def forget(self) -> None:
        self._points.clear()

    @property
    def points(self) -> Array:
        """(k, 3) [m]."""
        return np.concatenate([np.zeros((0, 3)), *self._points])
