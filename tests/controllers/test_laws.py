"""Laws along the row against textbook matrices, the barrier QP against other solvers, and short rows."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import nnls

from controllers.activation import activation
from controllers.kinematics import Array, null_space_projector, pseudo_inverse
from controllers.laws.barrier_qp import HARDNESS, BarrierQP
from controllers.laws.potential_field import PotentialField
from controllers.laws.situation import AUTHORITY, Situation, along_row, row_damping, row_dampings
from controllers.laws.smooth_priority import SmoothPriority
from controllers.laws.strict_priority import StrictPriority
from tests.controllers.test_laws_all import SEEDS, jump_ratio, regular_situation

ENTRIES = st.floats(-1.0, 1.0)
SPEEDS = st.floats(-2.0, 2.0)
DISTANCES = st.floats(-0.2, 1.0)
LAWS = st.builds(SmoothPriority, st.floats(0.03, 0.30), st.floats(1.0, 20.0), st.floats(0.0, 1.0))


def vectors(entries: st.SearchStrategy[float], size: int = 7) -> st.SearchStrategy[Array]:
    return st.lists(entries, min_size=size, max_size=size).map(lambda numbers: np.array(numbers, float))


ROWS = vectors(ENTRIES).filter(lambda row: float(np.linalg.norm(row)) >= AUTHORITY)
SITUATIONS = st.builds(
    Situation, vectors(st.floats(-3.0, 3.0)), vectors(SPEEDS), ROWS, DISTANCES, st.floats(-1.0, 1.0)
)


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
    # The rate is the blend; the correction is the added part.
    lam, u = (
        activation(situation.distance, law.critical_distance, law.order),
        -rate(situation, situation.nominal),
    )
    assert situation.pull == pytest.approx(u, abs=1e-12)
    assert rate(situation, law(situation)) == pytest.approx(
        lam * law.nominal_velocity - (1.0 - lam) * u, abs=1e-12
    )
    # `correction` alone gives the change of the distance rate, so plots may use it instead of the arm.
    c = law.correction(situation.distance, situation.pull, situation.approach)
    assert rate(situation, law(situation)) == pytest.approx(c - situation.pull, abs=1e-12)


def generalized_projector(tasks: Array, priorities: Array) -> Array:
    """I − B A Bᵀ of rows (m, n) with priorities (m,); B: an orthonormal basis of the rows by priority.

    M. Liu, Y. Tan and V. Padois, Generalized hierarchical control, Autonomous Robots 40(1), 2016.
    """
    basis: list[Array] = []
    weights: list[float] = []
    for i in np.argsort(-priorities, kind="stable"):
        left = tasks[i] - sum((float(tasks[i] @ b) * b for b in basis), np.zeros(tasks.shape[1]))
        if np.linalg.norm(left) > 1e-9:
            basis.append(left / np.linalg.norm(left))
            weights.append(float(priorities[i]))
    B = np.array(basis).T
    return np.eye(tasks.shape[1]) - B @ np.diag(weights) @ B.T


@given(ROWS, st.floats(0.0, 1.0))
def test_the_paper_s_projector_is_the_generalized_one_of_priority_lambda(row: Array, lam: float) -> None:
    """N' = I − λ J_d^# J_d, eq. (13): λ = 0 does not change the task, λ = 1 is the true null space."""
    given_priority = generalized_projector(np.array([row, 2.0 * row]), np.array([lam, 0.0]))
    assert_allclose(np.eye(7) - lam * pseudo_inverse(row[None, :]) @ row[None, :], given_priority, atol=1e-14)


@given(LAWS, SITUATIONS)
def test_variants_of_the_paper_s_law(law: SmoothPriority, situation: Situation) -> None:
    # With w fed forward the law equals the plain one with v + w: ḋ = v at λ = 1 for every w.
    fed, v = replace(law, feed_forward=True), law.nominal_velocity
    faster = replace(law, nominal_velocity=v + situation.approach)
    assert_allclose(fed(situation), faster(situation), atol=1e-12)
    close = situation._replace(distance=0.5 * law.critical_distance)
    assert rate(close, fed(close)) - close.approach == pytest.approx(v, abs=1e-11)
    # A one-sided law passes tasks that retreat faster than v (+ w); otherwise it is the two-sided one.
    for two_sided, speed in ((law, v), (fed, v + situation.approach)):
        velocities = replace(two_sided, one_sided=True)(situation)
        assert_array_equal(velocities, situation.nominal if -situation.pull > speed else two_sided(situation))
        assert rate(situation, velocities) == pytest.approx(
            max(rate(situation, two_sided(situation)), -situation.pull), abs=1e-11
        )


