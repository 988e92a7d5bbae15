"""Marks of a hand: desired place, pulled point, prescribed path and trace."""

from collections import deque
from typing import Final

import numpy as np
import viser

from app.session.frame import Frame
from app.settings import PageSettings
from app.stage.contact_view import grid_faces
from app.stage.stage_part import StagePart, fresh, quaternion
from app.theme import BRAND, PALETTES, rgb, scale
from controllers.kinematics import Arm, Array
from scenes.targets import LinkTarget, PairTarget

AWAY: Final = 0.004
"""Least length of the line to the hand [m]."""

RADIUS: Final = 0.085
"""Radius of the ring [m]; each robot's hand fits through it."""

TUBE: Final = 0.006
"""Half the ring's thickness [m]."""


class TargetPlace(StagePart):
    def __init__(self, scene: viser.SceneApi) -> None:
        self._ball = scene.add_icosphere(
            "/place/ball", radius=0.017, subdivisions=2, color=(255, 255, 255), opacity=0.9, cast_shadow=False
        )
        ring = scene.add_mesh_simple(
            "/place/ring", *_ring(RADIUS, TUBE), color=(255, 255, 255), cast_shadow=False
        )
        self._ring = fresh(ring)
        line = np.zeros((1, 2, 3), np.float32)
        self._error = scene.add_line_segments(
            "/place/error", line, (0, 0, 0), thickness=2, thickness_units="screen", visible=False
        )
        self.nodes = (self._ball, self._ring, self._error)
        self._shown: tuple[Array, Array] | None = None

    def dress(self, page: PageSettings) -> None:
        error = rgb(PALETTES[page.theme].error)
        self._ball.color = self._ring.color = error
        self._error.colors = np.tile(np.array(error, np.uint8), (1, 2, 1))

    def show(self, frame: Frame) -> None:
        simulation = frame.simulation
        if simulation.keeper is None:
            return
        place, rotation = simulation.keeper.place, simulation.keeper.place_rotation
        # A place that moves is another array.
        if self._shown is None or place is not self._shown[0] or rotation is not self._shown[1]:
            self._shown = place, rotation
            self._ball.position = self._ring.position = place
            self._ring.wxyz = quaternion(rotation)
        hand = simulation.kinematics.hand_pose(simulation.avoiding).translation
        way = hand - place
        away = self._error.visible = float(way.dot(way)) > AWAY**2
        if away:
            self._error.points = np.array([[place, hand]], np.float32)


def _ring(radius: float, tube: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (k, 3) and faces (m, 3) of a torus about z [m]."""
    rounds, sides = 40, 8
    u, v = np.meshgrid(np.arange(rounds), np.arange(sides), indexing="ij")
    a, b = 2.0 * np.pi * u / rounds, 2.0 * np.pi * v / sides
    r = radius + tube * np.cos(b)
    vertices = np.stack([r * np.cos(a), r * np.sin(a), tube * np.sin(b)], axis=-1).reshape(-1, 3)
    corners = np.arange(u.size).reshape(u.shape)
    return vertices.astype(np.float32), grid_faces(np.vstack([corners, corners[:1]]))


WHITE: Final = (255, 255, 255)


class GripMark(StagePart):
    """Visible while a link is pulled, also in a replay. `other`: the arm that keeps its place."""

    def __init__(self, scene: viser.SceneApi, other: bool = False) -> None:
        line, name = np.zeros((1, 2, 3), np.float32), "/other_grip" if other else "/grip"
        self._other = other
        self._line = scene.add_line_segments(
            f"{name}/line", line, BRAND, thickness=2, thickness_units="screen", visible=False
        )
        look = {"subdivisions": 2, "cast_shadow": False, "visible": False}
        self._point = scene.add_icosphere(f"{name}/point", radius=0.018, color=WHITE, **look)
        self._place = scene.add_icosphere(f"{name}/place", radius=0.009, color=BRAND, **look)
        self.nodes = (self._line, self._point, self._place)

    def dress(self, page: PageSettings) -> None:
        self._line.thickness = 2.0 * scale(page.profile)

    def show(self, frame: Frame) -> None:
        target, simulation = frame.target, frame.simulation
        if isinstance(target, PairTarget):
            target = target.second if self._other else target.first
        elif self._other:
            target = None
        for node in self.nodes:
            node.visible = isinstance(target, LinkTarget)
        if isinstance(target, LinkTarget):
            arm = simulation.avoiding if self._other else simulation.guided
            placement = simulation.kinematics.data.oMi[arm.joint(target.joint)]
            point = placement.act(target.offset)
            self._point.position, self._place.position = point, target.position
            self._line.points = np.array([[point, target.position]], np.float32)


class PathLine(StagePart):
    """The avoiding hand's prescribed path `way` (k, 3) [m]; A and B mark the ends of an open one."""

    def __init__(self, scene: viser.SceneApi, way: Array) -> None:
        self._count = len(way) - 1
        line = np.stack([way[:-1], way[1:]], axis=1).astype(np.float32)
        self._line = scene.add_line_segments(
            "/path/line", line, (0, 0, 0), thickness=1.5, thickness_units="screen"
        )
        # Beyond either end, clear of the number at the ball.
        self._labels = (
            ()
            if np.allclose(way[0], way[-1])
            else (
                scene.add_label("/path/A", "A", anchor="center-right"),
                scene.add_label("/path/B", "B", anchor="center-left"),
            )
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
        keeper = frame.simulation.keeper
        if keeper is None or keeper.home.tolist() == self._home:
            return
        self._home = keeper.home.tolist()
        way = frame.simulation.way
        self._line.points = np.stack([way[:-1], way[1:]], axis=1).astype(np.float32)
        for label, point, side in zip(self._labels, way[[0, -1]], (-1.0, 1.0), strict=False):
            label.position = point + np.array([0.0, 0.07 * side, 0.0])


STAY: Final = (60, 0.08)
"""Points in the trace of a hand near its place, and simulated time between them [s]."""

TRAVEL: Final = (140, 0.12)
"""The same for a long path: two laps, or there and back."""


class Trace(StagePart):
    def __init__(self, scene: viser.SceneApi, arm: Arm, travels: bool) -> None:
        self._arm, (self._count, self._period) = arm, TRAVEL if travels else STAY
        self._points: deque[Array] = deque(maxlen=self._count)
        self._time = -np.inf
        self._home: list[float] | None = None
        # Of constant length: the browser fails while the numbers of points and colours differ.
        line = np.zeros((self._count - 1, 2, 3), np.float32)
        self._line = scene.add_line_segments(
            "/trace", line, (0, 0, 0), thickness=3, thickness_units="screen", visible=False
        )
        self.nodes = (self._line,)

    def dress(self, page: PageSettings) -> None:
        palette = PALETTES[page.theme]
        bottom, error = (np.array(c, float) for c in (palette.background[1], rgb(palette.error)))
        share = np.linspace(0.15, 1.0, self._count)[:, None]
        fade = (bottom + (error - bottom) * share).round().astype(np.uint8)
        self._line.colors = np.stack([fade[:-1], fade[1:]], axis=1)

    def show(self, frame: Frame) -> None:
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
