"""Where the arm is taken hold of, and a thin line to where it is pulled."""

from typing import Final

import numpy as np
import viser

from app.session.frame import Frame
from app.settings import PageSettings
from app.theme import BRAND, scale
from scenes.targets import LinkTarget

WHITE: Final = (255, 255, 255)
"""Seen on the orange arm in either theme."""


class GripMark:
    """Seen while a link is pulled, also in a replay.

    Args:
        scene: where to draw.
    """

    def __init__(self, scene: viser.SceneApi) -> None:
        line = np.zeros((1, 2, 3), np.float32)
        self._line = scene.add_line_segments("/grip/line", line, BRAND, thickness=2, thickness_units="screen", visible=False)
        self._seen = False
        look = {"subdivisions": 2, "cast_shadow": False, "visible": False}
        self._point = scene.add_icosphere("/grip/point", radius=0.018, color=WHITE, **look)
        self._place = scene.add_icosphere("/grip/place", radius=0.009, color=BRAND, **look)

    def dress(self, page: PageSettings) -> None:
        self._line.thickness = 2.0 * scale(page.profile)

    def show(self, frame: Frame) -> None:
        """Draw the pull."""
        target, simulation = frame.target, frame.simulation
        pulled = isinstance(target, LinkTarget)
        if pulled != self._seen:
            self._seen = pulled
            for part in (self._line, self._point, self._place):
                part.visible = pulled
        if isinstance(target, LinkTarget):
            placement = simulation.kinematics.data.oMi[simulation.guided.joint(target.joint)]
            point = placement.act(target.offset)
            self._point.position, self._place.position = point, target.position
            self._line.points = np.array([[point, target.position]], np.float32)

    def remove(self) -> None:
        for part in (self._line, self._point, self._place):
            part.remove()