@given(LAWS, SITUATIONS, st.floats(0.0, 1.0))
def test_short_rows_stay_finite_and_bounded(law: SmoothPriority, situation: Situation, length: float) -> None:
    """|q̇ − q̇_n| ≤ 11 c for a row of any length, also 0: the undamped law would need c / |J_d|."""
    short = situation._replace(row=situation.row * (length / float(np.linalg.norm(situation.row))))
    velocities = law(short)
    assert np.isfinite(velocities).all()
    c = abs(law.correction(short.distance, short.pull, short.approach))
    assert np.linalg.norm(velocities - short.nominal) <= 11.0 * c + 1e-12


def test_damping_of_short_rows() -> None:
    # No lever, no motion: q̇ = q̇_n; a row of normal length changes it (positive control).
    nominal = np.linspace(-1.0, 1.0, 7)
    assert_array_equal(along_row(nominal, np.zeros(7), 0.3), nominal)
    assert np.abs(along_row(nominal, np.full(7, 0.2), 0.3) - nominal).max() > 0.1
    # μ² is 0 from |J_d| = .12 upwards and positive below, with slope 0 at .12.
    edge = AUTHORITY**2
    assert row_damping(edge) == 0.0 == row_damping(4.0) and row_damping(0.5 * edge) > 0.0
    assert row_damping(edge * (1.0 - 1e-4)) / (edge * 1e-4) < 1e-3
    lengths = np.linspace(0.0, AUTHORITY, 50)
    assert (np.diff([row_damping(float(x) ** 2) for x in lengths]) < 0.0).all()
    # At |J_d| = .12 m/rad the wanted rate is reached exactly, at half of that only in part.
    for length, exact in ((AUTHORITY * 1.000001, True), (0.3, True), (AUTHORITY / 2.0, False)):
        row = np.full(7, length / np.sqrt(7.0))
        reached = float(row @ along_row(np.zeros(7), row, 0.3))
        assert (abs(reached - 0.3) < 1e-12) is exact and 0.0 < reached < 0.3 + 1e-12


@given(
    vectors(ENTRIES).filter(lambda row: float(np.linalg.norm(row)) > 0.1),
    st.floats(0.0, 0.3),
    st.floats(0.0, 1e-6),
)
def test_continuous_in_the_rows_length(row: Array, length: float, change: float) -> None:
    """A row longer by δ changes q̇ by at most 300 δ per m/s of correction, also where damping begins."""
    unit, nominal = row / np.linalg.norm(row), np.zeros(7)
    before, after = along_row(nominal, unit * length, 1.0), along_row(nominal, unit * (length + change), 1.0)
    assert np.linalg.norm(after - before) <= 300.0 * change + 1e-12


FIELDS = st.builds(PotentialField, st.floats(0.1, 0.6), st.floats(1e-4, 0.05), st.floats(0.01, 0.1))


@given(SEEDS, st.floats(0.0, 1.0), st.floats(-0.2, 50.0))
def test_always_on_is_eq_11(seed: int, v: float, distance: float) -> None:
    """q̇ = J_a^# v + N_a q̇_n at every distance, with numpy's matrices."""
    situation = regular_situation(seed)._replace(distance=distance)
    J_a = situation.row[None, :]
    expected = np.linalg.pinv(J_a)[:, 0] * v + null_space_projector(J_a) @ situation.nominal
    assert_allclose(StrictPriority(v)(situation), expected, atol=1e-11)


