"""Smooth surfaces with true normals: revolved profiles and skins of implicit forms [m]."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    import trimesh

Array = NDArray[np.float64]
Form = Callable[[Array], Array]
"""Signed function of points (…, 3): negative inside, near its zero level like a distance [m]; (…,)."""

CREASE: Final = float(np.radians(32))
"""Smallest turn of a profile that stays a sharp edge [rad]."""

NORMAL_STEP: Final = 2e-4
"""Half step of the differences for a skin's normals [m]."""


def mesh(vertices: Array, faces: NDArray[np.int64], normals: Array) -> trimesh.Trimesh:
    """Mesh with exactly these vertices (n, 3), faces (m, 3) and unit normals (n, 3)."""
    # Slow to import, and not needed while the cache has every mesh.
    import trimesh

    return trimesh.Trimesh(vertices, faces, vertex_normals=normals, process=False)


def _strip(rows: int, columns: int, closed: bool) -> NDArray[np.int64]:
    """Faces (m, 3) of a row-major grid, counter-clockwise with rows going up and columns to the right."""
    row, column = np.meshgrid(
        np.arange(rows - 1), np.arange(columns if closed else columns - 1), indexing="ij"
    )
    right = (column + 1) % columns
    a, b = row * columns + column, row * columns + right
    c, d = a + columns, b + columns
    return np.stack([np.stack([a, b, d], -1), np.stack([a, d, c], -1)], -2).reshape(-1, 3)


def welded(vertices: Array, faces: NDArray[np.int64], normals: Array) -> trimesh.Trimesh:
    """As `mesh`, without degenerate faces; equal vertices with equal normals are one.

    viser 1.1.1 recomputes the normals of a GLB from faces that share a vertex: two copies of a vertex show as
    a crease.
    """
    same = np.round(np.hstack([vertices * 1e6, normals * 1e3])).astype(np.int64)
    _, first, inverse = np.unique(same, axis=0, return_index=True, return_inverse=True)
    faces = inverse.reshape(-1)[faces]
    a, b, c = (vertices[first][faces[:, i]] for i in range(3))
    faces = faces[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-12]
    used, compact = np.unique(faces, return_inverse=True)
    return mesh(vertices[first][used], compact.reshape(-1, 3), normals[first][used])


def rounded(points: ArrayLike, radius: float, steps: int = 4) -> Array:
    """Polyline (m, 2) from `points` (n, 2) with inner corners of this radius, or the largest possible."""
    corner = np.asarray(points, float)
    out = [corner[0]]
    for before, here, after in zip(corner, corner[1:], corner[2:], strict=False):
        into, onto = here - before, after - here
        length_in, length_out = np.linalg.norm(into), np.linalg.norm(onto)
        into, onto = into / length_in, onto / length_out
        turn = np.arccos(np.clip(into @ onto, -1, 1))
        if turn < 1e-3:
            out.append(here)
            continue
        cut = min(radius * np.tan(turn / 2), 0.49 * length_in, 0.49 * length_out)
        side = np.array([-into[1], into[0]]) * np.sign(into[0] * onto[1] - into[1] * onto[0])
        arc_radius = cut / np.tan(turn / 2)
        centre = here - into * cut + side * arc_radius
        for angle in np.linspace(0, turn, steps + 1):
            out.append(centre - arc_radius * (side * np.cos(angle) - into * np.sin(angle)))
    out.append(corner[-1])
    return np.array(out)


