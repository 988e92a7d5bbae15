"""Pictures of a scene by ray casting.

trimesh casts the rays, with embreex if installed. Colours are linear until the last step, sRGB
(IEC 61966-2-1). World frame: z up, the floor at z = 0, metres.
"""

import io
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Final

import numpy as np
import pinocchio as pin
import trimesh
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from app import theme
from app.stage.camera_view import axes, pose_of, project
from controllers.kinematics import Array
from scenes.glb import GlbPalette
from scenes.lwr.shells import PALETTES
from scenes.rigs import Camera
from scenes.robots.drawing import robot_glbs
from scenes.room import Room
from scenes.room_shells import MATERIALS, furniture_glb

Integers = NDArray[np.int64]

SAMPLES: Final = 2

KEY: Final = np.array([2.4, -2.0, 4.0]) / np.linalg.norm([2.4, -2.0, 4.0])
FILL: Final = np.array([-2.5, 2.0, 2.0]) / np.linalg.norm([-2.5, 2.0, 2.0])

KEY_LIGHT: Final = np.array([1.55, 1.50, 1.42])
FILL_LIGHT: Final = np.array([0.26, 0.32, 0.42])
SKY: Final = np.array([0.50, 0.54, 0.60])
GROUND: Final = np.array([0.17, 0.165, 0.16])
"""Linear colours of lights and surroundings."""

BACKGROUND: Final = (np.array(theme.PALETTES["light"].background) / 255.0) ** 2.2
"""Far and near (2, 3); approximately linear."""

FLOOR_CELL: Final = 0.5
FLOOR_END: Final = 3.4
"""Spacing of the floor's lines, and distance at which they have faded [m]."""

SHADOW_LIFT: Final = 0.003
"""Offset of a shadow ray above its surface [m]."""

LIGHT_RADIUS: Final = 0.025
"""Angular radius of the first light [rad]."""


@dataclass(frozen=True)
class Mesh:
    """A mesh in the world frame.

    Attributes:
        vertices: (n, 3) [m].
        normals: (n, 3), unit.
        faces: (m, 3).
        colour: (3,), linear.
        roughness: 0 mirror … 1 chalk.
        metallic: 0 paint … 1 bare metal.
    """

    vertices: Array
    normals: Array
    faces: Integers
    colour: Array
    roughness: float = 0.5
    metallic: float = 0.0

    def moved(self, rotation: Array, shift: Array) -> "Mesh":
        """Rotated by (3, 3), then shifted by (3,)."""
        return replace(self, vertices=self.vertices @ rotation.T + shift, normals=self.normals @ rotation.T)


class Viewpoint:
    """Camera of a picture of `width` × `height` [pixels]."""

    def __init__(self, camera: Camera, width: int, height: int) -> None:
        self.width, self.height = width, height
        self._pose = pose_of(camera, width / height)
        self.eye = self._pose.eye
        right, up, back = axes(np.array(camera.toward))
        self.axes = np.stack([right, -up, -back])
        """Rows: right, down and forward, in world coordinates."""
        self.focal = height / (2.0 * math.tan(camera.fov / 2.0))
        """Focal length [pixels]."""

    def directions(self) -> Array:
        """Unit vectors (height × width, 3) through the pixel centres, row by row, world frame."""
        x, y = np.meshgrid(
            np.arange(self.width) + 0.5 - self.width / 2.0, np.arange(self.height) + 0.5 - self.height / 2.0
        )
        local = np.stack([x, y, np.full_like(x, self.focal)], -1).reshape(-1, 3)
        return local @ self.axes / np.linalg.norm(local, axis=1, keepdims=True)

    def project(self, points: Array) -> Array:
        """Pixels (n, 2) of world points (n, 3) in front of the eye."""
        return project(self._pose, (self.width, self.height), points)


