"""The wall, and the plane at the distance to keep."""

from typing import Final

import viser

from app.session.frame import Frame
from app.settings import PageSettings
from app.stage.stage_part import StagePart, quaternion
from app.theme import PALETTES, rgb
from controllers.kinematics import Array
from scenes.first_task.wall import turn_of
from scenes.room import Room

SIZE: Final = (0.02, 0.9, 0.7)
"""Thickness, width and height of the drawn wall [m]; it acts as an endless plane."""


class WallView(StagePart):
    """The wall, translucent: the arm is behind it in some views."""

    def __init__(self, scene: viser.SceneApi, room: Room) -> None:
        assert room.wall is not None
        self._columns = room.wall
        self.wall = scene.add_box("/wall", rgb(PALETTES["light"].calm), SIZE, opacity=0.4, cast_shadow=False)
        plane = (0.004, SIZE[1], SIZE[2])
        self._kept = scene.add_box(
            "/kept_from_wall",
            rgb(PALETTES["light"].activation),
            plane,
            opacity=0.16,
            cast_shadow=False,
            receive_shadow=False,
        )
        self.nodes = (self.wall, self._kept)

    def dress(self, page: PageSettings) -> None:
        self._on = page.contact
        palette = PALETTES[page.theme]
        self.wall.color, self._kept.color = rgb(palette.calm), rgb(palette.activation)

    def show(self, frame: Frame) -> None:
        at: Array = frame.simulation.positions[self._columns]
        R = turn_of(at)
        # The wall is behind its plane.
        self.wall.position = at[:3] + R[:, 0] * (SIZE[0] / 2.0)
        self._kept.position = at[:3] - R[:, 0] * frame.simulation.settings.law.critical_distance
        self._kept.visible = self._on
        self.wall.wxyz = self._kept.wxyz = quaternion(R)
