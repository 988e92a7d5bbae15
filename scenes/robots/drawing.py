"""Appearance of the robots: GLB files and frames of the links."""

from __future__ import annotations

import functools
import importlib.metadata
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from controllers.errors import BadInputFile, DuetError, first_line
from controllers.kinematics import Array
from scenes import glb, surfaces
from scenes.given_robots import GIVEN
from scenes.lwr import facts, shells
from scenes.robots import SOURCES, robot
from scenes.robots.description import joint_axis
from scenes.robots.example_data import COLUMN_RADIUS, EXAMPLES, PACKAGE, load_example
from scenes.robots.mesh_files import mesh_pieces
from scenes.surfaces import join, revolve, rounded, swollen

if TYPE_CHECKING:
    import trimesh

TRIANGLES: Final = 30_000

COARSE_TRIANGLES: Final = 4_200

CREASE: Final = float(np.radians(35))
"""Smallest angle between faces at an edge [rad]."""

COARSE_CREASE: Final = float(np.radians(70))

SMALLEST: Final = 0.006
"""Smallest loose piece [m]."""

COARSE_SMALLEST: Final = 0.030

WELD: Final = 0.0003
"""Pitch of a grid that merges vertices [m]: slivers stop the thinning."""

COARSE_WELD: Final = 0.001

FINEST: Final = 1e-6
"""Pitch for shapes that would vanish [m]."""

HUB: Final = 0.005
"""Radius of the ball for a link without a shape [m]."""

PROUD: Final = 0.003
"""Distance of coarse pieces from the coarse body [m]."""


class JointFrame(NamedTuple):
    """Frame of a link on the link before it.

    Attributes:
        position: of its origin in the previous joint's frame (3,) [m].
        rotation: at angle 0 in that frame (w, x, y, z).
        axis: of rotation, in its own frame (3,).
    """

    name: str
    position: tuple[float, float, float]
    rotation: tuple[float, float, float, float]
    axis: tuple[float, float, float]


@functools.cache
def joint_frames(name: str) -> tuple[JointFrame, ...]:
    """Frames of a robot's joints, from the base outwards.

    Raises:
        BadSetting: as `robot`.
    """
    model = robot(name).model
    frames = []
    for joint in range(1, model.njoints):
        placement, turn = model.jointPlacements[joint], pin.Quaternion(model.jointPlacements[joint].rotation)
        position, axis = tuple(placement.translation.tolist()), tuple(joint_axis(model, joint).tolist())
        frames.append(JointFrame(model.names[joint], position, (turn.w, turn.x, turn.y, turn.z), axis))
    return tuple(frames)


@functools.cache
def robot_glbs(name: str, palette: str, coarse: bool = False) -> tuple[bytes, ...]:
    """Base and links of a robot as GLB files, in the frames of their joints.

    Args:
        palette, coarse: as in `scenes.lwr.shells`.

    Raises:
        BadSetting: as `robot`.
        ValueError: unknown palette.
    """
    # Raises the error that names what is missing.
    robot(name)
    given = GIVEN[name].sources() if name in GIVEN else ()
    sources = [*SOURCES, *given, shells.__file__, facts.__file__, glb.__file__, surfaces.__file__]
    versions = (importlib.metadata.version(PACKAGE),) if name in EXAMPLES else ()
    key = glb.source_key(sources, *versions, palette, coarse)

    def build() -> tuple[bytes, ...]:
        return tuple(shells.packed_glb(parts, palette, coarse) for parts in robot_link_meshes(name, coarse))

    return glb.cached(f"{name}-{palette}-{coarse:d}", key, build)


def draw_given(name: str) -> None:
    """Build all drawings of a given robot for the cache.

    Raises:
        BadInputFile: it cannot be drawn.
    """
    try:
        for coarse in (False, True):
            for palette in shells.PALETTES:
                robot_glbs(name, palette, coarse)
    except DuetError:
        raise
    except Exception as error:
        # Readers, thinning and shading of meshes raise nearly every kind there is on damaged ones.
        raise BadInputFile(
            "{name}: its shapes cannot be drawn ({reason}); give a robot with simpler meshes.",
            name=GIVEN[name].origin,
            reason=first_line(error),
        ) from None


@functools.cache
def robot_link_meshes(name: str, coarse: bool) -> tuple[shells.Parts, ...]:
    """Base and links: material → mesh in the joint's frame [m]. Shared: do not change them.

    Raises:
        BadSetting: as `robot`.
    """
    if name == "lwr":
        return shells.link_meshes(coarse)
    count, crease = (COARSE_TRIANGLES, COARSE_CREASE) if coarse else (TRIANGLES, CREASE)
    painted = _painted(name, *((COARSE_SMALLEST, COARSE_WELD) if coarse else (SMALLEST, WELD)))
    # Pieces without an area have no weight.
    share = count / max(
        sum(_weight(piece) for parts in painted for pieces in parts.values() for piece in pieces), 1e-12
    )
    links = [
        {
            paint: join(_creased(_thinned(piece, round(share * _weight(piece))), crease) for piece in pieces)
            for paint, pieces in parts.items()
        }
        for parts in painted
    ]
    if coarse:
        # With few triangles parts on the body would dive in and out of it.
        links = [
            {paint: part if paint == "body" else swollen(part, PROUD) for paint, part in parts.items()}
            for parts in links
        ]
    if height := GIVEN[name].column() if name in GIVEN else EXAMPLES[name].column:
        column = _column(height, 20 if coarse else 56)
        links[0]["dark"] = join([links[0]["dark"], column]) if "dark" in links[0] else column
    return tuple(links)


