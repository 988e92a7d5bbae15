"""Camera of a lesson's step."""

from dataclasses import replace
from typing import Final

import numpy as np

from app.features.lessons.lesson import LessonCamera
from app.page.camera_follow import view_corners
from app.stage.camera_view import axes, view_of
from controllers.kinematics import Array
from scenes.ball import BALL_RADIUS, PATH
from scenes.rigs import Camera
from scenes.simulation import Simulation

MARGIN: Final = 0.22
"""Margin for the arm's girth and the hand's swing [m]."""

REACH: Final = 0.12
"""Extra margin above a single arm's hand [m]."""

INSIDE: Final = 0.7
"""Share of the experiment's view that must be shown, about its middle."""

TOP: Final = (0.35, 0.0, 1.0)
"""Direction from the view's middle to an eye above."""


def lesson_view(simulation: Simulation, where: LessonCamera) -> Camera:
    view = view_of(simulation)
    if where == "top":
        return replace(view, toward=TOP)
    if simulation.settings.experiment.moves == "person" or (where == "room" and simulation.room.ball is None):
        return view
    near = _near(simulation, where)
    if where == "room":
        # A ball may begin outside the view of the arm and its table.
        near = np.vstack(
            [near, view_corners(replace(view, width=INSIDE * view.width, height=INSIDE * view.height))]
        )
    return _around(near, view)


def _near(simulation: Simulation, where: LessonCamera) -> Array:
    """Points (k, 3) to show [m]."""
    kinematics, room = simulation.kinematics, simulation.room
    arms = room.arms if where == "between" else (simulation.avoiding,)
    points: list[Array] = []
    for arm in arms:
        points += [kinematics.joint_point(joint) for joint in range(arm.shoulder, arm.wrist + 1)]
        points += [room.rig.bases[room.arms.index(arm)].translation, kinematics.hand_pose(arm).translation]
    if simulation.settings.experiment.obstacle == "nothing":
        # Room for a drawn circle, or the handle's arrow.
        points.append(points[-1] + np.array([0.0, 0.0, REACH]))
    if room.ball is not None:
        hand, ball = points[-1], simulation.positions[room.ball]
        reach = BALL_RADIUS - MARGIN
        points += [hand + PATH, ball + reach, ball - reach]
    return np.array(points)


def _around(points: Array, view: Camera) -> Camera:
    right, up, toward = axes(np.array(view.toward))
    across, high = points @ right, points @ up
    width, height = float(np.ptp(across)) + 2.0 * MARGIN, float(np.ptp(high)) + 2.0 * MARGIN
    along = float((points @ toward).mean())
    centre = (
        right * (across.min() + across.max()) / 2.0 + up * (high.min() + high.max()) / 2.0 + toward * along
    )
    x, y, z = (float(number) for number in centre)
    return replace(view, centre=(x, y, z), width=width, height=height)
