"""Triangles → pixels: which are covered, and by which of several triangles."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from app.figures.raster import Seen, rasterise, weights
from controllers.kinematics import Array

SIZE = 24
PLACE = st.floats(-6.0, SIZE + 6.0).map(lambda x: round(x * 8.0) / 8.0)
"""Coordinates on an eighth of a pixel: edges then often pass exactly through the middle of one."""


def seen(points: list[tuple[float, float]], faces: list[tuple[int, int, int]], nearness: list[float] | None = None) -> Seen:
    """What is seen of triangles, all equally near unless said otherwise."""
    near = np.ones(len(points)) if nearness is None else np.array(nearness)
    return rasterise(np.array(points, float), near, np.array(faces, np.int64).reshape(-1, 3), SIZE, SIZE)


def inside(triangle: Array) -> NDArray[np.bool_]:
    """Pixels whose middle is well inside a triangle (3, 2), and those in or on it: by the signs of three areas."""
    y, x = np.mgrid[:SIZE, :SIZE] + 0.5
    sides = []
    for a, b in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
        sides.append((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]))
    area = np.stack(sides)
    return np.stack([(area > 1e-9).all(0) | (area < -1e-9).all(0), (area >= -1e-9).all(0) | (area <= 1e-9).all(0)])


def test_a_known_triangle() -> None:
    """Half of a square: exactly the pixels whose middle is left of the diagonal."""
    covered = seen([(0.0, 0.0), (4.0, 0.0), (0.0, 4.0)], [(0, 1, 2)]).face >= 0
    wanted = {(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (2, 0)}
    # The middles on the diagonal itself, (3, 0) … (0, 3), are to the right of it and belong to the other half.
    assert {tuple(place) for place in np.argwhere(covered).tolist()} == wanted


@given(st.lists(st.tuples(PLACE, PLACE), min_size=3, max_size=3))
def test_any_triangle_covers_what_is_inside(points: list[tuple[float, float]]) -> None:
    """Every middle inside is covered and none outside, wherever the triangle lies and whichever way it turns."""
    for order in ((0, 1, 2), (0, 2, 1)):
        covered = seen(points, [order]).face >= 0
        surely, perhaps = inside(np.array(points))
        if abs(np.linalg.det(np.array([[*p, 1.0] for p in points]))) > 1e-6:
            assert (covered | ~surely).all()
            assert (perhaps | ~covered).all()
        else:
            assert not covered.any()


@given(st.lists(st.tuples(PLACE, PLACE), min_size=4, max_size=4))
def test_neighbours_share_no_pixel_and_leave_none_out(points: list[tuple[float, float]]) -> None:
    """Two triangles on either side of a common edge: no pixel twice, and none between them missing."""
    a, b, c, d = (np.array(p) for p in points)
    side = [(b - a)[0] * (p - a)[1] - (b - a)[1] * (p - a)[0] for p in (c, d)]
    if side[0] * side[1] >= 0.0:
        return
    one, other = (seen(points, [face]).face >= 0 for face in ((0, 1, 2), (1, 0, 3)))
    assert not (one & other).any()
    both = seen(points, [(0, 1, 2), (1, 0, 3)]).face
    assert ((both >= 0) == (one | other)).all()
    # A middle on the edge belongs to one of them, if it is well inside the two together.
    y, x = np.mgrid[:SIZE, :SIZE] + 0.5
    along = ((x - a[0]) * (b - a)[0] + (y - a[1]) * (b - a)[1]) / max(float((b - a) @ (b - a)), 1e-12)
    off = np.abs((b - a)[0] * (y - a[1]) - (b - a)[1] * (x - a[0]))
    on_edge = (off < 1e-9) & (along > 0.05) & (along < 0.95)
    reach = [inside(np.array([a, b, p]))[1] for p in (c, d)]
    assert ((one | other) | ~(on_edge & reach[0] & reach[1])).all()


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_nearer_one_is_seen(order: tuple[int, int]) -> None:
    """Whatever the order in which they come; and where two cut through each other, each is seen where it is nearer."""
    square = [(2.0, 2.0), (20.0, 2.0), (2.0, 20.0)]
    faces = [(0, 1, 2), (3, 4, 5)]
    far_near = seen(square * 2, [faces[i] for i in order], [0.5] * 3 + [0.7] * 3)
    assert set(np.unique(far_near.face)) == {-1, order.index(1)}
    assert_allclose(far_near.nearness[far_near.face >= 0], 0.7)
    # The first one leans: nearness 0.2 at the left, 1.0 at the right end.
    crossing = seen(square * 2, [faces[i] for i in order], [0.2, 1.0, 0.2, 0.6, 0.6, 0.6])
    left, right = crossing.face[3, 4], crossing.face[3, 15]
    assert (left, right) == (order.index(1), order.index(0))


def test_nothing_outside_and_nothing_flat() -> None:
    """A triangle beside the picture, one without area, and none at all cover nothing; a huge one covers everything."""
    assert (seen([(-9.0, -9.0), (-1.0, -9.0), (-9.0, -1.0)], [(0, 1, 2)]).face < 0).all()
    assert (seen([(1.0, 1.0), (9.0, 9.0), (5.0, 5.0)], [(0, 1, 2)]).face < 0).all()
    assert (seen([(0.0, 0.0)], []).face < 0).all()
    assert (seen([(-1e4, -1e4), (1e5, -1e4), (-1e4, 1e5)], [(0, 1, 2)]).face == 0).all()


def test_weights_find_the_point_in_space() -> None:
    """What is seen in a pixel projects back to the middle of that pixel, in perspective."""
    random = np.random.default_rng(3)
    corners = np.column_stack([random.uniform(-1.0, 1.0, (3, 2)), [1.0, 2.5, 4.0]])
    points = corners[:, :2] / corners[:, 2:] * 20.0 + SIZE / 2.0
    near, faces = 1.0 / corners[:, 2], np.array([[0, 1, 2]])
    picture = rasterise(points, near, faces, SIZE, SIZE)
    rows, columns = np.nonzero(picture.face >= 0)
    assert len(rows) > 20
    share = weights(points, near, faces, picture, rows, columns)
    assert_allclose(share.sum(1), 1.0)
    space = share @ corners
    assert_allclose(space[:, :2] / space[:, 2:] * 20.0 + SIZE / 2.0, np.stack([columns, rows], 1) + 0.5, atol=1e-9)
    assert_allclose(1.0 / space[:, 2], picture.nearness[rows, columns])
