"""The stage: room, light, arms, and whatever else an experiment shows; it is put up anew when the experiment changes."""

from typing import Protocol

import viser

from app.settings import PageSettings
from app.stage.arms import ArmView, robot_of
from app.stage.ball_view import BallView
from app.stage.closest_line import ClosestLine
from app.stage.ghost import GhostView, WishView
from app.stage.hand_path import PathLine
from app.stage.hand_trace import STAY, TRAVEL, Trace
from app.stage.person_figure import FigureView
from app.stage.room_light import light_room
from app.stage.target_place import TargetPlace
from controllers.kinematics import Array
from scenes.history import Sample
from scenes.rigs import ALONE, Rig
from scenes.room_shells import table_glb, torso_glb
from scenes.simulation import Simulation


class StagePart(Protocol):
    """Something on the stage."""

    def dress(self, page: PageSettings) -> None:
        """Take on a theme and a profile."""
        ...

    def show(self, simulation: Simulation, sample: Sample) -> None:
        """Draw a state."""
        ...

    def remove(self) -> None:
        """Take it out of the scene."""
        ...


def furniture_glb(rig: Rig, coarse: bool) -> bytes:
    """Return what the arms of a rig stand on; coarse for a browser without a graphics card."""
    if rig.name == "torso":
        return torso_glb(coarse=coarse)
    if rig is ALONE:
        return table_glb(-2.0 * float(ALONE.left_base.translation[0]), coarse=coarse, plates=1)
    return table_glb(coarse=coarse)


class Stage:
    """What is seen of a simulation; nothing here can be operated.

    Args:
        scene: of one visitor, or of everybody in a lecture.
    """

    def __init__(self, scene: viser.SceneApi) -> None:
        self.scene = scene
        self._room: viser.GlbHandle | None = None
        self._arms: tuple[ArmView, ...] = ()
        self._parts: tuple[StagePart, ...] = ()
        self._ghost: GhostView | None = None
        self._figure: FigureView | None = None
        self._built: tuple[object, ...] | None = None
        self._lit: tuple[str, ...] | None = None
        self._dressed: tuple[str, ...] | None = None

    def show(
        self,
        simulation: Simulation,
        sample: Sample,
        page: PageSettings,
        ghost: Simulation | None = None,
        angles: Array | None = None,
    ) -> None:
        """Draw one state; called by the frame loop, or once at the start.

        Args:
            simulation: what is shown.
            sample: its newest step.
            page: how it is to look.
            ghost: a second run beside it.
            angles: of the person who is imitated (2, 4) [rad]; None while nobody is seen.
        """
        if self._lit != (page.theme, page.picture):
            self._lit = page.theme, page.picture
            light_room(self.scene, page)
        settings = simulation.settings
        built = id(simulation.room), settings.scene, settings.guided, settings.path, page.picture
        if self._built != built:
            self._built = built
            self._clear()
            self._build(simulation, page.picture == "fine")
            self._dressed = None
        look = page.theme, page.profile
        if self._dressed != look:
            self._dressed = look
            for part in self._parts:
                part.dress(page)
            if self._figure is not None:
                self._figure.dress(page)
        positions = simulation.positions
        for arm, view in zip(simulation.room.arms, self._arms, strict=True):
            view.show(positions[arm.joints])
        for part in self._parts:
            part.show(simulation, sample)
        if self._ghost is not None:
            if ghost is not None and ghost.room is simulation.room:
                self._ghost.show(simulation, ghost.positions)
            else:
                self._ghost.remove()
        if self._figure is not None:
            self._figure.show(angles)

    def _clear(self) -> None:
        if self._room is not None:
            self._room.remove()
            self._room = None
        # Whatever hangs on an arm goes before it.
        for part in self._parts:
            part.remove()
        for arm in self._arms:
            arm.remove()
        if self._ghost is not None:
            self._ghost.remove()
        if self._figure is not None:
            self._figure.remove()
        self._parts, self._arms, self._ghost, self._figure = (), (), None, None

    def _build(self, simulation: Simulation, fine: bool) -> None:
        """Put up the room with its arms; what is yours is orange, everything else is silver."""
        room, settings, coarse = simulation.room, simulation.settings, not fine
        self._room = self.scene.add_glb("/room", furniture_glb(room.rig, coarse))
        yours = simulation.guided if room.ball is None else None
        self._arms = tuple(
            ArmView(self.scene, f"/arms/{arm.name}", base, "orange" if arm is yours else "silver", fine, robot_of(simulation))
            for arm, base in zip(room.arms, room.bases(), strict=True)
        )
        parts: list[StagePart] = [ClosestLine(self.scene)]
        if simulation.place is not None:
            parts.append(TargetPlace(self.scene))
        moving = settings.scene == "ball" or (settings.scene == "solo" and settings.path == "circle")
        if settings.scene != "imitation":
            parts.append(Trace(self.scene, "/trace", simulation.avoiding, TRAVEL if moving else STAY))
        if moving:
            parts.append(PathLine(self.scene, circle=settings.scene == "solo"))
        if room.ball is not None:
            parts.append(BallView(self.scene, room, self._arms[0]))
        if any(mover.desired is not None for mover in simulation.roles.tasks):
            parts.append(WishView(self.scene, fine))
        self._parts = tuple(parts)
        self._ghost = GhostView(self.scene, "ghost", fine)
        if settings.scene == "imitation":
            self._figure = FigureView(self.scene)
