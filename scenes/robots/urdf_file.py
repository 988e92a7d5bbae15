"""A robot from a URDF file: model, landmarks, capsules around its shapes, and the triangles that are drawn."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from controllers.errors import BadInputFile, first_line
from controllers.kinematics import Array
from scenes.robots.description import Capsule, Robot
from scenes.robots.robot_files import FILES, RobotFile, parsed
from scenes.robots.urdf_chain import chain_model, hand_frame, landmarks

if TYPE_CHECKING:
    import trimesh
    import yourdfpy

ShapeKind = Literal["visuals", "collisions"]

MOST_TRIANGLES: Final = 1_500_000
"""Of all meshes of a robot together."""

ROUND: Final = 24
"""Sections of a cylinder in a URDF file."""


@dataclass(frozen=True)
class FileArm:
    """The arm in a URDF file, without what takes long.

    Attributes:
        file: where it is from.
        urdf: as yourdfpy reads it.
        model: of the arm on its column.
        column: height of the column [m].
    """

    file: RobotFile
    urdf: yourdfpy.URDF
    model: pin.Model
    column: float

    def robot(self, capsules: tuple[Capsule, ...]) -> Robot:
        """Return the robot with its capsules."""
        labels = tuple(f"joint {i}" for i in range(1, self.model.njoints))
        name = self.file.key.rpartition("-")[0]
        return Robot(self.file.key, name, self.model, hand_frame(self.model), *landmarks(self.model), capsules, labels)


def load_arm(key: str) -> FileArm:
    """Return the arm of a file that was registered.

    Raises:
        BadInputFile: Pinocchio cannot read it.
    """
    file = FILES[key]
    urdf = parsed(file.text, str(file.path))
    model, column = chain_model(file.text, file.chain, str(file.path))
    return FileArm(file, urdf, model, column)


def solids(arm: FileArm, kind: ShapeKind) -> Iterator[tuple[int, trimesh.Trimesh, Array]]:
    """Yield every shape: joint that carries it, its mesh in the frame of that joint [m], and its colour (3,) in 0 … 255.

    Raises:
        BadInputFile: a mesh cannot be read, or there are too many triangles.
    """
    colours = {m.name: m.color.rgba for m in arm.urdf.robot.materials if m.color is not None}
    left = MOST_TRIANGLES
    for link in arm.urdf.robot.links:
        frame = arm.model.frames[arm.model.getFrameId(link.name, pin.FrameType.BODY)]
        pose = frame.placement.homogeneous
        for part in getattr(link, kind):
            paint = None
            if kind == "visuals" and part.material is not None:
                own = part.material.color
                paint = own.rgba if own is not None else colours.get(part.material.name)
            place = pose if part.origin is None else pose @ part.origin
            for mesh, colour in _meshes(arm.file, part.geometry):
                left -= len(mesh.faces)
                if left < 0:
                    raise BadInputFile(
                        "{name}: its shapes have more than {count} triangles; give a robot with simpler meshes.",
                        name=arm.file.path,
                        count=MOST_TRIANGLES,
                    )
                mesh.apply_transform(place)
                yield frame.parentJoint, mesh, colour if paint is None else 255.0 * np.asarray(paint[:3], float)


def _meshes(file: RobotFile, shape: Any) -> Iterator[tuple[trimesh.Trimesh, Array]]:
    """Yield the meshes of one shape with their colours."""
    import trimesh

    grey = np.full(3, 200.0)
    if shape is None:
        return
    if shape.box is not None:
        yield trimesh.creation.box(shape.box.size), grey
    elif shape.cylinder is not None:
        yield trimesh.creation.cylinder(shape.cylinder.radius, shape.cylinder.length, sections=ROUND), grey
    elif shape.sphere is not None:
        yield trimesh.creation.icosphere(subdivisions=3, radius=shape.sphere.radius), grey
    elif shape.mesh is not None:
        path, triangles = file.meshes[shape.mesh.filename], 0
        try:
            scale = np.ones(3) if shape.mesh.scale is None else np.broadcast_to(np.asarray(shape.mesh.scale, float), 3)
            for vertices, faces, colour in mesh_pieces(path):
                triangles += len(faces)
                yield trimesh.Trimesh(vertices * scale, faces, process=False), colour
            if not triangles:
                raise ValueError("no triangles in it")
        except Exception as error:
            # trimesh's readers raise nearly every kind there is.
            raise BadInputFile("{name}: cannot be read ({reason}).", name=path, reason=first_line(error)) from None


def mesh_pieces(path: Path) -> Iterator[tuple[Array, NDArray[np.int64], Array]]:
    """Yield of every mesh in a file: its vertices in the frame of the file (k, 3), its faces (l, 3), its colour (3,) in 0 … 255."""
    import trimesh

    scene = trimesh.load_scene(str(path))
    for node in scene.graph.nodes_geometry:
        placement, key = scene.graph[node]
        piece = scene.geometry[key]
        if isinstance(piece, trimesh.Trimesh):
            visual: Any = piece.visual
            colour = (getattr(visual, "material", None) or visual).main_color[:3]
            yield trimesh.transform_points(piece.vertices, placement), np.asarray(piece.faces), np.asarray(colour, float)


def fit_capsules(arm: FileArm) -> tuple[Capsule, ...]:
    """Return a capsule around the collision shapes of every link, of a link without any around what is drawn of it.

    The first link shares one with the base that it turns on.

    Raises:
        BadInputFile: as `solids`; or nothing has a shape.
    """
    from scenes.robots.fitting import column_rim, enclosing_capsule, swept

    model = arm.model
    shapes: list[list[Array]] = [[] for _ in range(model.njoints)]
    for joint, mesh, _ in solids(arm, "collisions"):
        shapes[joint].append(np.asarray(mesh.vertices))
    bare = {joint for joint, points in enumerate(shapes) if not points}
    if bare:
        for joint, mesh, _ in solids(arm, "visuals"):
            if joint in bare:
                shapes[joint].append(np.asarray(mesh.vertices))
    points = [np.vstack(found) if found else np.zeros((0, 3)) for found in shapes]
    if sum(map(len, points[1:])) == 0:
        raise BadInputFile("{name}: no link has a shape; capsules are fitted around them.", name=arm.file.path)
    base = [points[0]]
    if arm.column:
        base.append(column_rim(arm.column))
    if len(points[1]):
        base.append(swept(model, points[1], 1, 0))
    found: list[Capsule] = []
    if len(foot := np.vstack(base)):
        found.append(Capsule("pedestal", 0, *enclosing_capsule(foot)))
    last = max(j for j in range(model.njoints) if j == 0 or len(points[j]))
    for joint in range(2, model.njoints):
        if len(points[joint]):
            name = "hand" if joint == last else f"link {joint}"
            found.append(Capsule(name, joint, *enclosing_capsule(points[joint])))
    return tuple(found)
