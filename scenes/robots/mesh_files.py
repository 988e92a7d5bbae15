"""Triangles in mesh files."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from controllers.kinematics import Array

if TYPE_CHECKING:
    import trimesh


def mesh_pieces(path: Path, checked: bool = False) -> Iterator[tuple[Array, NDArray[np.int64], Array]]:
    """Vertices (k, 3), faces (l, 3) and colour (3,) in 0 … 255 of every mesh in a file, in the file's frame.

    Args:
        checked: for users' files: apply the unit of the format (COLLADA, 3MF), turn mirrored parts outside
            again, and refuse corners that are not finite.

    Raises:
        ValueError: see `checked`; and as trimesh.
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
    import trimesh

    named = piece.metadata.get("units")
    unit = trimesh.units.unit_conversion(named, "meters") if named else 1.0
    if not 0.0 < unit < np.inf:
        raise ValueError(f"its unit is {named}")
    return unit
