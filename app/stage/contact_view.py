"""The contact: closest points, their distance, and λ on the arms."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import coal
import numpy as np
import pinocchio as pin
import viser
from numpy.typing import NDArray

from app.i18n.speaking import tr
from app.session.frame import Frame
from app.settings import PageSettings
from app.stage.arms import ArmView
from app.stage.stage_part import LABEL_TEXT, StagePart, fresh, quaternion
from app.theme import PALETTES, Palette, Rgb, blend, rgb, scale
from app.web.pages import PageAssets
from controllers.kinematics import Array
from scenes.quantities import DISTANCE, quantity_of_pair
from scenes.room import Room
from scenes.simulation import Simulation

LABEL_ABOVE: Final = 0.02
"""Height of the number above the line [m]."""


class ClosestLine(StagePart):
    """Hidden if nothing is near; `contact_look.js` draws it through everything else."""

    def __init__(self, scene: viser.SceneApi) -> None:
        line = np.zeros((1, 2, 3), np.float32)
        self._line = scene.add_line_segments(
            "/closest/line", line, (0, 0, 0), thickness=3, thickness_units="screen", visible=False
        )
        self._ends = [
            scene.add_icosphere(
                f"/closest/end{i}", radius=0.011, subdivisions=2, cast_shadow=False, visible=False
            )
            for i in (0, 1)
        ]
        self._label = scene.add_label("/closest/distance", "", anchor="bottom-center", visible=False)
        self.nodes = (self._line, *self._ends, self._label)
        self._colour: Rgb | None = None

    def dress(self, page: PageSettings) -> None:
        self._colour = None
        self._on, self._palette, self._scale = page.contact, PALETTES[page.theme], scale(page.profile)
        self._label.font_screen_scale = 1.15 * self._scale
        for end in self._ends:
            end.color = rgb(self._palette.ink)

    def show(self, frame: Frame) -> None:
        sample = frame.sample
        seen = self._on and sample.pair >= 0
        for node in self.nodes:
            node.visible = seen
        if not seen:
            return
        a, b = frame.simulation.detector.witness_points(sample.pair)
        self._line.points = np.array([[a, b]], np.float32)
        for end, point in zip(self._ends, (a, b), strict=True):
            end.position = point
        lam = 0.0 if self.withheld else sample.activation
        overlap = sample.distance < 0.0
        colour = shown_colour(self._palette, lam, overlap)
        if colour != self._colour:
            self._colour = colour
            self._line.colors = np.array(colour, np.uint8)
        # The width is the second cue of λ: 3 px when the law is idle, 10 px when avoidance has full priority.
        self._line.thickness = round((3.0 + 7.0 * lam) * self._scale * 2.0) / 2.0
        mm = sample.distance * 1000.0
        kept = quantity_of_pair(frame.simulation.settings.quantity, sample.pair)
        # The word is the second cue of an overlap, after its colour.
        bodies = overlap and kept is DISTANCE
        said = f"{-mm:.0f} {tr('mm of overlap')}" if bodies else f"{kept.symbol} = {mm:.0f} {kept.page_unit}"
        self._label.text = said.replace("-", "−")
        place = (a + b) / 2.0 + np.array([0.0, 0.0, LABEL_ABOVE])
        if self.keep_free is not None:
            place, _ = self.keep_free(place, label_size(said, self._scale))
        self._label.position = place


def label_size(text: str, k: float) -> tuple[float, float]:
    """Largest width and height of a label [CSS px]. `k`: text scale."""
    return k * LABEL_TEXT[0] * (len(text) + 1), k * LABEL_TEXT[1]


def shown_colour(palette: Palette, share: float, overlap: bool) -> Rgb:
    """Colour for λ = `share`, or of an alarm while bodies overlap."""
    return rgb(palette.approach) if overlap else blend(palette.calm, palette.activation, share)


FADE: Final = 0.35
"""Wall time in which a skin appears or disappears [s]."""

LEVELS: Final = 48
"""Steps of colour, opacity and tint from λ = 0 to 1; small changes send nothing."""

SIDES: Final = 28

ROUND: Final = 8
"""Possible sides for "d_m"."""

RIM_EVERY: Final = 8
"""Frames between checks of the place of "d_m"."""

LABEL_SCALE: Final = 1.15
"""Text size relative to viser's."""

RINGS: Final = 8
"""Rings from a capsule's pole to its cylinder."""


def contact_assets() -> PageAssets:
    """Script of skins, line and tint."""
    return PageAssets(
        (Path(__file__).with_name("contact_look.js"),), constants={"tint": PALETTES["light"].activation}
    )