@given(SEEDS, st.floats(0.001, 0.5))
def test_switched_is_strict_priority_or_the_task_alone(seed: int, way: float) -> None:
    """Strict priority up to d_m, the task alone beyond; 1 mm from d_m the paper's law for n → ∞."""
    situation = regular_situation(seed)
    always, switched = StrictPriority(0.3), StrictPriority(0.3, 0.15)
    for distance in (0.15, 0.15 - way, 0.15 - 1e-6 * way, 0.15 + 1e-6 * way, 0.15 + way):
        near = situation._replace(distance=distance)
        assert_array_equal(switched(near), always(near) if distance <= 0.15 else near.nominal)
        if abs(distance - 0.15) == pytest.approx(way):
            assert_allclose(SmoothPriority(0.15, 1e4, 0.3)(near), switched(near), atol=1e-12)


@given(FIELDS, st.floats(0.02, 1.0))
def test_the_push_is_the_slope_of_the_potential(law: PotentialField, distance: float) -> None:
    """f = −dU/dd by finite differences, U = ½ η (1/d − 1/d₀)² below d₀, 0 above.

    Below the least distance f is constant.
    """

    def potential(d: float) -> float:
        return (
            0.5
            * law.field_strength
            * (1.0 / min(d, law.influence_distance) - 1.0 / law.influence_distance) ** 2
        )

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


def test_an_influence_inside_the_least_distance_has_no_effect() -> None:
    for influence in (0.02, 0.05):
        law = PotentialField(influence, 0.005, 0.05)
        assert [law.push(d) for d in (-0.1, 0.0, 0.03, 0.2)] == [0.0] * 4 and law.activation(0.0) == 0.0


@given(SEEDS, FIELDS)
def test_the_push_does_not_depend_on_the_task(seed: int, law: PotentialField) -> None:
    situation = regular_situation(seed)
    for nominal in (situation.nominal, 0.0 * situation.nominal):
        change = law(situation._replace(nominal=nominal)) - nominal
        assert_allclose(change, situation.row * law.push(situation.distance), atol=1e-9, rtol=1e-9)


LAW = BarrierQP(0.15, 5.0, feed_forward=True)
SIZES = st.sampled_from([6, 7, 14])
PAIRS = st.integers(1, 60)


class Problem(NamedTuple):
    """A complete situation and its inequalities J_d q̇ ≥ `least` (pairs,)."""

    situation: Situation
    rows: Array
    least: Array
    lower: Array
    upper: Array


def problem(seed: int, n: int, pairs: int, feasible: bool) -> Problem:
    """A random problem; if feasible, with regular rows and a velocity that satisfies all inequalities."""
    rng = np.random.default_rng(seed)
    lengths = (
        rng.uniform(1.1 * AUTHORITY, 0.8, pairs)
        if feasible
        else rng.choice([0.0, 1e-4, 0.03, 0.1, 0.5], pairs)
    )
    rows = rng.normal(size=(pairs, n))
    rows *= (lengths / np.linalg.norm(rows, axis=1))[:, None]
    lower, upper = -rng.uniform(0.3, 2.0, n), rng.uniform(0.3, 2.0, n)
    inside = rng.uniform(0.9 * lower, 0.9 * upper)
    least = rows @ inside - rng.uniform(0.01, 0.5, pairs) if feasible else rng.uniform(-0.5, 0.5, pairs)
    approaches = rng.uniform(-0.3, 0.3, pairs)
    distances = 0.15 - (least - approaches) / 5.0
    nominal = rng.uniform(lower, upper)
    near = int(np.argmin(distances))
    situation = Situation(
        np.zeros(n), nominal, rows[near], float(distances[near]), float(approaches[near]),
        None, lower, upper, rows, distances, approaches,
    )  # fmt: skip
    return Problem(situation, rows, least, lower, upper)


def least_distance_solution(start: Array, G: Array, h: Array) -> Array:
    """x nearest to `start` with G x ≥ h, by Lawson and Hanson's reduction to non-negative least squares."""
    E = np.vstack([G.T, (h - G @ start)[None, :]])
    target = np.zeros(len(E))
    target[-1] = 1.0
    weights, _ = nnls(E, target, maxiter=10_000)
    residual = E @ weights - target
    return start - residual[:-1] / residual[-1]


