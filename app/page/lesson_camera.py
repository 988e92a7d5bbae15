"""From where a step of a lesson is looked at: the whole experiment, or closer to what it is about."""

from dataclasses import replace
from typing import Final

import numpy as np

from app.lessons.lesson import Camera as Where
from app.page.camera import view_of
from scenes.rigs import Camera
from scenes.simulation import Simulation

CLOSE: Final = (1.15, 1.05)
"""What is seen from close by, across and up [m]."""

TOP: Final = (0.35, 0.0, 1.0)
"""From the middle of the view to an eye above it, any length."""


def lesson_view(simulation: Simulation, where: Where) -> Camera:
    """Return a view of a simulation."""
    view = view_of(simulation)
    if where == "room" or simulation.settings.scene == "imitation":
        return view
    if where == "top":
        return replace(view, toward=TOP)
    kinematics, arm = simulation.kinematics, simulation.avoiding
    hand = kinematics.hand_pose(arm).translation
    if where == "hand":
        centre = np.array(hand)
    elif where == "elbow":
        centre = (kinematics.joint_point(arm.elbow) + hand) / 2.0
    else:
        centre = (kinematics.hand_pose(simulation.guided).translation + hand) / 2.0
    width, height = CLOSE
    x, y, z = (float(number) for number in centre)
    return replace(view, centre=(x, y, z), width=min(width, view.width), height=min(height, view.height))