@dataclass
class _Shell:
    """A capsule or sphere around a body, made once.

    `growth`: additional radius around a body [m]; `weight`: 0 hidden … 1 visible.
    """

    handle: viser.MeshHandle
    growth: float
    weight: float = 0.0


class ContactSkin(StagePart):
    """Visible near a contact, if the page's settings ask for it.

    Skin and capsules are children of the drawn links, so that moving them sends nothing; `contact_look.js`
    draws them as rims. `arms`: in the room's order.
    """

    def __init__(self, scene: viser.SceneApi, room: Room, arms: tuple[ArmView, ...]) -> None:
        self._scene, self._room = scene, room
        self._links = [
            (arm.shoulder - made.shoulder, made.model.nv, view)
            for arm, made, view in zip(room.arms, room.robots, arms, strict=True)
        ]
        self._shells: dict[tuple[int, str], _Shell] = {}
        # "d_m" on the rim of the bubble around the obstacle, also a child of the link.
        self._rims: dict[int, viser.LabelHandle] = {}
        # Invisible: the script tints each arm by the x of its node, which is λ.
        self._tints = [fresh(scene.add_frame(f"/tint/{arm.name}", show_axes=False)) for arm in room.arms]
        self.nodes = self._tints
        self._around: dict[int, int] = {}
        self._unchanged = 0
        self._obstacle: int | None = None
        self._now: float | None = None
        self._drawn: tuple[object, ...] = ()

    def dress(self, page: PageSettings) -> None:
        self._on, self._palette = page.contact, PALETTES[page.theme]
        self._label_scale = LABEL_SCALE * scale(page.profile)
        for label in self._rims.values():
            label.font_screen_scale = self._label_scale
        self._drawn = ()

    def show(self, frame: Frame) -> None:
        simulation, sample = frame.simulation, frame.sample
        seen = self._on and sample.pair >= 0
        share = 0.0 if self.withheld else round(sample.activation * LEVELS) / LEVELS
        overlap = sample.distance < 0.0
        state = seen, sample.pair, share, overlap, simulation.settings
        if state == self._drawn:
            self._now = frame.now
            self._unchanged += 1
            if self._unchanged % RIM_EVERY == 0:
                self._keep_rim_free(simulation)
            return
        avoiding = avoiding_arms(simulation) if seen else ()
        for arm, tint in zip(self._room.arms, self._tints, strict=True):
            tint.position = (share if arm.name in avoiding else 0.0, 0.0, 0.0)
        wanted: dict[tuple[int, str], float] = {}
        self._obstacle = None
        if seen and self._room.meets_bodies:
            avoider, obstacle = bodies_of_pair(simulation, sample.pair)
            self._obstacle = obstacle
            wanted = {
                (obstacle, "skin"): simulation.settings.law.critical_distance,
                (obstacle, "capsule"): 0.0,
                (avoider, "capsule"): 0.0,
            }
        fade = 1.0 if self._now is None else min(abs(frame.now - self._now) / FADE, 1.0)
        self._now = frame.now
        colour = shown_colour(self._palette, share, overlap)
        for key, growth in wanted.items():
            shell = self._shell(key, growth, colour)
            shell.weight = min(shell.weight + fade, 1.0)
            shell.handle.color = colour
        for key, shell in self._shells.items():
            if key not in wanted:
                shell.weight = max(shell.weight - fade, 0.0)
            full = 0.12 + 0.3 * share if key[1] == "skin" else 0.6 if overlap else 0.16
            shell.handle.visible = shell.weight > 0.0
            shell.handle.opacity = round(full * shell.weight, 3)
            if key[1] == "skin":
                self._rim(key[0], shell.growth).visible = key in wanted
        fades = any(shell.weight != float(key in wanted) for key, shell in self._shells.items())
        self._drawn = () if fades else state
        self._keep_rim_free(simulation)

    def _keep_rim_free(self, simulation: Simulation) -> None:
        """Move the rim's label if it is clipped; hide it if it is clipped everywhere."""
        keep_free, index = self.keep_free, self._obstacle
        if keep_free is None or index is None or index not in self._rims:
            return
        body, label = self._room.geometry.geometryObjects[index], self._rims[index]
        world = simulation.kinematics.data.oMi[body.parentJoint] * body.placement
        present, radius = (
            self._around.get(index, 0),
            body.geometry.radius + self._shells[index, "skin"].growth,
        )
        k = self._label_scale / LABEL_SCALE

        def is_free(side: int) -> bool:
            return keep_free(world * (radius * sideways(side)), label_size(label.text, k))[1]

        # The present side is tried first, so that the label seldom moves.
        side = next((side for side in (present, *range(ROUND)) if is_free(side)), None)
        label.visible = side is not None
        if side is not None and side != present:
            self._around[index] = side
            self._rim(index, self._shells[index, "skin"].growth)

    def _shell(self, key: tuple[int, str], growth: float, colour: Rgb) -> _Shell:
        body = self._room.geometry.geometryObjects[key[0]]
        shell = self._shells.get(key)
        if shell is None:
            node, placement = self._node(body)
            handle = self._scene.add_mesh_simple(
                f"{node}/{key[1]}_of_{body.name.replace(' ', '_')}",
                *capsule_mesh(body.geometry, growth),
                color=colour,
                opacity=0.0,
                cast_shadow=False,
                receive_shadow=False,
                wxyz=quaternion(placement.rotation),
                position=tuple(placement.translation.tolist()),
            )
            shell = self._shells[key] = _Shell(fresh(handle), growth)
            self.nodes = [*self.nodes, handle]
        elif shell.growth != growth:
            shell.growth = growth
            shell.handle.vertices = capsule_mesh(body.geometry, growth)[0]
        return shell

    def _rim(self, index: int, growth: float) -> viser.LabelHandle:
        body = self._room.geometry.geometryObjects[index]
        node, placement = self._node(body)
        place = tuple(
            (placement * ((body.geometry.radius + growth) * sideways(self._around.get(index, 0)))).tolist()
        )
        label = self._rims.get(index)
        if label is None:
            label = self._scene.add_label(
                f"{node}/rim_around_{body.name.replace(' ', '_')}", "d_m", position=place, visible=False
            )
            label.font_screen_scale = self._label_scale
            self._rims[index] = label
            self.nodes = [*self.nodes, fresh(label)]
        elif tuple(label.position) != place:
            label.position = place
        return label

    def _node(self, body: pin.GeometryObject) -> tuple[str, pin.SE3]:
        for offset, joints, view in self._links:
            if 0 < body.parentJoint - offset <= joints:
                return view.link(body.parentJoint - offset), body.placement
        return ("/ball", pin.SE3.Identity()) if body.name == "ball" else ("/contact", body.placement)


