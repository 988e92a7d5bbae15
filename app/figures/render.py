"""A picture of a scene: perspective, smooth shading by two lights with the shadow of the first, a floor, and 2 × 2 supersampling.

Everything is computed in linear light and turned into sRGB at the end (IEC 61966-2-1). World frame: z up, the floor at z = 0, metres.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, map_coordinates

from app.figures.raster import Integers, rasterise, weights
from app.theme import PALETTES
from controllers.kinematics import Array
from scenes.rigs import Camera

Picture = NDArray[np.uint8]

SAMPLES: Final = 2
"""Samples per pixel along each side."""

NEAR: Final = 0.05
"""Triangles with a corner nearer to the eye than this are not drawn [m]."""

KEY: Final = np.array([2.4, -2.0, 4.0]) / np.linalg.norm([2.4, -2.0, 4.0])
FILL: Final = np.array([-2.5, 2.0, 2.0]) / np.linalg.norm([-2.5, 2.0, 2.0])
"""Directions towards the two lights."""

KEY_LIGHT: Final = np.array([1.55, 1.50, 1.42])
FILL_LIGHT: Final = np.array([0.26, 0.32, 0.42])
SKY: Final = np.array([0.50, 0.54, 0.60])
GROUND: Final = np.array([0.17, 0.165, 0.16])
"""Colours of the lights, of the half of the room above, and of the half below; linear."""

BACKGROUND: Final = (np.array(PALETTES["light"].background) / 255.0) ** 2.2
"""Of the room, far away and near the eye (2, 3); linear, near enough."""

FLOOR_CELL: Final = 0.5
FLOOR_END: Final = 3.4
"""Distance between the floor's lines, and where they have faded [m]."""

SHADOW_SIZE: Final = 900
"""Side of the shadow map [pixels]."""

MARGIN: Final = 0.1
"""Around everything in the shadow map [m]."""

SHADOW_BIAS: Final = 0.006
"""What is less than this behind the surface that the light sees is lit [m]."""


