"""URDF shapes as triangles with outward normals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from app.features.robot_files.urdf_tree import Box, Cylinder, MeshFile, Pill, ShapeForm, Sphere
from controllers.errors import BadInputFile, first_line
from controllers.kinematics import Array
from scenes.robots.mesh_files import mesh_pieces

if TYPE_CHECKING:
    import trimesh

ROUND: Final = 24

THIN: Final = 0.001
"""Thickness of a flat shape [m]."""

MENDED: Final = 20_000
"""Most triangles of a mesh that is repaired."""

GREY: Final = np.full(3, 200.0)
"""Default colour, 0 … 255."""


def form_meshes(form: ShapeForm, files: Mapping[str, Path]) -> Iterator[tuple[trimesh.Trimesh, Array]]:
    """Meshes in the shape's own frame [m], with colours (3,) in 0 … 255. `files`: name in the URDF → mesh
    file.

    Raises:
        BadInputFile: unreadable, or nothing solid in it.
    """
    import trimesh

    if isinstance(form, MeshFile):
        yield from _file_meshes(files[form.filename], np.array(form.scale))
        return
    match form:
        case Box(size):
            made = trimesh.creation.box([side or THIN for side in size])
        case Cylinder(radius, length):
            made = trimesh.creation.cylinder(radius, length or THIN, sections=ROUND)
        case Sphere(radius):
            made = trimesh.creation.icosphere(subdivisions=3, radius=radius)
        case Pill(radius, length):
            made = trimesh.creation.capsule(length, radius, count=(ROUND, ROUND))
    yield made, GREY


def _file_meshes(path: Path, scale: Array) -> Iterator[tuple[trimesh.Trimesh, Array]]:
    import trimesh

    area = 0.0
    try:
        for vertices, faces, colour in mesh_pieces(path, checked=True):
            # A negative scale turns the mesh inside out.
            turned = faces[:, ::-1] if np.prod(scale) < 0.0 else faces
            mesh = trimesh.Trimesh(vertices * scale, turned, process=False)
            area += float(mesh.area)
            if len(faces):
                yield _outward(mesh), colour
        if not area > 0.0:
            raise ValueError("no triangles in it")
    except Exception as error:
        # trimesh's readers raise nearly every kind of exception.
        raise BadInputFile(
            "{name}: cannot be read ({reason}).", name=path, reason=first_line(error)
        ) from None


def _outward(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    # For an open shell only its author knows which side is outside.
    if len(mesh.faces) <= MENDED and mesh.is_watertight and not mesh.is_winding_consistent:
        mesh.fix_normals(multibody=True)
    corners = np.asarray(mesh.triangles) - np.asarray(mesh.vertices).mean(axis=0)
    volume = float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()) / 6.0
    if volume < -1e-6 * float(np.linalg.norm(mesh.extents)) ** 3:
        mesh.invert()
    return mesh
