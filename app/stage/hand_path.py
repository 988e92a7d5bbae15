"""The way that a hand is asked to go: a thin line from A to B, or a circle."""

import numpy as np
import viser

from app.session.frame import Frame
from app.settings import PageSettings
from app.theme import PALETTES, rgb, scale
from controllers.kinematics import Array
from scenes import solo
from scenes.room import PATH

POINTS = 96
"""Of a circle."""


class PathLine:
    """The desired path of the arm that stands alone.

    Args:
        scene: where to draw.
        circle: whether it is a circle; else it goes from A to B.
    """

    def __init__(self, scene: viser.SceneApi, circle: bool) -> None:
        self._circle = circle
        count = POINTS if circle else 1
        line = np.zeros((count, 2, 3), np.float32)
        self._line = scene.add_line_segments("/path/line", line, (0, 0, 0), thickness=1.5, thickness_units="screen")
        # Beyond either end, where the number at the line to the ball does not come.
        self._labels = (
            ()
            if circle
            else (scene.add_label("/path/A", "A", anchor="center-right"), scene.add_label("/path/B", "B", anchor="center-left"))
        )
        self._home: tuple[float, ...] | None = None

    def dress(self, page: PageSettings) -> None:
        palette = PALETTES[page.theme]
        count = POINTS if self._circle else 1
        self._line.colors = np.tile(np.array(rgb(palette.calm), np.uint8), (count, 2, 1))
        self._line.thickness = 1.5 * scale(page.profile)
        for label in self._labels:
            label.font_screen_scale = 1.15 * scale(page.profile)

    def show(self, frame: Frame) -> None:
        """Draw the path where it begins now."""
        home = frame.simulation.home
        if home is None or tuple(home.tolist()) == self._home:
            return
        self._home = tuple(home.tolist())
        way = circle_points(home) if self._circle else np.array([home, home + PATH])
        self._line.points = np.stack([way[:-1], way[1:]], axis=1).astype(np.float32)
        for label, point, side in zip(self._labels, way, (-1.0, 1.0), strict=False):
            label.position = point + np.array([0.0, 0.03 * side, 0.0])

    def remove(self) -> None:
        self._line.remove()
        for label in self._labels:
            label.remove()


def circle_points(home: Array) -> Array:
    """Return points (k, 3) all round the circle that begins at home (3,) [m]."""
    return np.array([solo.circle(solo.LAP * i / POINTS, home)[0] for i in range(POINTS + 1)])