@given(SEEDS, SIZES, PAIRS)
def test_the_nearest_velocity_that_satisfies_every_inequality_is_found(seed: int, n: int, pairs: int) -> None:
    p = problem(seed, n, pairs, feasible=True)
    # The task alone violates an inequality.
    assume((p.rows @ p.situation.nominal < p.least).any())
    velocities = LAW(p.situation)
    assert (p.rows @ velocities >= p.least - 1e-5).all()
    assert (velocities >= p.lower).all() and (velocities <= p.upper).all()
    if pairs <= 20:
        G, h = np.vstack([p.rows, np.eye(n), -np.eye(n)]), np.concatenate([p.least, p.lower, -p.upper])
        assert_allclose(velocities, least_distance_solution(p.situation.nominal, G, h), atol=2e-5)


@given(SEEDS, SIZES, PAIRS)
def test_optimality_conditions_also_for_infeasible_problems(seed: int, n: int, pairs: int) -> None:
    """q̇ − q̇_n = Σ J_dᵀ s / ρ with each row's shortfall s, ρ = μ² + 1e-8, except for joints at a bound."""
    p = problem(seed, n, pairs, feasible=False)
    velocities = LAW(p.situation)
    assert (velocities >= p.lower).all() and (velocities <= p.upper).all()
    forces = np.maximum(p.least - p.rows @ velocities, 0.0) / (
        row_dampings((p.rows**2).sum(axis=1)) + HARDNESS
    )
    gradient = velocities - p.situation.nominal - p.rows.T @ forces
    scale = 1.0 + float((np.abs(p.rows) * forces[:, None]).sum(axis=0).max())
    # At a lower bound the gradient may be positive, at an upper one negative.
    gradient[(velocities <= p.lower + 1e-6) & (gradient > 0.0)] = 0.0
    gradient[(velocities >= p.upper - 1e-6) & (gradient < 0.0)] = 0.0
    assert np.abs(gradient).max() < 1e-5 * scale


@given(SEEDS, st.floats(1e-5, 1.0), st.booleans(), st.booleans())
def test_one_pair_is_a_maximum(seed: int, length: float, fed: bool, listed: bool) -> None:
    """J_d q̇ = max(−u, −γ (d − d_m) + w): c = max(0, …) along the damped row, listed as a pair or not."""
    law = BarrierQP(0.15, 5.0, fed)
    situation = regular_situation(seed)
    situation = situation._replace(row=situation.row * (length / float(np.linalg.norm(situation.row))))
    pair = {
        "rows": situation.row[None],
        "distances": np.array([situation.distance]),
        "approaches": np.array([situation.approach]),
    }
    seen = situation._replace(**pair) if listed else situation
    least = -5.0 * (situation.distance - 0.15) + (situation.approach if fed else 0.0)
    c = max(0.0, least + situation.pull)
    assert law.line_rate(situation.distance, situation.pull, situation.approach, 0.0) == pytest.approx(
        c - situation.pull
    )
    assert_allclose(law(seen), along_row(situation.nominal, situation.row, c), atol=2e-5)


@given(SEEDS, st.floats(0.0, 1e-4))
def test_rows_too_short_for_the_solver_hardly_matter(seed: int, length: float) -> None:
    """DAQP ignores rows of a few µm/rad, which changes q̇ by 1 mrad/s at most."""
    situation = regular_situation(seed)
    row = situation.row * (length / float(np.linalg.norm(situation.row)))
    short = situation._replace(row=row, distance=0.05)
    least = LAW.line_rate(0.05, short.pull, short.approach, 0.0)
    assert_allclose(LAW(short), along_row(short.nominal, row, least + short.pull), atol=2e-3)


def test_a_permitted_approach_is_not_changed() -> None:
    # An approach slower than γ (d − d_m) passes unchanged, to the bit.
    row = np.array([0.3, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0])
    situation = Situation(np.zeros(7), -row, row, 0.25, 0.0)
    assert situation.pull == pytest.approx(0.25)
    assert_array_equal(LAW(situation), situation.nominal)
    # 1 up to d_m; .6 at γ (d − d_m) = .4 m/s; 0 from 1 m/s on.
    law = BarrierQP(0.15, 5.0)
    assert [law.activation(d) for d in (-0.1, 0.15, 0.23, 0.35, 0.5)] == pytest.approx(
        [1.0, 1.0, 0.6, 0.0, 0.0]
    )
    # ḋ = J_d q̇ − w in steps of 5 ms from .4 m against a pull of .5 m/s: with w fed forward d never falls
    # below d_m.
    for w in (0.0, 0.2, 0.6):
        for law, floor in ((BarrierQP(0.15, 5.0, True), 0.15), (BarrierQP(0.15, 5.0), 0.15 - w / 5.0)):
            d = 0.4
            for _ in range(2000):
                d += 0.005 * (law.line_rate(d, 0.5, w, 0.0) - w)
                assert d > floor - 1e-12
            assert d == pytest.approx(floor, abs=1e-6)