def _painted(name: str, smallest: float, weld: float) -> tuple[dict[str, list[trimesh.Trimesh]], ...]:
    import trimesh

    found: list[dict[str, list[trimesh.Trimesh]]] = [{} for _ in range(robot(name).model.njoints)]
    tiny: list[dict[str, list[trimesh.Trimesh]]] = [{} for _ in found]
    for joint, paint, vertices, faces in GIVEN[name].shapes() if name in GIVEN else _example_shapes(name):
        loose = _welded(vertices, faces, weld).split(only_watertight=False)
        if parts := [part for part in loose if np.linalg.norm(part.extents) > smallest]:
            found[joint].setdefault(paint, []).extend(parts)
        elif name in GIVEN:
            tiny[joint].setdefault(paint, []).append(_welded(vertices, faces, FINEST))
    if name in GIVEN:
        # Every link is a node of the scene: without large pieces it has its small ones, without any a ball.
        hub = {"body": [trimesh.creation.icosphere(subdivisions=2, radius=HUB)]}
        found = [large or small or hub for large, small in zip(found, tiny, strict=True)]
    return tuple(dict(sorted(parts.items())) for parts in found)


def _example_shapes(name: str) -> Iterator[tuple[int, str, Array, NDArray[np.int64]]]:
    """Joint, material, vertices in its frame (k, 3) and faces (l, 3) of every shape."""
    example = EXAMPLES[name]
    colours, paints = np.array(list(example.paints), float), list(example.paints.values())
    _, shapes = load_example(example, pin.GeometryType.VISUAL)
    for body in shapes.geometryObjects:
        rotation, shift = body.placement.rotation, body.placement.translation
        for vertices, faces, colour in mesh_pieces(Path(body.meshPath)):
            nearest = int(np.argmin(np.linalg.norm(colours - colour, axis=1)))
            yield body.parentJoint, paints[nearest], vertices @ rotation.T + shift, faces


def _weight(piece: trimesh.Trimesh) -> float:
    return float(piece.area**0.75 * len(piece.faces) ** 0.25)


def _welded(vertices: Array, faces: NDArray[np.int64], pitch: float) -> trimesh.Trimesh:
    """Mesh with the vertices of every grid cell at their mean."""
    import trimesh

    _, cell, count = np.unique(
        np.round(vertices / pitch).astype(np.int64), axis=0, return_inverse=True, return_counts=True
    )
    cell = cell.reshape(-1)
    means = np.column_stack([np.bincount(cell, weights=vertices[:, i]) / count for i in range(3)])
    corners = cell[faces]
    kept = corners[(corners != np.roll(corners, 1, axis=1)).all(axis=1)]
    _, first = np.unique(np.sort(kept, axis=1), axis=0, return_index=True)
    return trimesh.Trimesh(means, kept[np.sort(first)], process=False)


def _thinned(piece: trimesh.Trimesh, count: int) -> trimesh.Trimesh:
    """As `scenes.surfaces.thinned_mesh`, with about `count` triangles."""
    import fast_simplification
    import trimesh
    from scipy.spatial import KDTree

    originals, count = np.asarray(piece.vertices), max(count, 24)
    if count >= len(piece.faces):
        return piece
    vertices, faces = fast_simplification.simplify(originals, np.asarray(piece.faces), target_count=count)
    corners = KDTree(originals).query(vertices)[1][faces]
    kept = corners[(corners != np.roll(corners, 1, axis=1)).all(axis=1)]
    if not len(kept):
        return piece
    used, faces = np.unique(kept, return_inverse=True)
    return trimesh.Trimesh(originals[used], faces.reshape(-1, 3), process=False)


def _creased(piece: trimesh.Trimesh, crease: float) -> trimesh.Trimesh:
    """The mesh with doubled vertices along sharp edges: the viewer smooths over shared ones."""
    import trimesh

    smooth = trimesh.graph.smooth_shade(piece, angle=crease, facet_minarea=None)
    return surfaces.mesh(
        np.asarray(smooth.vertices), np.asarray(smooth.faces), np.asarray(smooth.vertex_normals)
    )


def _column(height: float, sections: int) -> trimesh.Trimesh:
    r, tube, plate = COLUMN_RADIUS - 0.001, COLUMN_RADIUS - 0.017, 0.012
    foot = [
        (0, 0),
        (r, 0),
        (r, plate),
        (tube, plate),
        (tube, height - plate),
        (r, height - plate),
        (r, height),
        (0, height),
    ]
    return revolve(rounded(foot, 0.002, 2), sections)