def revolve(
    profile: ArrayLike, sections: int = 56, stretch: tuple[float, float] = (0.0, 0.0)
) -> trimesh.Trimesh:
    """Revolve a profile (n, 2) of (radius, height) about the z axis; going up along it, the outside is on its
    right.

    Args:
        sections: around the axis; a multiple of 4 when stretched.
        stretch: ± shift of the four quarters in x and y [m]: a disc becomes a slab.
    """
    line = np.asarray(profile, float)
    line = line[np.r_[True, np.linalg.norm(np.diff(line, axis=0), axis=1) > 1e-9]]
    along = np.diff(line, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    outward = np.stack([along[:, 1], -along[:, 0]], 1)
    if any(stretch):
        quarter = np.linspace(0, np.pi / 2, sections // 4 + 1)
        angle = np.concatenate([quarter + k * np.pi / 2 for k in range(4)])
        corner = np.repeat(np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) * stretch, len(quarter), axis=0)
    else:
        angle = np.linspace(0, 2 * np.pi, sections, endpoint=False)
        corner = np.zeros((sections, 2))
    around = np.stack([np.cos(angle), np.sin(angle)], 1)

    def turned(radial: Array, axial: Array, shift: Array) -> Array:
        flat = radial[:, None, None] * around + shift
        return np.concatenate([flat, np.broadcast_to(axial[:, None, None], (*flat.shape[:2], 1))], -1)

    pieces = []
    start = 0
    for i in range(1, len(line)):
        if i < len(line) - 1 and along[i - 1] @ along[i] > np.cos(CREASE):
            continue
        run, face = line[start : i + 1], outward[start:i]
        normal = np.vstack([face[:1], face[:-1] + face[1:], face[-1:]])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        # A run that ends flat on the axis ends in one point, which has no side to lean to.
        on_axis = (run[:, 0] < 1e-9) & (np.abs(normal[:, 1]) > np.cos(CREASE))
        normal[on_axis] = np.stack([np.zeros(on_axis.sum()), np.sign(normal[on_axis, 1])], 1)
        vertices = turned(run[:, 0], run[:, 1], corner).reshape(-1, 3)
        normals = turned(normal[:, 0], normal[:, 1], np.zeros_like(corner)).reshape(-1, 3)
        pieces.append(welded(vertices, _strip(len(run), len(angle), closed=True), normals))
        start = i
    if all(stretch):
        pieces += [
            _lid(height, stretch, up)
            for (radius, height), up in ((line[0], -1.0), (line[-1], 1.0))
            if radius == 0
        ]
    return join(pieces)


def _lid(height: float, half: tuple[float, float], up: float) -> trimesh.Trimesh:
    x, y = half
    vertices = np.array([(-x, -y, height), (x, -y, height), (x, y, height), (-x, y, height)])
    faces = np.array([(0, 1, 2), (0, 2, 3)])
    return mesh(vertices, faces if up > 0 else faces[:, ::-1], np.tile([0.0, 0.0, up], (4, 1)))


def _first_way_out(form: Form, origins: Array, directions: Array, reach: float) -> Array:
    near, far = np.zeros(directions.shape[:-1]), np.full(directions.shape[:-1], reach)
    for _ in range(24):
        middle = (near + far) / 2
        inside = form(origins + middle[..., None] * directions) < 0
        near, far = np.where(inside, middle, near), np.where(inside, far, middle)
    return origins + near[..., None] * directions


def _fan(angle: Array, lift: Array) -> Array:
    """Directions (rows, columns, 3) at angles (rows, columns) from +x, lifted (rows,) from the horizontal."""
    flat = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], -1)
    return np.cos(lift)[:, None, None] * flat + np.sin(lift)[:, None, None] * np.array([0.0, 0, 1])


def _crowded(form: Form, spine: Array, lift: Array, columns: int, reach: float, first: float) -> Array:
    fine = first + np.linspace(0, 2 * np.pi, 361)
    outline = _first_way_out(
        form, spine[:, None], _fan(np.broadcast_to(fine, (len(spine), 361)), lift), reach
    )
    side = np.diff(outline, axis=1)
    length = np.linalg.norm(side, axis=-1)
    unit = side / np.maximum(length, 1e-9)[..., None]
    turn = np.arccos(np.clip(np.sum(unit * np.roll(unit, 1, axis=1), -1), -1, 1))
    turn = np.where(length > 1e-6, turn, 0.0)
    turn = np.mean([np.roll(turn, k, axis=1) for k in range(-4, 5)], axis=0)
    share = length / np.maximum(length.sum(1, keepdims=True), 1e-9) + 0.2 / 360
    share += 0.8 * turn / np.maximum(turn.sum(1, keepdims=True), 1e-9)
    share = (share + share[:, ::-1]) / 2
    for _ in range(2):
        share[1:-1] = (share[:-2] + 2 * share[1:-1] + share[2:]) / 4
    mass = np.cumsum(share, 1) / share.sum(1, keepdims=True)
    even = np.linspace(0, 1, columns, endpoint=False)
    return np.array([np.interp(even, np.r_[0.0, row], fine) for row in mass])