def render(
    meshes: Sequence[Mesh], camera: Camera, width: int, height: int, samples: int = SAMPLES
) -> NDArray[np.uint8]:
    """Picture (height, width, 3), sRGB.

    Args:
        meshes: at least one.
        width, height: [pixels].
        samples: per pixel along each side.
    """
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)])
    scene = trimesh.Trimesh(np.concatenate([mesh.vertices for mesh in meshes]), faces, process=False)
    view = Viewpoint(camera, width * samples, height * samples)
    sight = view.directions()
    hit = scene.ray.intersects_first(np.broadcast_to(view.eye, sight.shape), sight)
    shown = np.flatnonzero(hit >= 0)
    # The floor has no edges: one sample a pixel is enough.
    light = (
        _room(Viewpoint(camera, width, height), scene).repeat(samples, 0).repeat(samples, 1).reshape(-1, 3)
    )
    if len(shown):
        face, sight = hit[shown], sight[shown]
        corners, plane = scene.triangles[face], scene.face_normals[face]
        away = ((corners[:, 0] - view.eye) * plane).sum(1) / (sight * plane).sum(1)
        place = view.eye + away[:, None] * sight
        share = trimesh.triangles.points_to_barycentric(corners, place)[..., None]
        normal = (np.concatenate([mesh.normals for mesh in meshes])[faces[face]] * share).sum(1)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
        owner = np.repeat(np.arange(len(meshes)), [len(mesh.faces) for mesh in meshes])[face]
        lit = np.zeros(len(place))
        facing = normal @ KEY > 0.0
        lit[facing] = _lit(scene, place[facing] + SHADOW_LIFT * normal[facing], 3)
        light[shown] = _surface(meshes, owner, normal, -sight, lit)
    light = light.reshape(height, samples, width, samples, 3).mean((1, 3))
    return (_srgb(light) * 255.0 + 0.5).astype(np.uint8)


def _lit(scene: trimesh.Trimesh, points: Array, rays: int) -> Array:
    """Share (k,) of the first light that reaches points (k, 3)."""
    side = np.cross([0.0, 0.0, 1.0], KEY) / np.linalg.norm(KEY[:2])
    angles = np.arange(rays) * 2.39996  # The golden angle spreads the samples evenly.
    radii = LIGHT_RADIUS * np.sqrt((np.arange(rays) + 0.5) / rays)
    lit = np.zeros(len(points))
    for angle, radius in zip(angles, radii, strict=True):
        towards = KEY + radius * (np.cos(angle) * side + np.sin(angle) * np.cross(KEY, side))
        lit += ~scene.ray.intersects_any(points, np.broadcast_to(towards, points.shape))
    return lit / rays


def _surface(meshes: Sequence[Mesh], owner: Integers, normal: Array, sight: Array, lit: Array) -> Array:
    """Light (k, 3) from surfaces towards the eye: Lambert, Blinn–Phong, and soft reflection.

    Args:
        owner: (k,), index of the mesh.
        normal, sight: (k, 3), unit; `sight` points to the eye.
        lit: (k,), share of the first light.
    """
    colour = np.array([mesh.colour for mesh in meshes])[owner]
    rough = np.array([mesh.roughness for mesh in meshes])[owner][:, None]
    metal = np.array([mesh.metallic for mesh in meshes])[owner][:, None]
    # A smooth normal may point away from the eye at an outline.
    facing = (normal * sight).sum(1, keepdims=True)
    shine = 0.04 * (1.0 - metal) + colour * metal
    diffuse = colour * (1.0 - metal)
    power = 2.0 / np.maximum(rough, 0.1) ** 4 + 2.0
    total = diffuse * (GROUND + (SKY - GROUND) * (0.5 + 0.5 * normal[:, 2:]))
    for towards, light in ((KEY, KEY_LIGHT * lit[:, None]), (FILL, FILL_LIGHT)):
        lambert = np.maximum(normal @ towards, 0.0)[:, None]
        half = sight + towards
        half /= np.linalg.norm(half, axis=1, keepdims=True)
        gloss = np.maximum((normal * half).sum(1, keepdims=True), 0.0) ** power * (power + 8.0) / 25.0
        total += lambert * light * (diffuse + shine * gloss)
    mirrored = 2.0 * facing * normal - sight
    fresnel = (
        shine + (1.0 - shine) * (1.0 - np.minimum(np.maximum(facing, 0.0), 1.0)) ** 5 * (1.0 - rough) ** 2
    )
    return total / 1.3 + fresnel * _studio(mirrored[:, 2:])


def _studio(up: Array) -> Array:
    """Light (k, 3) of a bright ceiling. `up`: height (k, 1) of the reflected direction."""
    ramp = np.minimum(np.maximum((up + 0.15) / 0.9, 0.0), 1.0)
    ramp = ramp * ramp * (3.0 - 2.0 * ramp)
    return GROUND * 0.5 + (1.25 * SKY - GROUND * 0.5) * ramp


