"""Laws along the row: the paper's against the textbook's matrices, strict priority, the potential field, and short rows."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from controllers.activation import activation
from controllers.kinematics import Array, null_space_projector, pseudo_inverse
from controllers.laws.potential_field import PotentialField
from controllers.laws.situation import AUTHORITY, Situation, along_row, row_damping, textbook_projector
from controllers.laws.smooth_priority import SmoothPriority
from controllers.laws.strict_priority import StrictPriority
from tests.controllers.test_laws_all import SEEDS, regular_situation

ENTRIES = st.floats(-1.0, 1.0)
SPEEDS = st.floats(-2.0, 2.0)
DISTANCES = st.floats(-0.2, 1.0)
LAWS = st.builds(SmoothPriority, st.floats(0.03, 0.30), st.floats(1.0, 20.0), st.floats(0.0, 1.0))


def vectors(entries: st.SearchStrategy[float], size: int = 7) -> st.SearchStrategy[Array]:
    return st.lists(entries, min_size=size, max_size=size).map(lambda numbers: np.array(numbers, float))


ROWS = vectors(ENTRIES).filter(lambda row: float(np.linalg.norm(row)) >= AUTHORITY)
SITUATIONS = st.builds(Situation, vectors(st.floats(-3.0, 3.0)), vectors(SPEEDS), ROWS, DISTANCES, st.floats(-1.0, 1.0))


def rate(situation: Situation, velocities: Array) -> float:
    """J_d q̇ [m/s]."""
    return float(situation.row @ velocities)


@given(LAWS, SITUATIONS)
def test_the_paper_s_law_equals_its_matrices(law: SmoothPriority, situation: Situation) -> None:
    # q̇ = J_d^# λ v + N' q̇_n, eqs (12), (32), (33), with J_d^# and N' built as matrices by numpy.
    J_d = situation.row[None, :]
    lam = min(1.0, (law.critical_distance / max(situation.distance, law.critical_distance)) ** law.order)
    J_sharp = np.linalg.pinv(J_d)
    N_smooth = np.eye(7) - lam * J_sharp @ J_d
    expected = (J_sharp * lam * law.nominal_velocity)[:, 0] + N_smooth @ situation.nominal
    assert_allclose(law(situation), expected, atol=1e-12, rtol=1e-10)
    assert_allclose(textbook_projector(situation.row, lam), N_smooth, atol=1e-12)
    # The rate is the blend and the correction what is added.
    lam, u = activation(situation.distance, law.critical_distance, law.order), -rate(situation, situation.nominal)
    assert situation.pull == pytest.approx(u, abs=1e-12)
    assert rate(situation, law(situation)) == pytest.approx(lam * law.nominal_velocity - (1.0 - lam) * u, abs=1e-12)
    # `correction` alone tells the change of the distance rate: the plots may use it instead of the arm.
    c = law.correction(situation.distance, situation.pull, situation.approach)
    assert rate(situation, law(situation)) == pytest.approx(c - situation.pull, abs=1e-12)


@given(st.integers(0, 10_000), st.sampled_from([1, 3, 6]))
def test_null_space_projector_laws(seed: int, m: int) -> None:
    """N² = N, N = Nᵀ, J N = 0, N J^# = 0 and trace N = n − m, eq. (6); damping breaks them visibly (positive control)."""
    J = np.random.default_rng(seed).normal(size=(m, 7))
    assume(np.linalg.svd(J)[1][-1] > 0.05)
    N = null_space_projector(J)
    for zero in (N @ N - N, N - N.T, J @ N, N @ pseudo_inverse(J), np.trace(N) - (7 - m)):
        assert_allclose(zero, 0.0, atol=1e-7)
    damped = null_space_projector(J, damping=0.5)
    assert np.abs(J @ damped).max() > 0.01 and np.abs(damped @ damped - damped).max() > 0.001


@given(LAWS, SITUATIONS)
def test_variants_of_the_paper_s_law(law: SmoothPriority, situation: Situation) -> None:
    # With w fed forward the law is the plain one with v + w, so that ḋ = v at λ = 1 for every w.
    fed, v = replace(law, feed_forward=True), law.nominal_velocity
    faster = replace(law, nominal_velocity=v + situation.approach)
    assert_allclose(fed(situation), faster(situation), atol=1e-12)
    close = situation._replace(distance=0.5 * law.critical_distance)
    assert rate(close, fed(close)) - close.approach == pytest.approx(v, abs=1e-11)
    # If the task retreats faster than v (+ w) a one-sided law leaves it alone; else it is the two-sided one.
    for two_sided, speed in ((law, v), (fed, v + situation.approach)):
        velocities = replace(two_sided, one_sided=True)(situation)
        assert_array_equal(velocities, situation.nominal if -situation.pull > speed else two_sided(situation))
        assert rate(situation, velocities) == pytest.approx(
            max(rate(situation, two_sided(situation)), -situation.pull), abs=1e-11
        )


@given(LAWS, SITUATIONS, st.floats(0.0, 1.0))
def test_short_rows_stay_finite_and_bounded(law: SmoothPriority, situation: Situation, length: float) -> None:
    """|q̇ − q̇_n| ≤ 11 c for a row of any length, 0 included: the undamped law would need c / |J_d|."""
    short = situation._replace(row=situation.row * (length / float(np.linalg.norm(situation.row))))
    velocities = law(short)
    assert np.isfinite(velocities).all()
    c = abs(law.correction(short.distance, short.pull, short.approach))
    assert np.linalg.norm(velocities - short.nominal) <= 11.0 * c + 1e-12


