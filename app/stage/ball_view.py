"""The ball, and the arm's point that keeps clear of it."""

import pinocchio as pin
import viser

from app.session.frame import Frame
from app.settings import PageSettings
from app.stage.arms import ArmView
from app.stage.stage_part import StagePart, fresh
from app.theme import BRAND, PALETTES, rgb
from scenes.ball import BALL_RADIUS, POINT_RADIUS
from scenes.room import Room


class BallView(StagePart):
    """The ball has the colour of what the visitor moves; the point's sphere is attached to `arm`."""

    def __init__(self, scene: viser.SceneApi, room: Room, arm: ArmView) -> None:
        assert room.ball is not None
        self._columns = room.ball
        self.ball = scene.add_icosphere("/ball", radius=BALL_RADIUS, subdivisions=4, color=BRAND)
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
        self.nodes = (self.ball,) if self._point is None else (self.ball, self._point)

    def dress(self, page: PageSettings) -> None:
        if self._point is not None:
            self._point.color = rgb(PALETTES[page.theme].distance)

    def show(self, frame: Frame) -> None:
        self.ball.position = frame.simulation.positions[self._columns]
