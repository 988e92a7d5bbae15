"""The 3-D view, rebuilt when the experiment changes."""

import numpy as np
import viser

from app.session.frame import Frame
from app.settings import PageSettings
from app.stage.arms import ArmView, TranslucentArms, ghost_posture
from app.stage.balance_view import BalanceView, balance_of
from app.stage.ball_view import BallView
from app.stage.contact_view import ClosestLine, ContactSkin
from app.stage.hand_marks import GripMark, PathLine, TargetPlace, Trace
from app.stage.person_figure import FigureView
from app.stage.stage_part import KeepFree, StagePart
from app.stage.touch_view import TouchedPoints
from app.stage.wall_view import WallView
from app.theme import PALETTES, Palette
from scenes.room_shells import furniture_glb
from scenes.simulation import Simulation


def light_room(scene: viser.SceneApi, page: PageSettings) -> None:
    """Set background, lights and floor; may be called again."""
    palette, dark, fine = PALETTES[page.theme], page.theme == "dark", page.picture == "fine"
    top, bottom = (np.array(c, float) for c in palette.background)
    ramp = np.linspace(0.0, 1.0, 256)[:, None, None]
    scene.set_background_image(
        np.tile(top + (bottom - top) * ramp, (1, 8, 1)).round().astype(np.uint8), format="png"
    )
    scene.configure_default_lights(enabled=False)
    scene.add_light_directional("/light/key", intensity=2.0, cast_shadow=fine, position=(2.4, -2.0, 4.0))
    scene.add_light_directional(
        "/light/fill", intensity=0.7, position=(-2.5, 2.0, 2.0), color=(205, 222, 255), visible=fine
    )
    if fine:
        scene.configure_environment_map("studio", environment_intensity=0.42 if dark else 0.55)
    else:
        # Reflections are the most expensive part without a graphics card; plain light replaces them.
        scene.configure_environment_map(None)
    scene.add_light_hemisphere(
        "/light/sky", sky_color=(255, 255, 255), ground_color=(150, 155, 165), intensity=2.2, visible=not fine
    )
    _lay_floor(scene, palette, fine)


def _lay_floor(scene: viser.SceneApi, palette: Palette, fine: bool) -> None:
    if fine:
        scene.add_grid(
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
    scene.add_line_segments("/floor", lines, palette.section, thickness=1, thickness_units="screen")


Yours = ArmView | BallView | FigureView


class Stage:
    def __init__(self, scene: viser.SceneApi) -> None:
        self.scene = scene
        self.yours: Yours | None = None
        """What the visitor can move; changes with the experiment."""
        self.other: ArmView | None = None
        """The arm that keeps its place, if it can be held, too."""
        self.wall: WallView | None = None
        """The wall, which the visitor can also move."""
        self.keep_free: KeepFree | None = None
        """See `StagePart`."""
        self._room: tuple[viser.GlbHandle, ...] = ()
        self._arms: tuple[ArmView, ...] = ()
        self._parts: tuple[StagePart, ...] = ()
        self._built: tuple[object, ...] | None = None
        self._lit: tuple[str, ...] | None = None
        self._dressed: tuple[object, ...] | None = None

    def show(self, frame: Frame, page: PageSettings, withheld: bool = False) -> None:
        """Draw a frame. `withheld`: see `StagePart`."""
        simulation = frame.simulation
        if self._lit != (page.theme, page.picture):
            self._lit = page.theme, page.picture
            light_room(self.scene, page)
        settings = simulation.settings
        built = id(simulation.room), settings.scene, settings.guided, settings.path, page.picture
        if self._built != built:
            self._built = built
            # Remove a part attached to an arm before the arm.
            for one in (*self._parts, *self._arms, *self._room):
                one.remove()
            self._parts = self._arms = self._room = ()
            self._build(simulation, page.picture == "fine")
            self._dressed = None
        look = page.theme, page.profile, page.contact
        if self._dressed != look:
            self._dressed = look
            for part in self._parts:
                part.dress(page)
        positions = simulation.positions
        for arm, view in zip(simulation.room.arms, self._arms, strict=True):
            view.show(positions[arm.joints])
        for part in self._parts:
            part.withheld, part.keep_free = withheld, self.keep_free
            part.show(frame)

    def _build(self, simulation: Simulation, fine: bool) -> None:
        room, experiment = simulation.room, simulation.settings.experiment
        self._room = (self.scene.add_glb("/room", furniture_glb(room.rig, coarse=not fine)),)
        yours = simulation.guided if room.ball is None else None
        self._arms = tuple(
            ArmView(
                self.scene, f"/arms/{arm.name}", base, "orange" if arm is yours else "silver", fine, made.key
            )
            for arm, base, made in zip(room.arms, room.rig.bases, room.robots, strict=True)
        )
        views = {arm.name: view for arm, view in zip(room.arms, self._arms, strict=True)}
        self.yours = None if yours is None else views[yours.name]
        self.other = views[simulation.avoiding.name] if experiment.for_two else None
        parts: list[StagePart] = [
            ContactSkin(self.scene, room, self._arms),
            ClosestLine(self.scene),
            TouchedPoints(self.scene),
        ]
        if self.yours is not None and experiment.moves != "person":
            parts.append(GripMark(self.scene))
        if self.other is not None:
            parts.append(GripMark(self.scene, other=True))
        if simulation.keeper is not None:
            parts.append(TargetPlace(self.scene))
        moving = len(simulation.way) > 0
        if experiment.moves != "person":
            parts.append(Trace(self.scene, simulation.avoiding, moving))
        if moving:
            parts.append(PathLine(self.scene, simulation.way))
        if room.ball is not None:
            self.yours = BallView(self.scene, room, self._arms[0])
            parts.append(self.yours)
        self.wall = None if room.wall is None else WallView(self.scene, room)
        if self.wall is not None:
            parts.append(self.wall)
        if (balance := balance_of(simulation)) is not None:
            parts.append(BalanceView(self.scene, balance))
        if any(mover.desired is not None for mover in simulation.roles.tasks):
            # q_d of the followers.
            parts.append(TranslucentArms(self.scene, "wish", fine, lambda frame: frame.sample.desired))
        parts.append(TranslucentArms(self.scene, "ghost", fine, ghost_posture))
        if experiment.moves == "person":
            self.yours = FigureView(self.scene)
            parts.append(self.yours)
        self._parts = tuple(parts)
