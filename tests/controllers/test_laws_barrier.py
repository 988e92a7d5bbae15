"""The barrier QP against other ways of solving it: optimality conditions, a non-negative least squares, and one pair by hand."""

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import nnls

from controllers.kinematics import Array
from controllers.laws.barrier_qp import HARDNESS, BarrierQP
from controllers.laws.situation import AUTHORITY, Situation, along_row, row_damping, row_dampings
from controllers.laws.smooth_priority import SmoothPriority
from tests.controllers.test_laws_all import SEEDS, jump_ratio, regular_situation

LAW = BarrierQP(0.15, 5.0, feed_forward=True)
SIZES = st.sampled_from([6, 7, 14])
PAIRS = st.integers(1, 60)


class Problem(NamedTuple):
    """A situation with every field filled, and J_d q̇ ≥ `least` (pairs,) that it amounts to."""

    situation: Situation
    rows: Array
    least: Array
    lower: Array
    upper: Array


def problem(seed: int, n: int, pairs: int, feasible: bool) -> Problem:
    """Return a random problem; a feasible one has regular rows and a velocity inside all its inequalities."""
    rng = np.random.default_rng(seed)
    lengths = rng.uniform(1.1 * AUTHORITY, 0.8, pairs) if feasible else rng.choice([0.0, 1e-4, 0.03, 0.1, 0.5], pairs)
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
    """Return the x nearest to `start` with G x ≥ h, by Lawson and Hanson's reduction to non-negative least squares."""
    E = np.vstack([G.T, (h - G @ start)[None, :]])
    target = np.zeros(len(E))
    target[-1] = 1.0
    weights, _ = nnls(E, target, maxiter=10_000)
    residual = E @ weights - target
    return start - residual[:-1] / residual[-1]


@given(SEEDS, SIZES, PAIRS)
def test_every_inequality_holds_and_no_nearer_velocity_does_it(seed: int, n: int, pairs: int) -> None:
    p = problem(seed, n, pairs, feasible=True)
    # The task alone violates something.
    assume((p.rows @ p.situation.nominal < p.least).any())
    velocities = LAW(p.situation)
    assert (p.rows @ velocities >= p.least - 1e-5).all()
    assert (velocities >= p.lower).all() and (velocities <= p.upper).all()
    if pairs <= 20:
        G, h = np.vstack([p.rows, np.eye(n), -np.eye(n)]), np.concatenate([p.least, p.lower, -p.upper])
        assert_allclose(velocities, least_distance_solution(p.situation.nominal, G, h), atol=2e-5)


@given(SEEDS, SIZES, PAIRS)
def test_optimality_conditions_also_if_it_is_impossible(seed: int, n: int, pairs: int) -> None:
    """q̇ − q̇_n = Σ J_dᵀ s / ρ with the shortfall s of each row and ρ = μ² + 1e-8, but for joints held by a bound."""
    p = problem(seed, n, pairs, feasible=False)
    velocities = LAW(p.situation)
    assert (velocities >= p.lower).all() and (velocities <= p.upper).all()
    forces = np.maximum(p.least - p.rows @ velocities, 0.0) / (row_dampings((p.rows**2).sum(axis=1)) + HARDNESS)
    gradient = velocities - p.situation.nominal - p.rows.T @ forces
    scale = 1.0 + float((np.abs(p.rows) * forces[:, None]).sum(axis=0).max())
    # At its lower bound a joint is held back from going lower, so that the gradient may be positive there, and vice versa.
    gradient[(velocities <= p.lower + 1e-6) & (gradient > 0.0)] = 0.0
    gradient[(velocities >= p.upper - 1e-6) & (gradient < 0.0)] = 0.0
    assert np.abs(gradient).max() < 1e-5 * scale


@given(SEEDS, st.floats(1e-5, 1.0), st.booleans(), st.booleans())
def test_one_pair_is_a_maximum(seed: int, length: float, fed: bool, listed: bool) -> None:
    """J_d q̇ = max(−u, −γ (d − d_m) + w): c = max(0, …) along the row, damped as any law's; listed as a pair or not."""
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
    assert law.line_rate(situation.distance, situation.pull, situation.approach, 0.0) == pytest.approx(c - situation.pull)
    assert_allclose(law(seen), along_row(situation.nominal, situation.row, c), atol=2e-5)


@given(SEEDS, st.floats(0.0, 1e-4))
def test_rows_too_short_for_the_solver_hardly_matter(seed: int, length: float) -> None:
    """DAQP passes over rows of a few µm/rad; that is a millirad a second of motion at most."""
    situation = regular_situation(seed)
    row = situation.row * (length / float(np.linalg.norm(situation.row)))
    short = situation._replace(row=row, distance=0.05)
    least = LAW.line_rate(0.05, short.pull, short.approach, 0.0)
    assert_allclose(LAW(short), along_row(short.nominal, row, least + short.pull), atol=2e-3)


