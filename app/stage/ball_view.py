"""The ball in the way, and the sphere about the point of the arm that keeps clear of it."""

from typing import Final

import numpy as np
import pinocchio as pin
import viser

from app.settings import PageSettings
from app.stage.arms import ArmView
from app.stage.poses import fresh
from app.theme import BRAND, PALETTES, rgb
from scenes.history import Sample
from scenes.room import BALL_RADIUS, POINT_RADIUS, Room
from scenes.simulation import Simulation

FAR_AWAY: Final = -9.0


class BallView:
    """The ball has the colour of what is yours.

    Args:
        scene: where to draw.
        room: with a ball.
        arm: as drawn; the sphere hangs on one of its links.
    """

    def __init__(self, scene: viser.SceneApi, room: Room, arm: ArmView) -> None:
        assert room.ball is not None
        self._columns = room.ball
        self._ball = scene.add_icosphere("/ball", radius=BALL_RADIUS, subdivisions=4, color=BRAND)
        self._shown = (FAR_AWAY, FAR_AWAY, FAR_AWAY)
        self._point: viser.IcosphereHandle | None = None
        if room.point != "arm":
            name = f"control point at the {room.point}"
            body = room.geometry.geometryObjects[room.geometry.getGeometryId(name)]
            placement: pin.SE3 = body.placement
            point = scene.add_icosphere(
                f"{arm.link(body.parentJoint)}/control_point",
                radius=POINT_RADIUS,
                opacity=0.35,
                position=tuple(placement.translation.tolist()),
                cast_shadow=False,
                receive_shadow=False,
            )
            self._point = fresh(point)

    def dress(self, page: PageSettings) -> None:
        """Take on a theme."""
        if self._point is not None:
            self._point.color = rgb(PALETTES[page.theme].distance)

    def show(self, simulation: Simulation, sample: Sample) -> None:
        """Draw the ball where it is."""
        del sample
        x, y, z = simulation.positions[self._columns].tolist()
        if (x, y, z) != self._shown:
            self._shown = x, y, z
            self._ball.position = np.array([x, y, z])

    def remove(self) -> None:
        """Take both out of the scene."""
        self._ball.remove()
        if self._point is not None:
            self._point.remove()
