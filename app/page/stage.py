"""The stage: room, light, both arms, the line between their closest points, the place to hold, and the hand's trace."""

from collections import deque
from typing import Final

import numpy as np
import pinocchio as pin
import viser

from app.page.arms import ArmView
from app.page.theme import PALETTES, Palette, blend, rgb, scale
from app.settings import PageSettings
from scenes.history import Sample
from scenes.rigs import Camera
from scenes.room import SIDES
from scenes.room_shells import table_glb, torso_glb
from scenes.simulation import Simulation

TRACE_POINTS: Final = 60
TRACE_PERIOD: Final = 0.08
"""Simulated time between two points of the trace [s]."""


class Stage:
    """What is seen of a simulation; nothing here can be operated.

    Args:
        scene: of one visitor, or of everybody in a lecture.
        simulation: what is shown.
        page: how it is to look.
    """

    def __init__(self, scene: viser.SceneApi, simulation: Simulation, page: PageSettings) -> None:
        self.scene = scene
        self._room: viser.GlbHandle | None = None
        self._arms: tuple[ArmView, ...] = ()
        self._built: tuple[str, ...] | None = None
        self._dressed: tuple[str, ...] | None = None
        self._trace_points: deque[np.ndarray] = deque(maxlen=TRACE_POINTS)
        self._trace_time = -np.inf
        self._width = 0.0
        line = np.zeros((1, 2, 3), np.float32)
        self._line = scene.add_line_segments("/closest/line", line, (0, 0, 0), thickness=3, thickness_units="screen")
        self._ends = [scene.add_icosphere(f"/closest/end{i}", radius=0.011, cast_shadow=False) for i in (0, 1)]
        self._label = scene.add_label("/closest/distance", "", anchor="bottom-center")
        self._place = scene.add_icosphere("/place/ball", radius=0.017, color=(255, 255, 255), opacity=0.9, cast_shadow=False)
        self._ring = scene.add_mesh_simple("/place/ring", *_ring(0.040, 0.005), color=(255, 255, 255), cast_shadow=False)
        self._error = scene.add_line_segments(
            "/place/error", line, (0, 0, 0), thickness=2, thickness_units="screen", visible=False
        )
        # Always of one length: the browser does not follow when points and colours change their number one after the other.
        trace = np.zeros((TRACE_POINTS - 1, 2, 3), np.float32)
        self._trace = scene.add_line_segments("/trace", trace, (0, 0, 0), thickness=3, thickness_units="screen", visible=False)
        self.show(simulation, simulation.sample(), page)

    def _dress(self, page: PageSettings) -> None:
        """Set everything that depends on the theme, the profile and the kind of picture."""
        scene, palette, dark, fine = self.scene, PALETTES[page.theme], page.theme == "dark", page.picture == "fine"
        top, bottom = (np.array(c, float) for c in palette.background)
        ramp = np.linspace(0.0, 1.0, 256)[:, None, None]
        scene.set_background_image(np.tile(top + (bottom - top) * ramp, (1, 8, 1)).round().astype(np.uint8), format="png")
        scene.configure_default_lights(enabled=False)
        scene.add_light_directional("/light/key", intensity=2.0, cast_shadow=fine, position=(2.4, -2.0, 4.0))
        scene.add_light_directional("/light/fill", intensity=0.7, position=(-2.5, 2.0, 2.0), color=(205, 222, 255), visible=fine)
        if fine:
            scene.configure_environment_map("studio", environment_intensity=0.42 if dark else 0.55)
        else:
            # Reflections are the dearest part of a picture drawn without a graphics card; plain light stands in for them.
            scene.configure_environment_map(None)
        scene.add_light_hemisphere(
            "/light/sky", sky_color=(255, 255, 255), ground_color=(150, 155, 165), intensity=2.2, visible=not fine
        )
        self._lay_floor(palette, fine)
        error, ink = rgb(palette.error), (40, 44, 50) if not dark else (235, 240, 245)
        self._place.color = error
        self._ring.color = error
        self._error.colors = np.tile(np.array(error, np.uint8), (1, 2, 1))
        share = np.linspace(0.15, 1.0, TRACE_POINTS)[:, None]
        fade = (bottom + (np.array(error) - bottom) * share).round().astype(np.uint8)
        self._trace.colors = np.stack([fade[:-1], fade[1:]], axis=1)
        self._scale = scale(page.profile)
        self._label.font_screen_scale = 1.15 * self._scale
        for end in self._ends:
            end.color = ink

    def _lay_floor(self, palette: Palette, fine: bool) -> None:
        if fine:
            self.scene.add_grid(
                "/floor",
                width=6,
                height=6,
                cell_size=0.1,
                section_size=0.5,
                cell_thickness=0.6,
                section_thickness=1.0,
                cell_color=palette.cell,
                section_color=palette.section,
                infinite_grid=False,
                fade_distance=6,
                fade_from="origin",
                fade_strength=1.2,
                shadow_opacity=0.3,
                plane_opacity=0.0,
            )
            return
        ticks = np.arange(-3.0, 3.01, 0.5)
        ends = np.full_like(ticks, 3.0)
        zero = np.zeros_like(ticks)
        along = np.stack([np.stack([ticks, -ends, zero], -1), np.stack([ticks, ends, zero], -1)], 1)
        lines = np.concatenate([along, along[..., [1, 0, 2]]]).astype(np.float32)
        self.scene.add_line_segments("/floor", lines, palette.section, thickness=1, thickness_units="screen")

    def _build(self, simulation: Simulation, fine: bool) -> None:
        """Put up the rig's room and arms; the guided arm is orange, the avoiding one silver."""
        if self._room is not None:
            self._room.remove()
        for arm in self._arms:
            arm.remove()
        rig, guided = simulation.room.rig, simulation.settings.guided
        self._room = self.scene.add_glb(
            "/room", torso_glb(coarse=not fine) if rig.name == "torso" else table_glb(coarse=not fine)
        )
        self._arms = tuple(
            ArmView(self.scene, f"/arms/{side}", base, "orange" if side == guided else "silver", fine)
            for side, base in zip(SIDES, (rig.left_base, rig.right_base), strict=True)
        )

    def show(self, simulation: Simulation, sample: Sample, page: PageSettings) -> None:
        """Draw one state; called by the frame loop, or once at the start."""
        look = page.theme, page.profile, page.picture
        if self._dressed != look:
            self._dress(page)
            self._dressed = look
        built = simulation.settings.rig, simulation.settings.guided, page.picture
        if self._built != built:
            self._build(simulation, page.picture == "fine")
            self._built = built
            self.clear_trace()
        positions = simulation.positions
        for arm, view in zip(simulation.room.arms, self._arms, strict=True):
            view.show(positions[arm.joints])
        self._show_closest(simulation, sample, page)
        self._show_place(simulation)

    def clear_trace(self) -> None:
        """Forget where the hand has been."""
        self._trace_points.clear()
        self._trace_time = -np.inf
        self._trace.visible = False

    def _show_closest(self, simulation: Simulation, sample: Sample, page: PageSettings) -> None:
        a, b = simulation.detector.witness_points(sample.pair)
        self._line.points = np.array([[a, b]], np.float32)
        for end, point in zip(self._ends, (a, b), strict=True):
            end.position = point
        palette, lam = PALETTES[page.theme], sample.activation
        self._line.colors = np.tile(np.array(blend(palette.calm, palette.activation, lam), np.uint8), (1, 2, 1))
        # The width is the second cue of λ: 2 px when the law is idle, 8 px when avoidance has full priority.
        width = round((2.0 + 6.0 * lam) * self._scale * 2.0) / 2.0
        if width != self._width:
            self._line.thickness = self._width = width
        self._label.position = (a + b) / 2.0 + np.array([0.0, 0.0, 0.06])
        text = f"d = {sample.distance * 1000.0:.0f} mm"
        if text != self._label.text:
            self._label.text = text

    def _show_place(self, simulation: Simulation) -> None:
        hand = simulation.kinematics.hand_pose(simulation.avoiding).translation
        place = simulation.place
        if tuple(place) != tuple(self._place.position):
            self._place.position = self._ring.position = place
            turn = pin.Quaternion(simulation.place_rotation)
            self._ring.wxyz = (turn.w, turn.x, turn.y, turn.z)
            self.clear_trace()
        away = float(np.linalg.norm(hand - place))
        self._error.visible = away > 0.004
        if away > 0.004:
            self._error.points = np.array([[place, hand]], np.float32)
        if simulation.time < self._trace_time:
            self.clear_trace()
        if simulation.time - self._trace_time < TRACE_PERIOD:
            return
        self._trace_time = simulation.time
        points = self._trace_points
        if not points:
            points.extend([hand.copy()] * TRACE_POINTS)
        points.append(hand.copy())
        way = np.array(points, np.float32)
        moved = float(np.ptp(way, axis=0).max()) > 0.004
        if moved:
            self._trace.points = np.stack([way[:-1], way[1:]], axis=1)
        if moved != self._trace.visible:
            self._trace.visible = moved