@dataclass(frozen=True)
class Mesh:
    """Something to draw, in the world frame.

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
        """Return the mesh turned by (3, 3) and then shifted by (3,)."""
        vertices, normals = self.vertices @ rotation.T + shift, self.normals @ rotation.T
        return Mesh(vertices, normals, self.faces, self.colour, self.roughness, self.metallic)


class Viewpoint:
    """From where one looks, and how large the picture is.

    Args:
        camera: what must be seen, and from which side.
        width, height: of the picture [pixels].
    """

    def __init__(self, camera: Camera, width: int, height: int) -> None:
        self.width, self.height = width, height
        slope = float(np.tan(camera.fov / 2.0))
        away = max(camera.height, camera.width * height / width) / (2.0 * slope)
        backward = np.array(camera.toward) / np.linalg.norm(camera.toward)
        right = np.cross([0.0, 0.0, 1.0], backward)
        right /= np.linalg.norm(right)
        self.axes = np.stack([right, -np.cross(backward, right), -backward])
        """Rows: to the right, down and forward in the picture, in the world."""
        self.eye: Array = np.array(camera.centre) + backward * away
        self.focal = height / (2.0 * slope)
        """Focal length [pixels]."""

    def project(self, points: Array) -> tuple[Array, Array]:
        """Return places in the picture (n, 2) [pixels] and depths (n,) [m] of points (n, 3) in the world."""
        local = (points - self.eye) @ self.axes.T
        depth = local[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            flat = local[:, :2] / depth[:, None] * self.focal + np.array([self.width / 2.0, self.height / 2.0])
        return flat, depth


class _Shadow:
    """What the first light sees, looking straight along its direction."""

    def __init__(self, vertices: Array, faces: Integers) -> None:
        side = np.cross([0.0, 0.0, 1.0], KEY)
        side /= np.linalg.norm(side)
        self._axes = np.stack([side, np.cross(KEY, side), KEY])
        local = vertices @ self._axes.T
        low, high = local.min(0), local.max(0)
        self._low = low[:2] - MARGIN
        self._scale = (SHADOW_SIZE - 2) / (float((high - low)[:2].max()) + 2.0 * MARGIN)
        # Nearness must be positive, and is in metres here.
        self._lift = 1.0 - low[2]
        place = (local[:, :2] - self._low) * self._scale
        self._map = rasterise(place, local[:, 2] + self._lift, faces, SHADOW_SIZE, SHADOW_SIZE)

    def on_floor(self, points: Array, blur: float) -> Array:
        """Return how dark (k,) the shadow of everything is at points (k, 3) behind it, blurred by about `blur` [m]."""
        place = (points @ self._axes.T)[:, :2]
        place = (place - self._low) * self._scale - 0.5
        dark = gaussian_filter((self._map.nearness > 0.0).astype(float), blur * self._scale)
        return map_coordinates(dark, place.T[::-1], order=1, mode="constant")

    def light(self, points: Array, blur: float) -> Array:
        """Return the share of the light (k,) that reaches points (k, 3) of the meshes, averaged over a disc of radius `blur` [m]."""
        local = points @ self._axes.T
        place, height = (local[:, :2] - self._low) * self._scale, local[:, 2] + self._lift + SHADOW_BIAS
        lit = np.zeros(len(points))
        angles = np.arange(12) * 2.39996  # The golden angle spreads the samples evenly.
        radii = np.sqrt((np.arange(12) + 0.5) / 12.0) * blur * self._scale
        for angle, radius in zip(angles, radii, strict=True):
            at = (place + radius * np.array([np.cos(angle), np.sin(angle)])).astype(np.int64)
            lit += self._map.nearness[at[:, 1], at[:, 0]] <= height
        return lit / 12.0


def render(meshes: Sequence[Mesh], camera: Camera, width: int = 640, height: int = 420) -> Picture:
    """Return the picture (height, width, 3), sRGB.

    Args:
        meshes: at least one.
        camera: see `Viewpoint`.
        width, height: [pixels].
    """
    view = Viewpoint(camera, width * SAMPLES, height * SAMPLES)
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    faces = np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)])
    shadow = _Shadow(vertices, faces)
    points, depth = view.project(vertices)
    shown = (depth > NEAR)[faces].all(1)
    nearness = 1.0 / np.maximum(depth, NEAR)
    # A copy with fewer faces keeps the number of the mesh that each one came from.
    mesh_of = np.repeat(np.arange(len(meshes)), [len(mesh.faces) for mesh in meshes])[shown]
    faces = faces[shown]
    seen = rasterise(points, nearness, faces, view.width, view.height)
    light = np.zeros((view.height, view.width, 3))
    rows, columns = np.nonzero(seen.face >= 0)
    if len(rows):
        share = weights(points, nearness, faces, seen, rows, columns)[..., None]
        corner = faces[seen.face[rows, columns]]
        normals = np.concatenate([mesh.normals for mesh in meshes])
        normal = (normals[corner] * share).sum(1)
        place = (vertices[corner] * share).sum(1)
        light[rows, columns] = _surface(meshes, mesh_of[seen.face[rows, columns]], normal, place, view.eye, shadow)
    # What is behind the meshes has no edges: one sample a pixel will do.
    room = _room(Viewpoint(camera, width, height), shadow).repeat(SAMPLES, 0).repeat(SAMPLES, 1)
    light = np.where((seen.face >= 0)[..., None], light, room)
    light = light.reshape(height, SAMPLES, width, SAMPLES, 3).mean((1, 3))
    return (_srgb(light) * 255.0 + 0.5).astype(np.uint8)


def _surface(meshes: Sequence[Mesh], owner: Integers, normal: Array, place: Array, eye: Array, shadow: _Shadow) -> Array:
    """Return the light (k, 3) from surfaces towards the eye: Lambert and Blinn–Phong, and a soft reflection of the room."""
    colour = np.array([mesh.colour for mesh in meshes])[owner]
    rough = np.array([mesh.roughness for mesh in meshes])[owner][:, None]
    metal = np.array([mesh.metallic for mesh in meshes])[owner][:, None]
    sight = eye - place
    sight /= np.linalg.norm(sight, axis=1, keepdims=True)
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    # A smooth normal may lean away from the eye at an outline.
    facing = (normal * sight).sum(1, keepdims=True)
    shine = 0.04 * (1.0 - metal) + colour * metal
    diffuse = colour * (1.0 - metal)
    power = 2.0 / np.maximum(rough, 0.1) ** 4 + 2.0
    total = diffuse * (GROUND + (SKY - GROUND) * (0.5 + 0.5 * normal[:, 2:]))
    for towards, light, lit in ((KEY, KEY_LIGHT, shadow.light(place + 0.004 * normal, 0.006)), (FILL, FILL_LIGHT, None)):
        lambert = np.maximum(normal @ towards, 0.0)[:, None]
        half = sight + towards
        half /= np.linalg.norm(half, axis=1, keepdims=True)
        gloss = np.maximum((normal * half).sum(1, keepdims=True), 0.0) ** power * (power + 8.0) / 25.0
        arriving = lambert * light if lit is None else lambert * light * lit[:, None]
        total += arriving * (diffuse + shine * gloss)
    mirrored = 2.0 * facing * normal - sight
    fresnel = shine + (1.0 - shine) * (1.0 - np.minimum(np.maximum(facing, 0.0), 1.0)) ** 5 * (1.0 - rough) ** 2
    return total / 1.3 + fresnel * _studio(mirrored[:, 2:])


def _studio(up: Array) -> Array:
    """Return the light (k, 3) that a mirror shows of the room, by the height (k, 1) of where it looks: a bright ceiling."""
    ramp = np.minimum(np.maximum((up + 0.15) / 0.9, 0.0), 1.0)
    ramp = ramp * ramp * (3.0 - 2.0 * ramp)
    return GROUND * 0.5 + (1.25 * SKY - GROUND * 0.5) * ramp


def _room(view: Viewpoint, shadow: _Shadow) -> Array:
    """Return the light (height, width, 3) of the floor with its lines and the shadow on it, and of the wall far away."""
    share = ((np.arange(view.height) + 0.5) / view.height)[:, None, None] ** 1.5
    light = np.tile(BACKGROUND[0] + (BACKGROUND[1] - BACKGROUND[0]) * share, (1, view.width, 1))
    right, low, ahead = view.axes
    x = (np.arange(view.width) + 0.5 - view.width / 2.0) / view.focal
    y = (np.arange(view.height) + 0.5 - view.height / 2.0) / view.focal
    sink = -(ahead[2] + x * right[2] + (y * low[2])[:, None])
    down = sink > 1e-6
    depth = view.eye[2] / sink[down]
    rows, columns = np.nonzero(down)
    sight = [ahead[i] + x[columns] * right[i] + y[rows] * low[i] for i in range(2)]
    place = np.stack([view.eye[0] + sight[0] * depth, view.eye[1] + sight[1] * depth, np.zeros(len(depth))], -1)
    fade = np.minimum(np.maximum(1.0 - np.hypot(place[:, 0], place[:, 1]) / FLOOR_END, 0.0), 1.0)
    # A line is as wide as it is there, but never thinner than a pixel, which would flicker.
    line = np.zeros(len(place))
    wide = np.maximum(0.0022, 0.9 * depth / view.focal / np.maximum(sink[down], 0.15))
    for axis in (0, 1):
        off = np.abs(place[:, axis] / FLOOR_CELL - np.round(place[:, axis] / FLOOR_CELL)) * FLOOR_CELL
        line = np.maximum(line, np.maximum(1.0 - off / wide, 0.0) * np.minimum(0.0035 / wide, 1.0))
    dark = shadow.on_floor(place, 0.022) * fade
    light[down] *= ((1.0 - 0.42 * line * np.sqrt(fade)) * (1.0 - 0.33 * dark))[:, None]
    return light


def _srgb(light: Array) -> Array:
    """Return display values of linear light, the brightest bent down softly instead of cut off."""
    knee = 0.8
    over = np.maximum(light - knee, 0.0)
    light = np.minimum(light, knee) + (1.0 - knee) * (1.0 - np.exp(-over / (1.0 - knee)))
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1.0 / 2.4) - 0.055)
