"""Triangles → pixels: which triangle is seen in each pixel, and where in it. numpy alone.

Every triangle is cut into the spans of its pixel rows, every span into pixels, and the nearest one wins (a z-buffer). A pixel belongs
to a triangle that covers its centre; two triangles with a common edge never both get a pixel nor leave one out, since an edge is
always followed from its upper end to its lower one.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.kinematics import Array

Integers = NDArray[np.int64]


class Seen(NamedTuple):
    """What is seen in every pixel.

    Attributes:
        face: index of the triangle (height, width), −1 where there is none.
        nearness: of the point seen (height, width); 0 where there is none.
    """

    face: Integers
    nearness: Array


def rasterise(points: Array, nearness: Array, faces: Integers, width: int, height: int) -> Seen:
    """Return what is seen of triangles.

    Args:
        points: (n, 2) in pixels, x to the right, y down; the middle of the first pixel is at (0.5, 0.5).
        nearness: (n,) > 0, larger is nearer, and linear over the picture: 1/z in perspective.
        faces: (m, 3); their sense of turning does not matter.
        width, height: of the picture.
    """
    corner = points[faces]
    depth = nearness[faces]
    first = np.maximum(np.ceil(corner[..., 1].min(1) - 0.5), 0).astype(np.int64)
    last = np.minimum(np.ceil(corner[..., 1].max(1) - 0.5), height).astype(np.int64)
    gradient, offset = _planes(corner, depth)
    # A triangle seen from its edge covers nothing, but may have a huge gradient.
    rows = np.where(np.isfinite(offset), np.maximum(last - first, 0), 0)
    owner = np.repeat(np.arange(len(faces)), rows)
    row = first[owner] + _counted(rows)
    left, right = _spans(corner, owner, row + 0.5)
    start = np.maximum(np.ceil(left - 0.5), 0).astype(np.int64)
    length = np.maximum(np.minimum(np.ceil(right - 0.5), width).astype(np.int64) - start, 0)
    which = np.repeat(np.arange(len(owner)), length)
    column = start[which] + _counted(length)
    face, row = owner[which], row[which]
    near = gradient[face, 0] * (column + 0.5) + gradient[face, 1] * (row + 0.5) + offset[face]
    pixel = row * width + column
    best = np.zeros(width * height)
    np.maximum.at(best, pixel, near)
    winner = near == best[pixel]
    seen = np.full(width * height, -1, np.int64)
    # Of several triangles at exactly the same depth the first one wins: numpy keeps the last value written.
    seen[pixel[winner][::-1]] = face[winner][::-1]
    return Seen(seen.reshape(height, width), best.reshape(height, width))


def weights(points: Array, nearness: Array, faces: Integers, seen: Seen, rows: Integers, columns: Integers) -> Array:
    """Return the weights (k, 3) of the three corners, in space, of what is seen in pixels (k,) that show a triangle."""
    face = seen.face[rows, columns]
    a, b, c = (points[faces[face, i]] for i in range(3))
    x, y = columns + 0.5, rows + 0.5
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
    flat = np.empty((len(face), 3))
    flat[:, 1] = ((x - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (y - a[:, 1])) / area
    flat[:, 2] = ((b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (x - a[:, 0]) * (b[:, 1] - a[:, 1])) / area
    flat[:, 0] = 1.0 - flat[:, 1] - flat[:, 2]
    # The picture shows planes in perspective: what is linear in space is linear over z.
    flat *= nearness[faces[face]]
    return flat / flat.sum(1, keepdims=True)


def _counted(lengths: Integers) -> Integers:
    """Return 0, 1, … n−1 for every n of lengths, one after the other."""
    ends = np.cumsum(lengths)
    return np.arange(ends[-1] if len(ends) else 0) - np.repeat(ends - lengths, lengths)


def _planes(corner: Array, depth: Array) -> tuple[Array, Array]:
    """Return gradient (m, 2) and offset (m,) of the nearness of triangles over the picture; not finite for slivers."""
    a, b = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    p, q = depth[:, 1] - depth[:, 0], depth[:, 2] - depth[:, 0]
    area = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        gradient = np.stack([p * b[:, 1] - q * a[:, 1], q * a[:, 0] - p * b[:, 0]], -1) / area[:, None]
        offset = depth[:, 0] - (gradient * corner[:, 0]).sum(1)
    offset[np.abs(area) < 1e-9] = np.nan
    return gradient, offset


def _spans(corner: Array, owner: Integers, y: Array) -> tuple[Array, Array]:
    """Return where rows y (k,) enter and leave their triangles (k,)."""
    left, right = np.full(len(owner), np.inf), np.full(len(owner), -np.inf)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        # Always downwards, so that both triangles of an edge find the very same crossing.
        down = corner[:, i, 1] <= corner[:, j, 1]
        top = np.where(down[:, None], corner[:, i], corner[:, j])
        bottom = np.where(down[:, None], corner[:, j], corner[:, i])
        fall = bottom[:, 1] - top[:, 1]
        slope = (bottom[:, 0] - top[:, 0]) / np.where(fall > 0.0, fall, 1.0)
        crossed = (top[owner, 1] <= y) & (y < bottom[owner, 1])
        x = top[owner, 0] + slope[owner] * (y - top[owner, 1])
        left = np.where(crossed & (x < left), x, left)
        right = np.where(crossed & (x > right), x, right)
    return left, right
