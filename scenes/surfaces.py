"""Smooth surfaces with true normals: revolved profiles, and skins of implicit forms. Lengths in metres."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    import trimesh

Array = NDArray[np.float64]
Form = Callable[[Array], Array]
"""Signed function of points (…, 3): negative inside, metre-like near its zero level; (…,)."""

CREASE: Final = float(np.radians(32))
"""Turn of a profile from which an edge stays sharp [rad]."""

NORMAL_STEP: Final = 2e-4
"""Half step of the central differences behind the normals of a skin [m]."""


def mesh(vertices: Array, faces: NDArray[np.int64], normals: Array) -> trimesh.Trimesh:
    """A mesh that keeps exactly these vertices (n, 3), faces (m, 3) and unit normals (n, 3)."""
    # Slow to import, and not needed while the cache has every mesh.
    import trimesh

    return trimesh.Trimesh(vertices, faces, vertex_normals=normals, process=False)


def _strip(rows: int, columns: int, closed: bool) -> NDArray[np.int64]:
    """Faces (m, 3) of a row-major grid of vertices; counter-clockwise seen with rows going up and columns to
    the right.
    """
    row, column = np.meshgrid(
        np.arange(rows - 1), np.arange(columns if closed else columns - 1), indexing="ij"
    )
    right = (column + 1) % columns
    a, b = row * columns + column, row * columns + right
    c, d = a + columns, b + columns
    return np.stack([np.stack([a, b, d], -1), np.stack([a, d, c], -1)], -2).reshape(-1, 3)


def welded(vertices: Array, faces: NDArray[np.int64], normals: Array) -> trimesh.Trimesh:
    """A mesh in which equal vertices with equal normals are one, without degenerate faces.

    viser 1.1.1 replaces the normals of a GLB by its own from the faces that share a vertex: two copies of a
    vertex show as a crease, one vertex as a smooth surface.

    Args:
        vertices: (k, 3) [m].
        faces: (l, 3), indices of `vertices`.
        normals: (k, 3), unit.
    """
    same = np.round(np.hstack([vertices * 1e6, normals * 1e3])).astype(np.int64)
    _, first, inverse = np.unique(same, axis=0, return_index=True, return_inverse=True)
    faces = inverse.reshape(-1)[faces]
    a, b, c = (vertices[first][faces[:, i]] for i in range(3))
    faces = faces[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-12]
    used, compact = np.unique(faces, return_inverse=True)
    return mesh(vertices[first][used], compact.reshape(-1, 3), normals[first][used])


def rounded(points: ArrayLike, radius: float, steps: int = 4) -> Array:
    """A polyline (n, 2) with inner corners replaced by arcs of this radius, or as large as the sides allow;
    (m, 2).
    """
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
        stretch: pull the four quarters apart by ± this in x and y [m]: a disc becomes a slab with round
            corners.
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
    """Points (…, 3) where rays leave a form, by bisection."""
    near, far = np.zeros(directions.shape[:-1]), np.full(directions.shape[:-1], reach)
    for _ in range(24):
        middle = (near + far) / 2
        inside = form(origins + middle[..., None] * directions) < 0
        near, far = np.where(inside, middle, near), np.where(inside, far, middle)
    return origins + near[..., None] * directions


def _fan(angle: Array, lift: Array) -> Array:
    """Directions (rows, columns, 3) at angles (rows, columns) from the +x axis, lifted (rows,) from the horizontal."""
    flat = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], -1)
    return np.cos(lift)[:, None, None] * flat + np.sin(lift)[:, None, None] * np.array([0.0, 0, 1])


def _crowded(form: Form, spine: Array, lift: Array, columns: int, reach: float, first: float) -> Array:
    """Angles (rows, columns) of the rays of every ring: by length of the outline, denser where it turns."""
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
    """Skin a form from inside: a ring of rays from every point of a curve, to the first way out.

    The rays of a ring are denser where the outline turns, so that rounded edges run along the columns of the
    mesh.

    Args:
        form: negative on the spine, positive at `reach` along every ray.
        spine: start of the rays of every ring (rows, 3) [m].
        lift: angle of every ring of rays from the horizontal (rows,), growing [rad].
        columns: rays of a ring, an even number.
        reach: length of the rays [m].
        first: angle of the first column, on a plane of symmetry of the form: the crowding is made symmetric
            about it [rad].
        dome: close the last ring, a horizontal one, with this number of strips: its first half (from `first`
            = the +y axis) turned about the y axis until it lies on its second half. An edge about the y axis
            then runs on along one column, without a pole.
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
    """The mesh rotated by a matrix (3, 3), then shifted (3,)."""
    R = np.asarray(rotation, float)
    return mesh(
        part.vertices @ R.T + np.asarray(shift, float), np.array(part.faces), part.vertex_normals @ R.T
    )


def smooth_max(a: Array, b: Array, width: float) -> Array:
    """max(a, b) with an edge rounded over a width [m]: what is inside both forms, never more. a, b: of one shape [m]."""
    return np.maximum(a, b) + np.maximum(width - np.abs(a - b), 0) ** 2 / (4 * width)


def smooth_min(a: Array, b: Array, width: float) -> Array:
    """min(a, b) with a corner filled over a width [m]: what is inside either form, and a fillet. a, b: of one shape [m]."""
    return -smooth_max(-a, -b, width)


def swollen(part: trimesh.Trimesh, by: float) -> trimesh.Trimesh:
    """The mesh with its surface moved out along the normals [m]; shrunk if negative."""
    return mesh(part.vertices + by * part.vertex_normals, np.array(part.faces), np.array(part.vertex_normals))


def thinned_mesh(part: trimesh.Trimesh, share: float) -> trimesh.Trimesh:
    """A mesh with a share of the triangles, at least 64, kept where the shape needs them (quadric error
    metric).

    Every vertex is one of the original's: what was inside a capsule stays inside, and light falls on it as on
    the original.
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
