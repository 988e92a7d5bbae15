"""Where a hand has been: a line that fades into the background."""

from collections import deque
from typing import NamedTuple

import numpy as np
import viser

from app.session.frame import Frame
from app.settings import PageSettings
from app.theme import PALETTES, rgb
from controllers.kinematics import Arm, Array


class Memory(NamedTuple):
    """How much a trace remembers.

    Attributes:
        points: how many.
        period: simulated time between two of them [s].
    """

    points: int
    period: float


STAY = Memory(60, 0.08)
"""For a hand that stays about its place."""

TRAVEL = Memory(140, 0.12)
"""For a hand on a long way: two laps, or there and back."""


class Trace:
    """The trace of one hand.

    Args:
        scene: where to draw.
        name: of the node.
        arm: of the hand.
        memory: how long it is.
    """

    def __init__(self, scene: viser.SceneApi, name: str, arm: Arm, memory: Memory) -> None:
        self._arm, self._memory = arm, memory
        self._points: deque[Array] = deque(maxlen=memory.points)
        self._time = -np.inf
        self._home: Array | None = None
        # Always of one length: the browser does not follow when points and colours change their number one after the other.
        line = np.zeros((memory.points - 1, 2, 3), np.float32)
        self._line = scene.add_line_segments(name, line, (0, 0, 0), thickness=3, thickness_units="screen", visible=False)

    def dress(self, page: PageSettings) -> None:
        palette = PALETTES[page.theme]
        bottom, error = (np.array(c, float) for c in (palette.background[1], rgb(palette.error)))
        share = np.linspace(0.15, 1.0, self._memory.points)[:, None]
        fade = (bottom + (error - bottom) * share).round().astype(np.uint8)
        self._line.colors = np.stack([fade[:-1], fade[1:]], axis=1)

    def show(self, frame: Frame) -> None:
        """Go on to where the hand is now."""
        simulation, points = frame.simulation, self._points
        time = simulation.time
        # A new beginning is a new trace.
        home = simulation.home
        other = home is not self._home and (home is None or self._home is None or not np.array_equal(home, self._home))
        self._home = home
        if time < self._time or other:
            points.clear()
            self._time = -np.inf
            self._line.visible = False
        if time - self._time < self._memory.period:
            return
        self._time = time
        hand = simulation.kinematics.hand_pose(self._arm).translation.copy()
        if not points:
            points.extend([hand] * self._memory.points)
        points.append(hand)
        way = np.array(points, np.float32)
        moved = float(np.ptp(way, axis=0).max()) > 0.004
        if moved:
            self._line.points = np.stack([way[:-1], way[1:]], axis=1)
        self._line.visible = moved

    def remove(self) -> None:
        self._line.remove()
