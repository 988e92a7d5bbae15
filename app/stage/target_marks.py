"""Marks of targets: the place where a hand should be, and the point by which an arm is pulled."""

from typing import Final

import numpy as np
import viser

from app.session.frame import Frame
from app.settings import PageSettings
from app.stage.contact_view import grid_faces
from app.stage.stage_part import StagePart, fresh, quaternion
from app.theme import BRAND, PALETTES, rgb, scale
from controllers.kinematics import Array
from scenes.targets import LinkTarget, PairTarget

AWAY: Final = 0.004
"""From this distance on the line to the hand is drawn [m]."""

RADIUS: Final = 0.085
"""Of the ring [m]: the hand of each of our robots fits through it …"""

TUBE: Final = 0.006
"""… and this is half its thickness [m]."""


class TargetPlace(StagePart):
    """For an arm that draws its hand to a place."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._ball = scene.add_icosphere(
            "/place/ball", radius=0.017, subdivisions=2, color=(255, 255, 255), opacity=0.9, cast_shadow=False
        )
        ring = scene.add_mesh_simple("/place/ring", *_ring(RADIUS, TUBE), color=(255, 255, 255), cast_shadow=False)
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
        """Draw the place of the arm with the task that is shown."""
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
    """Return vertices (k, 3) and faces (m, 3) of a torus about z [m]."""
    rounds, sides = 40, 8
    u, v = np.meshgrid(np.arange(rounds), np.arange(sides), indexing="ij")
    a, b = 2.0 * np.pi * u / rounds, 2.0 * np.pi * v / sides
    r = radius + tube * np.cos(b)
    vertices = np.stack([r * np.cos(a), r * np.sin(a), tube * np.sin(b)], axis=-1).reshape(-1, 3)
    corners = np.arange(u.size).reshape(u.shape)
    return vertices.astype(np.float32), grid_faces(np.vstack([corners, corners[:1]]))


WHITE: Final = (255, 255, 255)
"""Seen on the orange arm in either theme."""


class GripMark(StagePart):
    """Seen while a link is pulled, also in a replay. `of_guest`: of the arm that a second person holds."""

    def __init__(self, scene: viser.SceneApi, of_guest: bool = False) -> None:
        line, name = np.zeros((1, 2, 3), np.float32), "/guest_grip" if of_guest else "/grip"
        self._of_guest = of_guest
        self._line = scene.add_line_segments(f"{name}/line", line, BRAND, thickness=2, thickness_units="screen", visible=False)
        look = {"subdivisions": 2, "cast_shadow": False, "visible": False}
        self._point = scene.add_icosphere(f"{name}/point", radius=0.018, color=WHITE, **look)
        self._place = scene.add_icosphere(f"{name}/place", radius=0.009, color=BRAND, **look)
        self.nodes = (self._line, self._point, self._place)

    def dress(self, page: PageSettings) -> None:
        self._line.thickness = 2.0 * scale(page.profile)

    def show(self, frame: Frame) -> None:
        """Draw the pull."""
        target, simulation = frame.target, frame.simulation
        if isinstance(target, PairTarget):
            target = target.second if self._of_guest else target.first
        elif self._of_guest:
            target = None
        for node in self.nodes:
            node.visible = isinstance(target, LinkTarget)
        if isinstance(target, LinkTarget):
            arm = simulation.avoiding if self._of_guest else simulation.guided
            placement = simulation.kinematics.data.oMi[arm.joint(target.joint)]
            point = placement.act(target.offset)
            self._point.position, self._place.position = point, target.position
            self._line.points = np.array([[point, target.position]], np.float32)
