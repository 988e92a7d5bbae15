"""Postures that a run can begin in, beside the room's own."""

from typing import Final

import numpy as np

from controllers.kinematics import Array
from scenes.room import Room
from scenes.settings import RunSettings

BETWEEN: Final = np.array(
    [0.90, 1.48, -1.67, -1.26, 0.07, -1.01, -0.22, -0.70, 1.11, 1.18, -1.88, 0.65, -0.42, -0.35],
)
"""Of two LWRs on the torso (14,) [rad]: where the guided arm keeps clear and the autopilot of seed 396 moves it at v = 0.05 m/s, it
slides along the tie of two pairs and, with the closest pair, loses 121 mm of 150 mm against an obstacle at rest, with full authority.
Found by a search over random postures, rounded to 0.01 rad."""


def start_of(settings: RunSettings, room: Room) -> Array:
    """Return q (nv,) [rad, m] in which a run begins: the room's own, unless the settings name another that fits the room."""
    fits = settings.scene == "hold" and settings.rig == "torso" and settings.robot == "lwr"
    return BETWEEN if settings.start == "between" and fits else room.start