def sideways(side: int) -> Array:
    """Unit vector (3,) across the axis of a body."""
    angle = 2.0 * np.pi * side / ROUND
    return np.array([np.cos(angle), np.sin(angle), 0.0])


def avoiding_arms(simulation: Simulation) -> tuple[str, ...]:
    columns = [task.joints for task in simulation.roles.avoiders(simulation.settings.avoid)]
    return tuple(arm.name for arm in simulation.room.arms if arm.joints in columns)


def bodies_of_pair(simulation: Simulation, pair: int) -> tuple[int, int]:
    """Indices of the avoiding body and of the obstacle; if both avoid, the visitor's is the obstacle."""
    pairs, avoiding = simulation.detector.geometry.collisionPairs[pair], avoiding_arms(simulation)
    side = simulation.detector.pair_names[pair][0].split(" ")[0]
    if side == "control":  # "control point at the hand": of the only arm.
        side = simulation.guided.name
    first_avoids = side in avoiding and not (len(avoiding) > 1 and side == simulation.guided.name)
    return (pairs.first, pairs.second) if first_avoids else (pairs.second, pairs.first)


def capsule_mesh(
    shape: coal.CollisionGeometry, growth: float
) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """Vertices (k, 3) and faces (m, 3) of a capsule about z, or of a sphere, grown by `growth` [m]."""
    radius = shape.radius + growth
    half = shape.halfLength if isinstance(shape, coal.Capsule) else 0.0
    polar = np.linspace(0.0, np.pi / 2.0, RINGS + 1)
    polar = np.concatenate([polar, np.pi - polar[::-1]])
    around = np.linspace(0.0, 2.0 * np.pi, SIDES, endpoint=False)
    p, a = np.meshgrid(polar, around, indexing="ij")
    height = radius * np.cos(p) + np.where(np.arange(len(polar)) <= RINGS, half, -half)[:, None]
    vertices = np.stack([radius * np.sin(p) * np.cos(a), radius * np.sin(p) * np.sin(a), height], axis=-1)
    return vertices.reshape(-1, 3).astype(np.float32), grid_faces(np.arange(a.size).reshape(a.shape))


def grid_faces(corners: NDArray[np.int64]) -> NDArray[np.uint32]:
    """Faces (m, 3) of a surface. `corners`: vertex indices (rows, around); rows are closed."""
    p, q = corners[:-1], corners[1:]
    s, t = np.roll(q, -1, axis=1), np.roll(p, -1, axis=1)
    return np.concatenate([np.stack(face, axis=-1).reshape(-1, 3) for face in ((p, q, s), (p, s, t))]).astype(
        np.uint32
    )
