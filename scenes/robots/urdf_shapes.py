"""The shapes in a URDF file as triangles: of solid shapes, in metres, with their normals outwards."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from controllers.errors import BadInputFile, first_line
from controllers.kinematics import Array
from scenes.robots.urdf_tree import Box, Cylinder, MeshFile, Pill, ShapeForm, Sphere

if TYPE_CHECKING:
    import trimesh

ROUND: Final = 24
"""Sections of a cylinder in a URDF file."""

THIN: Final = 0.001
"""Thickness of a shape that its file makes flat [m]."""

MENDED: Final = 20_000
"""Triangles of a mesh up to which its faces are turned to one side, if some are turned otherwise."""

GREY: Final = np.full(3, 200.0)
"""Colour of what has none, 0 … 255."""


def form_meshes(form: ShapeForm, files: Mapping[str, Path]) -> Iterator[tuple[trimesh.Trimesh, Array]]:
    """Yield the meshes of a shape in its own frame [m] with their colours (3,) in 0 … 255.

    Args:
        files: name of a mesh, as in the URDF → its file.

    Raises:
        BadInputFile: a mesh cannot be read, or has nothing solid in it.
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
            # A scale below zero turns the mesh inside out.
            turned = faces[:, ::-1] if np.prod(scale) < 0.0 else faces
            mesh = trimesh.Trimesh(vertices * scale, turned, process=False)
            area += float(mesh.area)
            if len(faces):
                yield _outward(mesh), colour
        if not area > 0.0:
            raise ValueError("no triangles in it")
    except Exception as error:
        # trimesh's readers raise nearly every kind there is.
        raise BadInputFile("{name}: cannot be read ({reason}).", name=path, reason=first_line(error)) from None


def _outward(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """The mesh with its faces to the outside: a file may have it inside out."""
    # Of an open shell only its writer knows which side is the outer one.
    if len(mesh.faces) <= MENDED and mesh.is_watertight and not mesh.is_winding_consistent:
        mesh.fix_normals(multibody=True)
    corners = np.asarray(mesh.triangles) - np.asarray(mesh.vertices).mean(axis=0)
    volume = float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()) / 6.0
    if volume < -1e-6 * float(np.linalg.norm(mesh.extents)) ** 3:
        mesh.invert()
    return mesh


def mesh_pieces(path: Path, checked: bool = False) -> Iterator[tuple[Array, NDArray[np.int64], Array]]:
    """Yield of every mesh in a file: its vertices in the frame of the file (k, 3), its faces (l, 3), its colour (3,) in 0 … 255.

    Args:
        checked: for files of others: the unit in the file counts, where its format has one (COLLADA, 3MF), what is mirrored in the file
            is turned outside again, and corners that are not at a number are an error.

    Raises:
        ValueError: see `checked`; and what trimesh raises.
    """
    import trimesh

    # What a reader has to say about a file is in its exception.
    logging.getLogger("trimesh").setLevel(logging.CRITICAL)
    scene = trimesh.load_scene(str(path), process=not checked)
    for node in scene.graph.nodes_geometry:
        placement, key = scene.graph[node]
        piece = scene.geometry[key]
        if not isinstance(piece, trimesh.Trimesh):
            continue
        if checked:
            # Processing leaves out triangles with such corners.
            if not (np.isfinite(piece.vertices).all() and np.isfinite(placement).all()):
                raise ValueError("a corner is not at a number")
            piece.process()
        visual: Any = piece.visual
        colour = (getattr(visual, "material", None) or visual).main_color[:3]
        vertices, faces = trimesh.transform_points(piece.vertices, placement), np.asarray(piece.faces)
        if checked:
            vertices = _unit(piece) * vertices
            faces = faces[:, ::-1] if np.linalg.det(placement[:3, :3]) < 0.0 else faces
        yield vertices, faces, np.asarray(colour, float)


def _unit(piece: trimesh.Trimesh) -> float:
    """The unit of the numbers in a mesh's file [m]."""
    import trimesh

    named = piece.metadata.get("units")
    unit = trimesh.units.unit_conversion(named, "meters") if named else 1.0
    if not 0.0 < unit < np.inf:
        raise ValueError(f"its unit is {named}")
    return unit