def corner(distance: float, other: float) -> Situation:
    """Two obstacles at right angles to the arm's escape: avoiding only one leads into the other."""
    rows = np.array([[0.4, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0], [-0.3, 0.4, 0.2, 0.0, 0.0, 0.0, 0.0]])
    distances = np.array([distance, other])
    near = int(np.argmin(distances))
    nominal = np.array([0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.5])
    return Situation(
        np.zeros(7), nominal, rows[near], float(distances[near]), 0.0, None, None, None, rows, distances
    )


def test_several_pairs() -> None:
    # Positive control: the law for the closest pair approaches the other too fast; all pairs do not.
    both = corner(0.15, 0.1501)
    assert both.rows is not None
    alone = LAW(both._replace(rows=None, distances=None))
    assert float(both.rows[1] @ alone) < -0.1
    assert (both.rows @ LAW(both) >= [-1e-6, -0.0005 - 1e-6]).all()

    # One distance grows, the other shrinks: the QP is continuous, a law for the closest pair jumps.
    def at(tie: float) -> Situation:
        return corner(0.16 + tie, 0.16 - tie)

    assert 0.4 < jump_ratio(lambda tie: LAW(at(tie)), -0.03, 0.03) < 0.6
    assert jump_ratio(lambda tie: SmoothPriority(0.15, 6.0, 0.3)(at(tie)), -0.03, 0.03) > 0.9
    # An arm between two approaching obstacles: neither has priority, and the motion across them continues.
    row = np.array([0.3, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0])
    nominal = np.array([0.3, 0.4, 0.0, 0.0, 0.0, 0.0, 0.7])
    rows, distances = np.array([row, -row]), np.array([0.09, 0.09])
    velocities = LAW(Situation(np.zeros(7), nominal, row, 0.09, 0.0, rows=rows, distances=distances))
    assert float(row @ velocities) == pytest.approx(0.0, abs=1e-6)
    assert velocities[6] == pytest.approx(0.7, abs=1e-6)
    # A joint beyond its stop (lower > upper) returns at the lower bound, without an error.
    situation = regular_situation(8)._replace(distance=0.1, lower=np.full(7, -0.5), upper=np.full(7, 0.5))
    assert situation.lower is not None
    situation.lower[2] = 0.8
    velocities = LAW(situation)
    assert velocities[2] == 0.8 and np.abs(np.delete(velocities, 2)).max() <= 0.5


@pytest.mark.parametrize(("setup_flag", "solve_flag"), [(-1, 0), (0, -2)])
def test_a_solver_that_fails(monkeypatch: pytest.MonkeyPatch, setup_flag: int, solve_flag: int) -> None:
    """If DAQP fails, q̇ stays inside the bounds and clears the most urgent pair."""
    solved = np.full(7, np.nan), 0.0, solve_flag, {}
    methods = {
        "setup": lambda *_: (setup_flag, 0.0),
        "soft_weights": lambda *_, **__: None,
        "solve": lambda _: solved,
    }
    monkeypatch.setattr("controllers.laws.barrier_qp.daqp.Model", type("Stubborn", (), methods))
    situation = corner(0.15, 0.13)
    assert situation.rows is not None
    assert float(situation.rows[1] @ LAW(situation)) == pytest.approx(LAW.line_rate(0.13, 0.0, 0.0, 0.0))
    assert np.abs(LAW(situation._replace(lower=np.full(7, -0.5), upper=np.full(7, 0.5)))).max() <= 0.5


@given(st.lists(st.floats(0.0, 0.1), max_size=20))
def test_dampings_of_an_array_equal_the_single_ones(squares: list[float]) -> None:
    assert_allclose(row_dampings(np.array(squares)), [row_damping(square) for square in squares], atol=1e-15)