def test_what_is_permitted() -> None:
    # An approach slower than γ (d − d_m) passes to the bit.
    row = np.array([0.3, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0])
    situation = Situation(np.zeros(7), -row, row, 0.25, 0.0)
    assert situation.pull == pytest.approx(0.25)
    assert_array_equal(LAW(situation), situation.nominal)
    # 1 up to d_m; at γ (d − d_m) = .4 m/s .6 is left; 0 from 1 m/s on.
    law = BarrierQP(0.15, 5.0)
    assert [law.activation(d) for d in (-0.1, 0.15, 0.23, 0.35, 0.5)] == pytest.approx([1.0, 1.0, 0.6, 0.0, 0.0])
    # ḋ = J_d q̇ − w in steps of 5 ms from .4 m against a pull of .5 m/s: with w fed forward d never falls below d_m.
    for w in (0.0, 0.2, 0.6):
        for law, floor in ((BarrierQP(0.15, 5.0, True), 0.15), (BarrierQP(0.15, 5.0), 0.15 - w / 5.0)):
            d = 0.4
            for _ in range(2000):
                d += 0.005 * (law.line_rate(d, 0.5, w, 0.0) - w)
                assert d > floor - 1e-12
            assert d == pytest.approx(floor, abs=1e-6)


def corner(distance: float, other: float) -> Situation:
    """Two obstacles at right angles to the arm's way out: clearing either alone runs into the other."""
    rows = np.array([[0.4, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0], [-0.3, 0.4, 0.2, 0.0, 0.0, 0.0, 0.0]])
    distances = np.array([distance, other])
    near = int(np.argmin(distances))
    nominal = np.array([0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.5])
    return Situation(np.zeros(7), nominal, rows[near], float(distances[near]), 0.0, None, None, None, rows, distances)


def test_several_pairs() -> None:
    # In the corner the closest pair alone leaves the other approach too fast; all pairs together do not (positive control).
    both = corner(0.15, 0.1501)
    assert both.rows is not None
    alone = LAW(both._replace(rows=None, distances=None))
    assert float(both.rows[1] @ alone) < -0.1
    assert (both.rows @ LAW(both) >= [-1e-6, -0.0005 - 1e-6]).all()

    # One distance grows and the other shrinks: q̇ of the QP is continuous, q̇ of a law for the closest pair jumps at the tie.
    def at(tie: float) -> Situation:
        return corner(0.16 + tie, 0.16 - tie)

    assert 0.4 < jump_ratio(lambda tie: LAW(at(tie)), -0.03, 0.03) < 0.6
    assert jump_ratio(lambda tie: SmoothPriority(0.15, 6.0, 0.3)(at(tie)), -0.03, 0.03) > 0.9
    # An arm between two obstacles that close in: neither comes first, and the motion across them goes on.
    row = np.array([0.3, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0])
    nominal = np.array([0.3, 0.4, 0.0, 0.0, 0.0, 0.0, 0.7])
    rows, distances = np.array([row, -row]), np.array([0.09, 0.09])
    velocities = LAW(Situation(np.zeros(7), nominal, row, 0.09, 0.0, rows=rows, distances=distances))
    assert float(row @ velocities) == pytest.approx(0.0, abs=1e-6)
    assert velocities[6] == pytest.approx(0.7, abs=1e-6)
    # A joint beyond its stop, lower > upper: it comes back as fast as the lower bound says, and nothing fails.
    situation = regular_situation(8)._replace(distance=0.1, lower=np.full(7, -0.5), upper=np.full(7, 0.5))
    assert situation.lower is not None
    situation.lower[2] = 0.8
    velocities = LAW(situation)
    assert velocities[2] == 0.8 and np.abs(np.delete(velocities, 2)).max() <= 0.5


@pytest.mark.parametrize(("setup_flag", "solve_flag"), [(-1, 0), (0, -2)])
def test_a_solver_that_gives_up(monkeypatch: pytest.MonkeyPatch, setup_flag: int, solve_flag: int) -> None:
    """Whatever DAQP says, the arm gets a velocity inside its bounds that clears the pair which needs it most."""
    solved = np.full(7, np.nan), 0.0, solve_flag, {}
    methods = {"setup": lambda *_: (setup_flag, 0.0), "soft_weights": lambda *_, **__: None, "solve": lambda _: solved}
    monkeypatch.setattr("controllers.laws.barrier_qp.daqp.Model", type("Stubborn", (), methods))
    situation = corner(0.15, 0.13)
    assert situation.rows is not None
    assert float(situation.rows[1] @ LAW(situation)) == pytest.approx(LAW.line_rate(0.13, 0.0, 0.0, 0.0))
    assert np.abs(LAW(situation._replace(lower=np.full(7, -0.5), upper=np.full(7, 0.5)))).max() <= 0.5


@given(st.lists(st.floats(0.0, 0.1), max_size=20))
def test_many_dampings_are_the_single_ones(squares: list[float]) -> None:
    assert_allclose(row_dampings(np.array(squares)), [row_damping(square) for square in squares], atol=1e-15)
