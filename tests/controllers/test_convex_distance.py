"""The strictly convex distance: gradient, bounds, and smoothness where the true distance has a kink."""

from __future__ import annotations

import math

import coal
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.optimize import minimize

from controllers.kinematics import Array, Kinematics
from controllers.proximity import ProximityDetector
from scenes.settings import RunSettings, changed
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from tests.controllers.helpers import bodies, overlapping_postures, random_postures

EPSILON = 1e-4


def two_bodies(lengths: tuple[float, float]) -> ProximityDetector:
    """Two free capsules (spheres at length 0), each with three translations and three Euler angles."""
    model, geometry = pin.Model(), pin.GeometryModel()
    for i, length in enumerate(lengths):
        place = model.addJoint(0, pin.JointModelTranslation(), pin.SE3.Identity(), f"place {i}")
        turn = model.addJoint(place, pin.JointModelSphericalZYX(), pin.SE3.Identity(), f"turn {i}")
        shape = coal.Capsule(0.05, length) if length else coal.Sphere(0.05)
        geometry.addGeometryObject(pin.GeometryObject(f"body {i}", turn, pin.SE3.Identity(), shape))
    geometry.addCollisionPair(pin.CollisionPair(0, 1))
    return ProximityDetector(Kinematics(model, ()), geometry)


def smooth(detector: ProximityDetector, q: Array, epsilon: float = EPSILON) -> float:
    detector.kinematics.update(q)
    return detector.detect("smooth", epsilon=epsilon).law_distance


def gradient(detector: ProximityDetector, q: Array) -> Array:
    """∂d/∂q (nv,) by fourth-order central differences; small steps for near-parallel axes."""
    h, numeric = 5e-7, np.zeros(len(q))
    for i, unit in enumerate(np.eye(len(q)) * h):
        near, far = (smooth(detector, q + k * unit) - smooth(detector, q - k * unit) for k in (1, 2))
        numeric[i] = (8.0 * near - far) / (12.0 * h)
    return numeric


angle = st.one_of(st.sampled_from([0.0, 1e-9, 1e-6, 1e-3]), st.floats(-1.2, 1.2))
pose = st.tuples(*[st.floats(-0.4, 0.4)] * 3, angle, angle, angle)


@given(pose, pose, st.sampled_from([(0.4, 0.3), (0.4, 0.4), (0.3, 0.0), (0.0, 0.0)]))
@example((0.2, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0,) * 6, (0.4, 0.4))  # parallel, side by side
@example((0.0, 0.0, 0.45, 0.0, 0.0, 0.0), (0.0,) * 6, (0.4, 0.4))  # collinear, ends touching
@example((0.06, 0.0, 0.1, 0.0, 1e-9, 0.0), (0.0,) * 6, (0.4, 0.3))  # near-parallel and overlapping
def test_the_row_is_the_gradient_and_the_distance_never_exceeds_the_true_one(a, b, lengths) -> None:
    detector, q = two_bodies(lengths), np.array([*a, *b])
    d = smooth(detector, q)
    true = float(detector.distances()[0])
    assert true - math.sqrt(EPSILON / 2.0) - 1e-9 <= d <= true + 1e-9
    # Where two axes cross there is no direction; very near, central differences are too coarse.
    assume(d > -0.1)
    row = detector.detect("smooth", epsilon=EPSILON).row
    assert_allclose(row, gradient(detector, q), atol=1e-6)


@given(pose, pose, st.sampled_from([1e-6, 1e-4, 1e-3]))
def test_the_points_are_the_minimum_of_the_convex_problem(a, b, epsilon: float) -> None:
    """Compared with a numerical minimiser, which does no clamping."""
    detector, q = two_bodies((0.4, 0.3)), np.array([*a, *b])
    # The smooth minimum of one pair is its distance.
    d = smooth(detector, q, epsilon)
    first, second = detector.data.oMg
    r = first.translation - second.translation
    u, v = 0.2 * first.rotation[:, 2], 0.15 * second.rotation[:, 2]

    def F(st: Array) -> float:
        gap = r + st[0] * u - st[1] * v
        return float(gap @ gap) + epsilon / 4.0 * float(st @ st)

    starts = [(0.0, 0.0), (1.0, 1.0), (-1.0, 1.0)]
    least = min(float(minimize(F, start, bounds=[(-1, 1)] * 2, tol=1e-14).fun) for start in starts)
    assert d == pytest.approx(math.sqrt(least) - math.sqrt(epsilon / 2.0) - 0.1, abs=2e-6)


