"""Meshes of a room: the links of the arms at their joint positions, and the furniture."""

import io
from functools import cache

import numpy as np
import pinocchio as pin
import trimesh

from app.figures.render import Mesh
from controllers.kinematics import Array
from scenes.glb import Palette
from scenes.lwr.shells import PALETTES, link_glbs
from scenes.room import Room
from scenes.room_shells import MATERIALS, table_glb, torso_glb


def meshes(blob: bytes, palette: Palette) -> tuple[Mesh, ...]:
    """Return the parts of a GLB in its own frame, each with the material of its name."""
    scene = trimesh.load(io.BytesIO(blob), file_type="glb", process=False)
    assert isinstance(scene, trimesh.Scene)
    return tuple(
        Mesh(
            np.array(part.vertices, float),
            np.array(part.vertex_normals, float),
            np.array(part.faces, np.int64),
            np.array(palette[name].linear()[:3]),
            palette[name].roughness,
            palette[name].metallic,
        )
        for name, part in scene.geometry.items()
        if isinstance(part, trimesh.Trimesh)
    )


@cache
def links(palette: str) -> tuple[tuple[Mesh, ...], ...]:
    """Return the parts of links 0 … 7, each in its link's frame."""
    return tuple(meshes(blob, PALETTES[palette]) for blob in link_glbs(palette))


def furniture(room: Room) -> tuple[Mesh, ...]:
    """Return the bench or the torso."""
    # The length of a bench is the distance between its arms; a single arm has the place of the left one.
    separation = 0.0 if room.rig.name == "torso" else 2.0 * abs(float(room.bases()[0].translation[0]))
    return _furniture(separation)


@cache
def _furniture(separation: float) -> tuple[Mesh, ...]:
    return meshes(table_glb(separation) if separation else torso_glb(), MATERIALS)


def arms(room: Room, positions: Array, palettes: tuple[str, ...]) -> list[Mesh]:
    """Return the arms at q (nv,) [rad].

    Args:
        palettes: of each arm, by name, left first.
    """
    data = room.model.createData()
    pin.forwardKinematics(room.model, data, np.ascontiguousarray(positions))
    drawn: list[Mesh] = []
    for arm, robot, base, palette in zip(room.arms, room.robots, room.bases(), palettes, strict=True):
        before = arm.shoulder - robot.shoulder
        poses = [base, *(data.oMi[before + i] for i in range(1, robot.model.njoints))]
        for parts, pose in zip(links(palette), poses, strict=True):
            drawn += [part.moved(pose.rotation, pose.translation) for part in parts]
    return drawn


def ball(centre: Array, radius: float, colour: Array) -> Mesh:
    """Return a sphere.

    Args:
        centre: (3,) [m].
        radius: [m].
        colour: (3,), linear.
    """
    sphere = trimesh.creation.icosphere(subdivisions=4, radius=1.0)
    normals = np.array(sphere.vertices, float)
    return Mesh(centre + radius * normals, normals, np.array(sphere.faces, np.int64), colour, 0.45)