def place_camera(client: viser.ClientHandle, camera: Camera, covered: float) -> None:
    """Move a client's camera so that everything the view must show is in the free part of its canvas.

    Args:
        covered: share of the canvas' height, at its bottom, that a panel covers.
    """
    slope = float(np.tan(camera.fov / 2.0))
    distance = max(camera.height / (1.0 - covered), camera.width / max(client.camera.aspect, 0.2)) / (2.0 * slope)
    toward = np.array(camera.toward) / np.linalg.norm(camera.toward)
    right = np.cross([0.0, 0.0, 1.0], toward)
    up = np.cross(toward, right / np.linalg.norm(right))
    # Looking below the middle lifts it out of the part that is covered.
    target = np.array(camera.centre) - up * (distance * slope * covered)
    client.camera.up_direction = (0.0, 0.0, 1.0)
    client.camera.position = target + toward * distance
    client.camera.look_at = target
    client.camera.fov = camera.fov


def _ring(radius: float, tube: float) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (k, 3) and faces (m, 3) of a torus about z [m]."""
    rounds, sides = 40, 8
    u, v = np.meshgrid(np.arange(rounds), np.arange(sides), indexing="ij")
    a, b = 2.0 * np.pi * u / rounds, 2.0 * np.pi * v / sides
    r = radius + tube * np.cos(b)
    vertices = np.stack([r * np.cos(a), r * np.sin(a), tube * np.sin(b)], axis=-1).reshape(-1, 3)
    corner = lambda i, j: (i % rounds) * sides + j % sides  # noqa: E731
    p, q, s, t = corner(u, v), corner(u + 1, v), corner(u + 1, v + 1), corner(u, v + 1)
    faces = np.concatenate([np.stack([p, q, s], -1).reshape(-1, 3), np.stack([p, s, t], -1).reshape(-1, 3)])
    return vertices.astype(np.float32), faces.astype(np.uint32)
