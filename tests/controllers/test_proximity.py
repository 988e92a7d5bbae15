"""Distances, witness points and J_d of the real capsules against independent geometry and derivatives."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from controllers.choices import Treatment
from controllers.kinematics import Array, Kinematics
from controllers.proximity import ProximityDetector
from scenes.rigs import MIRROR
from scenes.room import Room
from scenes.settings import RigName
from tests.controllers.helpers import bodies, derivative, overlapping_postures, random_postures
from tests.scenes.helpers import RIG_NAMES

PAIRS = 15


def nearest_on_segment(point: Array, a: Array, b: Array) -> Array:
    """Point of segment ab nearest to `point`."""
    ab = b - a
    return a + ab * min(max(float((point - a) @ ab) / float(ab @ ab), 0.0), 1.0)


def nearest_of_segments(a: Array, b: Array, c: Array, d: Array) -> tuple[Array, Array]:
    """Nearest points of ab and cd: the crossing of the lines if inside both, else the best end."""
    found = [(point, nearest_on_segment(point, c, d)) for point in (a, b)]
    found += [(nearest_on_segment(point, a, b), point) for point in (c, d)]
    A = np.column_stack([b - a, c - d])
    s, t = np.linalg.lstsq(A, c - a, rcond=None)[0]
    if 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0:
        found.append((a + s * (b - a), c + t * (d - c)))
    return min(found, key=lambda pair: float(np.linalg.norm(pair[1] - pair[0])))


def axis_of(room: Room, kinematics: Kinematics, body: int) -> tuple[Array, Array, float]:
    """Both sphere centres (3,) in the world, and the radius of a capsule."""
    thing = room.geometry.geometryObjects[body]
    placement = kinematics.data.oMi[thing.parentJoint] * thing.placement
    half = np.array([0.0, 0.0, thing.geometry.halfLength])
    return placement.act(-half), placement.act(half), float(thing.geometry.radius)


def measured(room: Room, kinematics: Kinematics, pair: int) -> tuple[float, Array, Array]:
    """Distance and both surface points of a pair, by the functions above."""
    first, second = room.geometry.collisionPairs[pair].first, room.geometry.collisionPairs[pair].second
    a, b, r1 = axis_of(room, kinematics, first)
    c, d, r2 = axis_of(room, kinematics, second)
    p, q = nearest_of_segments(a, b, c, d)
    length = float(np.linalg.norm(q - p))
    n = (q - p) / length
    return length - r1 - r2, p + r1 * n, q - r2 * n


def distance_of(kinematics: Kinematics, detector: ProximityDetector, q: Array, pair: int) -> float:
    kinematics.update(q)
    detector.detect()
    return float(detector.distances()[pair])


def smooth_enough(kinematics: Kinematics, detector: ProximityDetector, q: Array, pair: int, h: float) -> bool:
    """True if d has a unique derivative around q: its witness points do not jump within a step."""
    points = []
    for step in (-h, h):
        kinematics.update(q + step)
        detector.detect()
        points.append(np.concatenate(detector.witness_points(pair)))
    return float(np.abs(points[1] - points[0]).max()) < 200.0 * h


@pytest.mark.parametrize("rig", RIG_NAMES)
def test_distances_and_witness_points_against_independent_geometry(rig: RigName) -> None:
    """Every pair at 80 random postures, some overlapping: d, both points, normal, and the closest pair."""
    room, kinematics, detector = bodies(rig)
    overlapping = 0
    for q in [*random_postures(room, 60, seed=21), *overlapping_postures(rig, 0.0, 20, seed=22)]:
        kinematics.update(q)
        near = detector.detect()
        distances = detector.distances()
        for pair in range(detector.count):
            expected, p, r = measured(room, kinematics, pair)
            overlapping += expected < 0.0
            assert distances[pair] == pytest.approx(expected, abs=1e-12)
            first, second = detector.witness_points(pair)
            assert_allclose(first, p, atol=1e-9)
            assert_allclose(second, r, atol=1e-9)
            n = detector.data.distanceResults[pair].normal
            assert np.linalg.norm(n) == pytest.approx(1.0, abs=1e-9)
            assert_allclose(second - first, expected * n, atol=1e-9)
        assert (near.pair, near.distance) == (int(distances.argmin()), distances.min())
        assert near.law_distance == near.distance
    assert overlapping >= 20


def test_upright_arms() -> None:
    # On the table with all joints zero both arms are upright and 1.1 m apart: each level's gap is 1.1 m minus
    # two radii. The upper arm counts against the other pedestal only from 0.12 m above the shoulder, where
    # its joints move it.
    room, kinematics, detector = bodies("table")
    kinematics.update(np.zeros(room.model.nv))
    assert detector.detect().distance == pytest.approx(1.1 - 0.140, abs=1e-12)
    found = dict(zip(detector.pair_names, detector.distances().tolist(), strict=True))
    assert found["left upper arm", "right upper arm"] == pytest.approx(1.1 - 0.140, abs=1e-12)
    assert found["left forearm", "right forearm"] == pytest.approx(1.1 - 0.130, abs=1e-12)
    assert found["left hand", "right hand"] == pytest.approx(1.1 - 0.100, abs=1e-12)
    assert found["left pedestal", "right hand"] == pytest.approx(
        math.hypot(1.1, 1.100 - 0.310) - 0.125, abs=1e-12
    )
    # The near-parallel tests below use the two upper arms.
    assert detector.pair_names[UPRIGHT] == ("left upper arm", "right upper arm")


def check_rows(rig: RigName, postures: list[Array], pairs: range = range(PAIRS), atol: float = 1e-6) -> int:
    """Number of comparable pairs, after a check of J_d against central differences."""
    _, kinematics, detector = bodies(rig)
    h, compared = 1e-6, 0
    for q in postures:
        smooth = [smooth_enough(kinematics, detector, q, pair, h) for pair in pairs]

        def distances(at: Array) -> Array:
            kinematics.update(at)
            detector.detect()
            return detector.distances()

        numeric = derivative(distances, q, h)
        kinematics.update(q)
        near = detector.detect()
        rows = detector.rows()
        assert_allclose(near.row, rows[near.pair], atol=1e-12)
        for pair, usable in zip(pairs, smooth, strict=True):
            assert_allclose(detector.row(pair), rows[pair], atol=1e-12)
            if usable:
                assert_allclose(rows[pair], numeric[pair], atol=atol)
                compared += 1
    return compared


@pytest.mark.parametrize("rig", RIG_NAMES)
def test_rows_at_random_and_overlapping_postures(rig: RigName) -> None:
    # J_d, eqs (26), (27), is the gradient of the distance over both arms' joints.
    room, _, _ = bodies(rig)
    assert check_rows(rig, [room.start, *random_postures(room, 25, seed=31)]) > 25 * PAIRS * 0.98
    # At d < 0 the row keeps its sign: it points outwards.
    _, kinematics, detector = bodies(rig)
    inside = overlapping_postures(rig, 0.02, 15, seed=32)
    assert check_rows(rig, inside) > 15 * PAIRS * 0.9
    for q in inside:
        kinematics.update(q)
        near = detector.detect()
        out = q + 1e-4 * near.row / np.linalg.norm(near.row)
        assert distance_of(kinematics, detector, out, near.pair) > near.distance + 0.5e-4 * np.linalg.norm(
            near.row
        )


UPRIGHT = 4
"""Index of the pair left and right upper arm."""


@pytest.mark.parametrize("angle", [0.3, 0.03, 3e-3])
def test_rows_of_nearly_parallel_capsules(angle: float) -> None:
    """Upper arms tilted by a small angle: J_d is exact while the witness points are unique."""
    postures = []
    for lean, turn in ((1.0, 0.4), (-1.0, 1.2), (1.0, 2.5)):
        q = np.zeros(14)
        q[0], q[1], q[8] = turn, lean * angle, 0.3 * angle
        q[3] = q[10] = 0.7
        postures.append(q)
    assert check_rows("table", postures, range(UPRIGHT, UPRIGHT + 1), atol=1e-5) == len(postures)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-9, 1e-6, 1e-4])
def test_rows_of_parallel_capsules_are_bounded_and_one_of_the_gradients(angle: float) -> None:
    """With many equally close points J_d belongs to one of their pairs: finite, and d grows no faster than
    J_d says.

    The distance of touching points fixed to their bodies is an upper bound of d, and equal to d now.
    """
    _, kinematics, detector = bodies("table")
    random = np.random.default_rng(41)
    for turn in (0.0, 0.8, 2.0):
        q = np.zeros(14)
        q[0], q[1] = turn, angle
        d = distance_of(kinematics, detector, q, UPRIGHT)
        row = detector.row(UPRIGHT)
        assert np.isfinite(row).all()
        assert np.linalg.norm(row) < 1.5
        # Near parallel, coal's own distance is accurate to a few tenths of a micrometre.
        h, slack = 1e-4, 5e-7
        for _ in range(20):
            direction = random.normal(size=14)
            direction /= np.linalg.norm(direction)
            assert (
                distance_of(kinematics, detector, q + h * direction, UPRIGHT)
                <= d + h * float(row @ direction) + slack
            )


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("beta", [20.0, 100.0, 400.0])
def test_the_soft_distance_and_its_gradient(rig: RigName, beta: float) -> None:
    """d − ln(N)/β ≤ d_soft = −ln Σ exp(−β d_i)/β ≤ d; d and pair unchanged; the row is its gradient."""
    room, kinematics, detector = bodies(rig)

    def soft(q: Array) -> Array:
        kinematics.update(q)
        return np.array(detector.detect("soft", beta).law_distance)

    widest = apart = 0.0
    for k, q in enumerate([room.start, *random_postures(room, 60, seed=61)]):
        kinematics.update(q)
        hard, near = detector.detect("single"), detector.detect("soft", beta)
        assert (near.distance, near.pair) == (hard.distance, hard.pair)
        assert_allclose(near.pair_row, hard.row, atol=1e-12)
        assert near.distance - math.log(PAIRS) / beta <= near.law_distance <= near.distance
        expected = -math.log(sum(math.exp(-beta * d) for d in detector.distances())) / beta
        assert near.law_distance == pytest.approx(expected, abs=1e-10)
        widest = max(widest, near.distance - near.law_distance)
        apart = max(apart, float(np.abs(near.row - near.pair_row).max()))
        if k < 13:
            assert_allclose(near.row, derivative(soft, q), atol=2e-6)
    assert widest > 0.1 / beta and apart > 1e-3


@pytest.mark.parametrize("rig", RIG_NAMES)
def test_every_pair_counts(rig: RigName) -> None:
    # Four bodies per arm make 16 pairs; only pedestal–pedestal, of constant distance, is left out. Next to a
    # pedestal an upper arm begins where its joints move it.
    room, kinematics, detector = bodies(rig)
    parts = ("pedestal", "upper arm", "forearm", "hand")
    every = {(f"left {a}", f"right {b}") for a in parts for b in parts}
    upper = {("left pedestal", "right upper arm"), ("left upper arm", "right pedestal")}
    every = every - upper | {tuple(name.replace("upper", "outer upper") for name in pair) for pair in upper}
    assert detector.count == PAIRS == len(set(detector.pair_names))
    assert every - set(detector.pair_names) == {("left pedestal", "right pedestal")}
    names = [body.name for body in room.geometry.geometryObjects]
    left, right = names.index("left pedestal"), names.index("right pedestal")
    assert (
        room.geometry.geometryObjects[left].parentJoint
        == room.geometry.geometryObjects[right].parentJoint
        == 0
    )
    gaps = []
    for q in random_postures(room, 5, seed=71):
        kinematics.update(q)
        a, b, r1 = axis_of(room, kinematics, left)
        c, d, r2 = axis_of(room, kinematics, right)
        p, r = nearest_of_segments(a, b, c, d)
        gaps.append(float(np.linalg.norm(r - p)) - r1 - r2)
    assert np.ptp(gaps) == 0.0
    # Each of the 15 rows is nonzero somewhere; a pedestal's own arm never moves it.
    largest = np.zeros((PAIRS, 14))
    for q in random_postures(room, 40, seed=72):
        kinematics.update(q)
        detector.detect()
        largest = np.maximum(largest, np.abs(detector.rows()))
    assert (largest.max(axis=1) > 0.05).all()
    for names, row in zip(detector.pair_names, largest, strict=True):
        assert row[:7].any() == (names[0] != "left pedestal")
        assert row[7:].any() == (names[1] != "right pedestal")


@pytest.mark.parametrize("treatment", ["single", "soft"])
def test_without_pairs_nothing_is_near(treatment: Treatment) -> None:
    """One arm alone: d = ∞ and J_d = 0, so λ = 0 under every law."""
    room, kinematics, _ = bodies("torso")
    empty = room.geometry.copy()
    empty.removeAllCollisionPairs()
    near = ProximityDetector(kinematics, empty).detect(treatment)
    assert near.distance == near.law_distance == np.inf
    assert near.pair == -1
    assert not near.row.any() and not near.pair_row.any()


def mirrored(vector: Array) -> Array:
    """Mirrored posture or row of both arms (14,): arms swapped, each joint with its mirror sign."""
    return np.concatenate([vector[7:] * MIRROR, vector[:7] * MIRROR])


def test_the_torso_and_its_mirror_image() -> None:
    # Swapped arms with mirrored joints have the same distances and the mirrored rows.
    room, kinematics, detector = bodies("torso")
    place = {names: i for i, names in enumerate(detector.pair_names)}
    swap = [place[b.replace("right", "left"), a.replace("left", "right")] for a, b in detector.pair_names]
    changes = []
    for q in random_postures(room, 30, seed=81):
        kinematics.update(q)
        soft, distances = detector.detect("soft"), detector.distances()
        row, rows = soft.row.copy(), detector.rows()
        kinematics.update(mirrored(q))
        other = detector.detect("soft")
        assert other.law_distance == pytest.approx(soft.law_distance, abs=1e-12)
        assert_allclose(detector.distances()[swap], distances, atol=1e-12)
        assert_allclose(detector.rows()[swap], [mirrored(r) for r in rows], atol=1e-8)
        assert_allclose(other.row, mirrored(row), atol=1e-8)
        # Positive control: without the mirror signs the distance differs.
        kinematics.update(np.concatenate([q[7:], q[:7]]))
        changes.append(abs(detector.detect().distance - distances.min()))
    assert max(changes) > 0.01
