"""The stage: room, light, arms, and the other parts of an experiment; it is rebuilt when the experiment changes."""

from typing import Protocol

import viser

from app.session.frame import Frame
from app.settings import PageSettings
from app.stage.arms import ArmView
from app.stage.ball_view import BallView
from app.stage.closest_line import ClosestLine
from app.stage.contact_skin import ContactSkin
from app.stage.ghost import GhostView, WishView
from app.stage.grip_mark import GripMark
from app.stage.hand_path import PathLine
from app.stage.hand_trace import STAY, TRAVEL, Trace
from app.stage.person_figure import FigureView
from app.stage.room_light import light_room
from app.stage.target_place import TargetPlace
from scenes.rigs import ALONE, Rig
from scenes.room_shells import stands_glb, table_glb, torso_glb
from scenes.simulation import Simulation


class StagePart(Protocol):
    """Something on the stage."""

    def dress(self, page: PageSettings) -> None:
        """Take on a theme and a profile."""
        ...

    def show(self, frame: Frame) -> None:
        """Draw a frame."""
        ...

    def remove(self) -> None:
        """Take it out of the scene."""
        ...


def furniture_glb(rig: Rig, coarse: bool) -> bytes:
    """Return what the arms of a rig stand on; coarse for a browser without a graphics card."""
    if rig.name == "torso":
        return torso_glb(coarse=coarse)
    if rig.name != "table":
        feet = (rig.left_base, rig.right_base)
        return stands_glb(tuple((float(x), float(y), float(z)) for x, y, z in (foot.translation for foot in feet)), coarse=coarse)
    if rig is ALONE:
        return table_glb(-2.0 * float(ALONE.left_base.translation[0]), coarse=coarse, plates=1)
    return table_glb(coarse=coarse)


class Stage:
    """Draws a simulation in 3-D; nothing here can be operated.

    Args:
        scene: of one visitor, or of an audience in a lecture.
        page: theme, profile and kind of picture.
    """

    def __init__(self, scene: viser.SceneApi, page: PageSettings) -> None:
        self.scene, self._page = scene, page
        self.yours: ArmView | BallView | FigureView | None = None
        """What the visitor can take hold of; another one with every experiment."""
        self._room: viser.GlbHandle | None = None
        self._arms: tuple[ArmView, ...] = ()
        self._parts: tuple[StagePart, ...] = ()
        self._built: tuple[object, ...] | None = None
        self._lit: tuple[str, ...] | None = None
        self._dressed: tuple[object, ...] | None = None

    def dress(self, page: PageSettings) -> None:
        """Take on a theme, a profile and a kind of picture at the next frame."""
        self._page = page

    def show(self, frame: Frame) -> None:
        page, simulation = self._page, frame.simulation
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
        look = page.theme, page.profile, page.contact
        if self._dressed != look:
            self._dressed = look
            for part in self._parts:
                part.dress(page)
        positions = simulation.positions
        for arm, view in zip(simulation.room.arms, self._arms, strict=True):
            view.show(positions[arm.joints])
        for part in self._parts:
            part.show(frame)

    def _clear(self) -> None:
        if self._room is not None:
            self._room.remove()
            self._room = None
        # A part that hangs on an arm goes before it.
        for part in self._parts:
            part.remove()
        for arm in self._arms:
            arm.remove()
        self._parts, self._arms = (), ()

    def _build(self, simulation: Simulation, fine: bool) -> None:
        """Put up the room with its arms; what is yours is orange, everything else is silver."""
        room, settings, coarse = simulation.room, simulation.settings, not fine
        self._room = self.scene.add_glb("/room", furniture_glb(room.rig, coarse))
        yours = simulation.guided if room.ball is None else None
        self._arms = tuple(
            ArmView(self.scene, f"/arms/{arm.name}", base, "orange" if arm is yours else "silver", fine, made.key)
            for arm, base, made in zip(room.arms, room.bases(), room.robots, strict=True)
        )
        self.yours = next((view for arm, view in zip(room.arms, self._arms, strict=True) if arm is yours), None)
        parts: list[StagePart] = [ContactSkin(self.scene, room, self._arms), ClosestLine(self.scene)]
        if self.yours is not None and settings.scene != "imitation":
            parts.append(GripMark(self.scene))
        if simulation.place is not None:
            parts.append(TargetPlace(self.scene))
        moving = settings.scene == "ball" or (settings.scene == "solo" and settings.path == "circle")
        if settings.scene != "imitation":
            parts.append(Trace(self.scene, "/trace", simulation.avoiding, TRAVEL if moving else STAY))
        if moving:
            parts.append(PathLine(self.scene, circle=settings.scene == "solo"))
        if room.ball is not None:
            self.yours = BallView(self.scene, room, self._arms[0])
            parts.append(self.yours)
        if any(mover.desired is not None for mover in simulation.roles.tasks):
            parts.append(WishView(self.scene, fine))
        parts.append(GhostView(self.scene, fine))
        if settings.scene == "imitation":
            self.yours = FigureView(self.scene)
            parts.append(self.yours)
        self._parts = tuple(parts)
