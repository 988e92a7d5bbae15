"""Ways of hands: a thin line where one is asked to go, and a fading line where one has been."""

from collections import deque
from typing import Final

import numpy as np
import viser

from app.session.frame import Frame
from app.settings import PageSettings
from app.stage.stage_part import StagePart
from app.theme import PALETTES, rgb, scale
from controllers.kinematics import Arm, Array


class PathLine(StagePart):
    """The way that the task prescribes to the avoiding hand; at the ends of one that is not closed stand A and B.

    Args:
        scene: where to draw.
        way: its points (k, 3) as it begins now [m].
    """

    def __init__(self, scene: viser.SceneApi, way: Array) -> None:
        self._count = len(way) - 1
        line = np.stack([way[:-1], way[1:]], axis=1).astype(np.float32)
        self._line = scene.add_line_segments("/path/line", line, (0, 0, 0), thickness=1.5, thickness_units="screen")
        # Beyond either end, where the number at the line to the ball does not come.
        self._labels = (
            ()
            if np.allclose(way[0], way[-1])
            else (scene.add_label("/path/A", "A", anchor="center-right"), scene.add_label("/path/B", "B", anchor="center-left"))
        )
        self.nodes = (self._line, *self._labels)
        self._home: list[float] | None = None

    def dress(self, page: PageSettings) -> None:
        palette = PALETTES[page.theme]
        self._line.colors = np.tile(np.array(rgb(palette.calm), np.uint8), (self._count, 2, 1))
        self._line.thickness = 1.5 * scale(page.profile)
        for label in self._labels:
            label.font_screen_scale = 1.15 * scale(page.profile)

    def show(self, frame: Frame) -> None:
        """Draw the path where it begins now."""
        keeper = frame.simulation.keeper
        if keeper is None or keeper.home.tolist() == self._home:
            return
        self._home = keeper.home.tolist()
        way = frame.simulation.way
        self._line.points = np.stack([way[:-1], way[1:]], axis=1).astype(np.float32)
        for label, point, side in zip(self._labels, way[[0, -1]], (-1.0, 1.0), strict=False):
            label.position = point + np.array([0.0, 0.07 * side, 0.0])


STAY: Final = (60, 0.08)
"""Points that the trace of a hand about its place has, and simulated time between two of them [s]; …"""

TRAVEL: Final = (140, 0.12)
"""… and of a hand on a long way: two laps, or there and back."""


class Trace(StagePart):
    """The trace of one hand.

    Args:
        scene: where to draw.
        arm: of the hand.
        travels: whether the hand goes a long way.
    """

    def __init__(self, scene: viser.SceneApi, arm: Arm, travels: bool) -> None:
        self._arm, (self._count, self._period) = arm, TRAVEL if travels else STAY
        self._points: deque[Array] = deque(maxlen=self._count)
        self._time = -np.inf
        self._home: list[float] | None = None
        # Always of one length: the browser does not follow when points and colours change their number one after the other.
        line = np.zeros((self._count - 1, 2, 3), np.float32)
        self._line = scene.add_line_segments("/trace", line, (0, 0, 0), thickness=3, thickness_units="screen", visible=False)
        self.nodes = (self._line,)

    def dress(self, page: PageSettings) -> None:
        palette = PALETTES[page.theme]
        bottom, error = (np.array(c, float) for c in (palette.background[1], rgb(palette.error)))
        share = np.linspace(0.15, 1.0, self._count)[:, None]
        fade = (bottom + (error - bottom) * share).round().astype(np.uint8)
        self._line.colors = np.stack([fade[:-1], fade[1:]], axis=1)

    def show(self, frame: Frame) -> None:
        """Go on to where the hand is now."""
        simulation, points = frame.simulation, self._points
        time = simulation.time
        # A new beginning is a new trace.
        home = None if simulation.keeper is None else simulation.keeper.home.tolist()
        if time < self._time or home != self._home:
            self._home = home
            points.clear()
            self._time = -np.inf
            self._line.visible = False
        if time - self._time < self._period:
            return
        self._time = time
        hand = simulation.kinematics.hand_pose(self._arm).translation.copy()
        if not points:
            points.extend([hand] * self._count)
        points.append(hand)
        way = np.array(points, np.float32)
        moved = float(np.ptp(way, axis=0).max()) > 0.004
        if moved:
            self._line.points = np.stack([way[:-1], way[1:]], axis=1)
        self._line.visible = moved