def skin(
    form: Form, spine: Array, lift: Array, columns: int, reach: float, first: float = np.pi / 2, dome: int = 0
) -> trimesh.Trimesh:
    """Skin a form from inside: a ring of rays from every point of a curve to the surface.

    Args:
        form: negative on the spine, positive at `reach` along every ray.
        spine: origins of the rings (rows, 3) [m].
        lift: angles of the rings from the horizontal (rows,), growing [rad].
        columns: rays of a ring, an even number, denser where the outline turns.
        reach: length of the rays [m].
        first: angle of the first column, on a plane of symmetry of the form [rad].
        dome: strips that close the last, horizontal ring: its half from `first` = the +y axis, turned about y
            onto the other half; no pole.
    """
    angle = _crowded(form, spine, lift, columns, reach, first)
    vertices = _first_way_out(form, spine[:, None], _fan(angle, lift), reach).reshape(-1, 3)
    faces = _strip(len(spine), columns, closed=True)
    if dome:
        half = angle[-1, : columns // 2 + 1]
        turn = np.linspace(0, np.pi, dome + 1)[:, None]
        rays = np.stack(
            [
                np.cos(half) * np.cos(turn),
                np.broadcast_to(np.sin(half), (dome + 1, len(half))),
                -np.cos(half) * np.sin(turn),
            ],
            -1,
        )
        faces = np.vstack([faces, len(vertices) + _strip(dome + 1, len(half), closed=False)])
        vertices = np.vstack([vertices, _first_way_out(form, spine[-1], rays, reach).reshape(-1, 3)])
    step = NORMAL_STEP * np.eye(3)
    gradient = np.stack([form(vertices + h) - form(vertices - h) for h in step], -1)
    normals = gradient / np.maximum(np.linalg.norm(gradient, axis=1, keepdims=True), 1e-12)
    return welded(vertices, faces, normals)


def join(meshes: Iterable[trimesh.Trimesh]) -> trimesh.Trimesh:
    parts = list(meshes)
    shift = np.cumsum([0, *(len(part.vertices) for part in parts)])
    return mesh(
        np.vstack([part.vertices for part in parts]),
        np.vstack([part.faces + k for part, k in zip(parts, shift, strict=False)]),
        np.vstack([part.vertex_normals for part in parts]),
    )


def moved(
    part: trimesh.Trimesh,
    rotation: ArrayLike = ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    shift: Sequence[float] = (0, 0, 0),
) -> trimesh.Trimesh:
    """Mesh rotated by a matrix (3, 3), then shifted (3,)."""
    R = np.asarray(rotation, float)
    return mesh(
        part.vertices @ R.T + np.asarray(shift, float), np.array(part.faces), part.vertex_normals @ R.T
    )


def smooth_max(a: Array, b: Array, width: float) -> Array:
    """max(a, b) with an edge rounded over a width [m], never less. a, b: of one shape [m]."""
    return np.maximum(a, b) + np.maximum(width - np.abs(a - b), 0) ** 2 / (4 * width)


def smooth_min(a: Array, b: Array, width: float) -> Array:
    """min(a, b) with a fillet over a width [m], never more. a, b: of one shape [m]."""
    return -smooth_max(-a, -b, width)


def swollen(part: trimesh.Trimesh, by: float) -> trimesh.Trimesh:
    """The mesh moved out along its normals [m]; in if negative."""
    return mesh(part.vertices + by * part.vertex_normals, np.array(part.faces), np.array(part.vertex_normals))


def thinned_mesh(part: trimesh.Trimesh, share: float) -> trimesh.Trimesh:
    """Mesh with a share of the triangles, at least 64, by the quadric error metric.

    All vertices are original, so it stays inside its capsule and keeps its shading.
    """
    import fast_simplification
    import trimesh
    from scipy.spatial import KDTree

    count = max(64, round(share * len(part.faces)))
    vertices, faces = fast_simplification.simplify(
        np.asarray(part.vertices), np.asarray(part.faces), target_count=count
    )
    originals, normals = np.asarray(part.vertices), np.asarray(part.vertex_normals)
    tree = KDTree(originals)
    bare = trimesh.Trimesh(originals[tree.query(vertices)[1]], faces, process=False)
    # At a crease several of the original's vertices share a place; a face takes the one nearest to its own normal.
    here = tree.query_ball_point(bare.vertices, 1e-6)
    chosen = [
        here[corner][int(np.argmax(normals[here[corner]] @ facing))]
        for corners, facing in zip(bare.faces, bare.face_normals, strict=True)
        for corner in corners
    ]
    kept, index = np.unique(chosen, return_inverse=True)
    return mesh(originals[kept], index.reshape(-1, 3), normals[kept])