def test_damping_of_short_rows() -> None:
    # No lever, no motion: q̇ = q̇_n; a row of normal length does change it (positive control).
    nominal = np.linspace(-1.0, 1.0, 7)
    assert_array_equal(along_row(nominal, np.zeros(7), 0.3), nominal)
    assert np.abs(along_row(nominal, np.full(7, 0.2), 0.3) - nominal).max() > 0.1
    # μ² is 0 from |J_d| = .12 upwards, positive below, and its slope is 0 where it sets in.
    edge = AUTHORITY**2
    assert row_damping(edge) == 0.0 == row_damping(4.0) and row_damping(0.5 * edge) > 0.0
    assert row_damping(edge * (1.0 - 1e-4)) / (edge * 1e-4) < 1e-3
    lengths = np.linspace(0.0, AUTHORITY, 50)
    assert (np.diff([row_damping(float(x) ** 2) for x in lengths]) < 0.0).all()
    # At |J_d| = .12 m/rad the rate asked for is reached exactly; at half of that it is missed, by less than it all.
    for length, exact in ((AUTHORITY * 1.000001, True), (0.3, True), (AUTHORITY / 2.0, False)):
        row = np.full(7, length / np.sqrt(7.0))
        reached = float(row @ along_row(np.zeros(7), row, 0.3))
        assert (abs(reached - 0.3) < 1e-12) is exact and 0.0 < reached < 0.3 + 1e-12


@given(vectors(ENTRIES).filter(lambda row: float(np.linalg.norm(row)) > 0.1), st.floats(0.0, 0.3), st.floats(0.0, 1e-6))
def test_continuous_in_the_rows_length(row: Array, length: float, change: float) -> None:
    """A row longer by δ changes q̇ by at most 300 δ per m/s of correction, also where damping sets in."""
    unit, nominal = row / np.linalg.norm(row), np.zeros(7)
    before, after = along_row(nominal, unit * length, 1.0), along_row(nominal, unit * (length + change), 1.0)
    assert np.linalg.norm(after - before) <= 300.0 * change + 1e-12


FIELDS = st.builds(PotentialField, st.floats(0.1, 0.6), st.floats(1e-4, 0.05), st.floats(0.01, 0.1))


@given(SEEDS, st.floats(0.0, 1.0), st.floats(-0.2, 50.0))
def test_always_on_is_the_textbooks_eq_11(seed: int, v: float, distance: float) -> None:
    """q̇ = J_a^# v + N_a q̇_n at every distance, with J_a^# and N_a built as matrices by numpy."""
    situation = regular_situation(seed)._replace(distance=distance)
    J_a = situation.row[None, :]
    expected = np.linalg.pinv(J_a)[:, 0] * v + null_space_projector(J_a) @ situation.nominal
    assert_allclose(StrictPriority(0.15, v, switched=False)(situation), expected, atol=1e-11)


@given(SEEDS, st.floats(0.001, 0.5))
def test_switched_is_all_or_nothing(seed: int, way: float) -> None:
    """Always on up to d_m, the task alone beyond; 1 mm from d_m that is what the paper's law becomes as n → ∞."""
    situation = regular_situation(seed)
    always, switched = (StrictPriority(0.15, 0.3, switched=kind) for kind in (False, True))
    for distance in (0.15, 0.15 - way, 0.15 - 1e-6 * way, 0.15 + 1e-6 * way, 0.15 + way):
        near = situation._replace(distance=distance)
        assert_array_equal(switched(near), always(near) if distance <= 0.15 else near.nominal)
        if abs(distance - 0.15) == pytest.approx(way):
            assert_allclose(SmoothPriority(0.15, 1e4, 0.3)(near), switched(near), atol=1e-12)


@given(FIELDS, st.floats(0.02, 1.0))
def test_the_push_is_the_slope_of_the_potential(law: PotentialField, distance: float) -> None:
    """f = −dU/dd by finite differences, U = ½ η (1/d − 1/d₀)² below d₀ and 0 above; below the least distance f stays as it is."""

    def potential(d: float) -> float:
        return 0.5 * law.strength * (1.0 / min(d, law.influence_distance) - 1.0 / law.influence_distance) ** 2

    d, h = max(distance, law.least_distance), 1e-6
    if abs(d - law.influence_distance) < 2.0 * h:
        return
    slope = (potential(d + h) - potential(d - h)) / (2.0 * h)
    assert law.push(distance) == pytest.approx(-slope, rel=1e-4, abs=1e-7)


@given(FIELDS, DISTANCES)
def test_the_push_never_pulls(law: PotentialField, distance: float) -> None:
    assert law.push(distance) >= 0.0
    assert law.push(law.influence_distance) == law.push(math.inf) == 0.0
    assert law.push(distance) <= law.push(-0.1) == law.push(0.0) == law.push(law.least_distance)


def test_an_influence_inside_the_least_distance_is_none() -> None:
    for influence in (0.02, 0.05):
        law = PotentialField(influence, 0.005, 0.05)
        assert [law.push(d) for d in (-0.1, 0.0, 0.03, 0.2)] == [0.0] * 4 and law.activation(0.0) == 0.0


@given(SEEDS, FIELDS)
def test_the_push_does_not_look_at_the_task(seed: int, law: PotentialField) -> None:
    situation = regular_situation(seed)
    for nominal in (situation.nominal, 0.0 * situation.nominal):
        change = law(situation._replace(nominal=nominal)) - nominal
        assert_allclose(change, situation.row * law.push(situation.distance), atol=1e-9, rtol=1e-9)