def _room(view: Viewpoint, scene: trimesh.Trimesh) -> Array:
    """Light (height, width, 3) of the floor, its lines and shadow, and the distant wall."""
    share = ((np.arange(view.height) + 0.5) / view.height)[:, None, None] ** 1.5
    light = np.tile(BACKGROUND[0] + (BACKGROUND[1] - BACKGROUND[0]) * share, (1, view.width, 1))
    sight = view.directions()
    down = sight[:, 2] < -1e-6
    sight = sight[down]
    depth = -view.eye[2] / sight[:, 2]
    place = view.eye + depth[:, None] * sight
    fade = np.clip(1.0 - np.hypot(place[:, 0], place[:, 1]) / FLOOR_END, 0.0, 1.0)
    # A line has its true width, but at least one pixel, which avoids flicker.
    wide = np.maximum(0.0022, 0.9 * depth / view.focal / np.maximum(-sight[:, 2], 0.15))[:, None]
    off = np.abs(place[:, :2] / FLOOR_CELL - np.round(place[:, :2] / FLOOR_CELL)) * FLOOR_CELL
    line = (np.maximum(1.0 - off / wide, 0.0) * np.minimum(0.0035 / wide, 1.0)).max(1)
    # No shadow is outside the rectangle of all vertices' shadows.
    cast = scene.vertices[:, :2] - scene.vertices[:, 2:] / KEY[2] * KEY[:2]
    near = (fade > 0.0) & ((cast.min(0) - 0.1 <= place[:, :2]) & (place[:, :2] <= cast.max(0) + 0.1)).all(1)
    shadow = np.zeros(view.height * view.width)
    shadow[np.flatnonzero(down)[near]] = 1.0 - _lit(scene, place[near], 4)
    dark = gaussian_filter(shadow.reshape(view.height, view.width), view.width / 200.0).ravel()[down] * fade
    light.reshape(-1, 3)[down] *= ((1.0 - 0.42 * line * np.sqrt(fade)) * (1.0 - 0.33 * dark))[:, None]
    return light


def _srgb(light: Array) -> Array:
    """sRGB values; the brightest are compressed, not clipped."""
    knee = 0.8
    over = np.maximum(light - knee, 0.0)
    light = np.minimum(light, knee) + (1.0 - knee) * (1.0 - np.exp(-over / (1.0 - knee)))
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1.0 / 2.4) - 0.055)


def meshes(blob: bytes, palette: GlbPalette) -> tuple[Mesh, ...]:
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
def links(palette: str, robot: str) -> tuple[tuple[Mesh, ...], ...]:
    """Base and links, each in its joint's frame."""
    return tuple(meshes(blob, PALETTES[palette]) for blob in robot_glbs(robot, palette))


def furniture(room: Room) -> tuple[Mesh, ...]:
    return _furniture(furniture_glb(room.rig, coarse=False))


@cache
def _furniture(blob: bytes) -> tuple[Mesh, ...]:
    return meshes(blob, MATERIALS)


def arms(room: Room, positions: Array, palettes: tuple[str, ...]) -> list[Mesh]:
    """Arms at q (nv,) [rad]. `palettes`: of each arm, left first."""
    data = room.model.createData()
    pin.forwardKinematics(room.model, data, np.ascontiguousarray(positions))
    drawn: list[Mesh] = []
    for arm, robot, base, palette in zip(room.arms, room.robots, room.rig.bases, palettes, strict=True):
        before = arm.shoulder - robot.shoulder
        poses = [base, *(data.oMi[before + i] for i in range(1, robot.model.njoints))]
        for parts, pose in zip(links(palette, robot.key), poses, strict=True):
            drawn += [part.moved(pose.rotation, pose.translation) for part in parts]
    return drawn


def ball(centre: Array, radius: float, colour: Array) -> Mesh:
    """Sphere about `centre` (3,) [m] of `radius` [m], with a linear `colour` (3,)."""
    sphere = trimesh.creation.icosphere(subdivisions=4, radius=1.0)
    normals = np.array(sphere.vertices, float)
    return Mesh(centre + radius * normals, normals, np.array(sphere.faces, np.int64), colour, 0.45)