@pytest.mark.parametrize("rig", ["torso", "table"])
def test_the_smooth_minimum_of_the_arms(rig) -> None:
    """At random, overlapping and upright (parallel) postures: −ln Σ exp(−β d_i)/β of the strictly convex distances, and its gradient."""
    room, kinematics, detector = bodies(rig)
    singles: list[ProximityDetector] = []
    for pair in room.geometry.collisionPairs:
        alone = room.geometry.copy()
        alone.removeAllCollisionPairs()
        alone.addCollisionPair(pair)
        singles.append(ProximityDetector(kinematics, alone))
    upright = np.zeros(14)
    postures = [
        room.start,
        upright,
        *random_postures(room, 8, seed=5),
        *overlapping_postures(rig, 0.02, 4, seed=6),
    ]
    for q in postures:
        kinematics.update(q)
        near, true = detector.detect("smooth", 80.0), detector.detect("single")
        each = np.array([smooth(single, q) for single in singles])
        assert near.law_distance == pytest.approx(-math.log(np.exp(-80.0 * each).sum()) / 80.0, abs=1e-12)
        assert (near.distance, near.pair) == (true.distance, true.pair) and near.law_distance <= near.distance
        assert_allclose(near.pair_row, true.row, atol=1e-12)
        assert (each <= detector.distances() + 1e-12).all()
        numeric = gradient(detector, q)
        kinematics.update(q)
        assert_allclose(detector.detect("smooth").row, numeric, atol=1e-6)


def coplanar(pairs: str, dt: float, lean: float, tilt: float, way: float) -> float:
    """Largest step of q̇ while the arms, in one plane on the table, pass through parallel forearms."""
    run = changed(changed(RunSettings(rig="table", dt=dt, gain=1.0), "pairs", pairs), "v", 0.05)
    simulation = Simulation(run, round(3.0 / dt))
    q = np.zeros(14)
    q[[1, 3, 8, 10]] = -1.15, -1.15 + lean, -1.15, -1.15 + lean + tilt
    simulation.reset(q)
    hand = simulation.kinematics.hand_pose(simulation.guided).translation.copy()
    for k in range(round(2.4 / dt)):
        simulation.step(HandTarget(hand + np.array([way * math.sin(k * dt), 0.0, 0.0])))
    table = simulation.history.table()
    velocities = simulation.history.velocities(table)[:, simulation.avoiding.joints]
    assert np.abs(simulation.positions[[0, 2, 4, 7, 9, 11]]).max() < 1e-9
    return float(np.abs(np.diff(velocities, axis=0)).max())


@given(st.floats(-0.1, 0.1), st.floats(0.005, 0.03), st.sampled_from([-1.0, 1.0]), st.floats(-0.04, 0.04))
@example(0.0075, 0.0174, 1.0, -0.0096)
@settings(max_examples=6)
def test_a_smaller_time_step_makes_smaller_steps_of_the_joint_velocity(
    lean: float, tilt: float, side: float, way: float
) -> None:
    steps = [coplanar("smooth", dt, lean, side * tilt, way) for dt in (0.01, 0.005, 0.0025, 0.00125)]
    # A jump would keep its size; the smallest ratio of 160 random cases was 4.4 for an eighth of dt.
    assert steps[0] / steps[-1] >= 1.5**3


def test_the_smooth_minimum_of_true_distances_jumps_at_any_time_step() -> None:
    steps = [coplanar("soft", dt, 0.0075, 0.0174, -0.0096) for dt in (0.01, 0.00125)]
    assert steps[0] / steps[1] < 1.1
    assert coplanar("smooth", 0.00125, 0.0075, 0.0174, -0.0096) < 0.15 * steps[1]
