"""M of section III against numpy: orthogonal, dependent, single and singular tasks; refused settings."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from controllers.errors import BadSetting
from controllers.kinematics import Array
from controllers.stability import TOLERANCE, Analysis, analyse

SEEDS = st.integers(0, 10_000)
SHARES = st.floats(0.0, 1.0)
GAINS = st.floats(0.1, 20.0)
DIMENSIONS = st.sampled_from([1, 2, 3, 6])


def tasks(seed: int, m: int, n: int = 7) -> tuple[Array, Array]:
    """A random J_d (n,) and J_b (m, n)."""
    random = np.random.default_rng(seed)
    return random.normal(size=n) * 0.4, random.normal(size=(m, n)) * 0.4


def sym(matrix: Array) -> Array:
    return np.asarray(0.5 * (matrix + matrix.T), np.float64)


def in_metric(analysis: Analysis, row: Array, J_b: Array) -> Array:
    """M with e_a in units of |J_d| and e_b in the metric e_bᵀ (J_b J_bᵀ)⁻¹ e_b."""
    scale = np.zeros_like(analysis.M)
    scale[0, 0] = np.linalg.norm(row)
    scale[1:, 1:] = np.linalg.cholesky(J_b @ J_b.T)
    return np.asarray(np.linalg.solve(scale, analysis.M @ scale), np.float64)


@given(SEEDS, DIMENSIONS, SHARES, GAINS, GAINS)
def test_m_is_eq_25(seed: int, m: int, lam: float, K_a: float, K_b: float) -> None:
    """Blocks of eqs (12) and (21) with numpy's pseudo-inverses and N' as a matrix."""
    row, J_b = tasks(seed, m)
    J_a, J_b_sharp = row[None, :], np.linalg.pinv(J_b)
    J_a_sharp = np.linalg.pinv(J_a)
    N_a = np.eye(len(row)) - lam * J_a_sharp @ J_a
    a = analyse(row, J_b, lam, K_a, K_b)
    assert_allclose(a.M[:1, :1], J_a @ J_a_sharp * K_a, atol=1e-9)
    assert_allclose(a.M[:1, 1:], J_a @ N_a @ J_b_sharp * K_b, atol=1e-8)
    assert_allclose(a.M[:1, 1:], (1.0 - lam) * J_a @ J_b_sharp * K_b, atol=1e-8)
    assert_allclose(a.M[1:, :1], J_b @ J_a_sharp * K_a, atol=1e-8)
    assert_allclose(a.M[1:, 1:], J_b @ N_a @ J_b_sharp * K_b, atol=1e-8)
    assert a.coupling == pytest.approx(float(np.linalg.norm(J_a @ J_b_sharp, 2)), rel=1e-8)
    assert a.smallest_eigenvalue == pytest.approx(float(np.linalg.eigvalsh(sym(a.M))[0]), abs=1e-9)


@given(SEEDS, SHARES, GAINS, GAINS)
def test_a_posture_task_is_a_task_with_the_identity(seed: int, lam: float, K_a: float, K_b: float) -> None:
    """None means J_b = I, entry by entry; such tasks are always dependent: rank 7 < 1 + 7, ρ = 1, ‖J_a J_b^#‖ = |J_d|."""
    row, _ = tasks(seed, 1)
    short, long = analyse(row, None, lam, K_a, K_b), analyse(row, np.eye(7), lam, K_a, K_b)
    assert_allclose(short.M, long.M, atol=1e-12)
    for name in ("smallest_eigenvalue", "slowest_mode", "coupling", "angle", "rho", "survival"):
        assert getattr(short, name) == pytest.approx(getattr(long, name), abs=1e-7), name
    for a in (short, long):
        assert (a.rank_a, a.rank_b, a.rank_stack) == (1, 7, 7)
        assert not (a.independent or a.orthogonal)
        assert a.survival == pytest.approx(1.0 - lam) and a.slowest_mode == pytest.approx(0.0, abs=1e-12)
        assert a.coupling == pytest.approx(float(np.linalg.norm(row)))
    assert short.joint_task and not long.joint_task


@given(SEEDS, DIMENSIONS, SHARES, GAINS, GAINS)
def test_the_surviving_share_and_the_slowest_mode(
    seed: int, m: int, lam: float, K_a: float, K_b: float
) -> None:
    # In the metric e_bᵀ (J_b J_bᵀ)⁻¹ e_b, M_bb/K_b is symmetric with eigenvalues 1 − λ ρ² once, and 1.
    row, J_b = tasks(seed, m)
    a = analyse(row, J_b, lam, K_a, K_b)
    block = in_metric(a, row, J_b)[1:, 1:] / K_b
    assert_allclose(block, block.T, atol=1e-7)
    assert_allclose(np.linalg.eigvalsh(sym(block)), [a.survival] + [1.0] * (m - 1), atol=1e-7)
    basis = np.linalg.svd(J_b, full_matrices=False)[2]
    assert a.rho == pytest.approx(float(np.linalg.norm(basis @ row) / np.linalg.norm(row)), abs=1e-9)
    assert a.survival == pytest.approx(1.0 - lam * a.rho**2, abs=1e-12)
    assert math.cos(a.angle) == pytest.approx(a.rho, abs=1e-9)
    # For independent tasks and any λ all eigenvalues of M are real and positive: the frozen loop is stable.
    assume(a.independent)
    values = np.linalg.eigvals(a.M)
    # Nearly equal eigenvalues of an asymmetric matrix are only accurate to the root of the machine precision.
    assert_allclose(values.imag, 0.0, atol=1e-4)
    assert values.real.min() == pytest.approx(a.slowest_mode, abs=1e-4, rel=1e-4)
    assert a.slowest_mode > 0.0 and a.smallest_eigenvalue <= a.slowest_mode + 1e-6
    # If the condition holds, V falls for every error; if not, V does not fall along an eigenvector of sym(M).
    if a.condition_holds:
        for e in np.random.default_rng(seed).normal(size=(20, m + 1)) * (
            [1.0] * (m + 1) if lam else [0.0] + [1.0] * m
        ):
            assert a.lyapunov_rate(e) < 0.0
    else:
        e = np.linalg.eigh(sym(a.M))[1][:, 0]
        assert a.lyapunov_rate(e) > -1e-6


@given(SEEDS, DIMENSIONS, st.floats(0.01, 1.0), GAINS)
def test_when_the_condition_holds_in_the_natural_metric(seed: int, m: int, lam: float, K: float) -> None:
    """With K_a = K_b and in the metric of the two tasks, sym(M) > 0 if and only if ρ² (1 + λ²/4) < 1."""
    row, J_b = tasks(seed, m)
    a = analyse(row, J_b, lam, K, K)
    margin = 1.0 - a.rho**2 * (1.0 + 0.25 * lam**2)
    least = float(np.linalg.eigvalsh(sym(in_metric(a, row, J_b)))[0])
    if abs(margin) > 1e-6:
        assert (least > 0.0) == (margin > 0.0)


def test_the_condition_by_example() -> None:
    # Positive control of the test above: both results occur, also for independent tasks.
    answers = [analyse(*tasks(seed, 3), 0.7, 2.0, 2.0) for seed in range(200)]
    assert all(a.independent for a in answers)
    assert 10 < sum(a.condition_holds for a in answers) < 190
    # Sufficient, not necessary: sym(M) has a negative eigenvalue and V rises for a while, yet e tends to 0.
    row, J_b = np.array([0.6, 0.2, 0.0]), np.array([[0.9, 0.0, 0.0], [0.0, 0.0, 0.4]])
    a = analyse(row, J_b, 0.9, 1.0, 1.0)
    assert a.independent and not a.orthogonal and not a.condition_holds
    assert a.smallest_eigenvalue < -0.1 and a.slowest_mode > 0.05
    e = np.linalg.eigh(sym(a.M))[1][:, 0]
    values = [a.lyapunov(e)]
    for _ in range(20_000):
        e = e - 0.01 * a.M @ e
        values.append(a.lyapunov(e))
    assert max(values) > 1.001 * values[0] and values[-1] < 1e-6 * values[0]


@given(SEEDS, st.sampled_from([1, 3, 6]), SHARES, GAINS, GAINS)
def test_orthogonal_tasks_have_the_properties_of_the_paper(
    seed: int, m: int, lam: float, K_a: float, K_b: float
) -> None:
    """J_a J_b^# = 0, eq. (16): M = diag(K_a, K_b), the task loses nothing, and sym(M) > 0 for any λ."""
    row, J_b = tasks(seed, m)
    row = row - np.linalg.pinv(J_b) @ (J_b @ row)
    a = analyse(row, J_b, lam, K_a, K_b)
    assert a.orthogonal and a.independent and a.condition_holds
    assert_allclose(a.M, np.diag([K_a] + [K_b] * m), atol=1e-7)
    assert a.coupling == pytest.approx(0.0, abs=1e-7) and a.survival == pytest.approx(1.0)
    assert a.slowest_mode == pytest.approx(min(K_a, K_b)) == a.smallest_eigenvalue
    assert a.angle == pytest.approx(math.pi / 2.0)


@given(SEEDS, st.sampled_from([1, 3, 6]), st.floats(0.01, 1.0), GAINS, GAINS)
def test_a_row_inside_the_task_is_dependent(seed: int, m: int, lam: float, K_a: float, K_b: float) -> None:
    """A critical point on the hand: rank 3 < 1 + 3, eq. (15), ρ = 1, a mode at rest, and the condition fails."""
    _, J_b = tasks(seed, m)
    row = np.random.default_rng(seed + 1).normal(size=m) @ J_b
    a = analyse(row, J_b, lam, K_a, K_b)
    assert (a.rank_a, a.rank_b, a.rank_stack) == (1, m, m)
    assert not (a.independent or a.orthogonal or a.condition_holds)
    assert a.rho == pytest.approx(1.0) and a.survival == pytest.approx(1.0 - lam)
    assert a.slowest_mode == pytest.approx(0.0, abs=1e-9) and a.angle == pytest.approx(0.0, abs=1e-6)


@given(SEEDS, DIMENSIONS, GAINS, GAINS)
def test_one_of_the_tasks_alone(seed: int, m: int, K_a: float, K_b: float) -> None:
    # λ = 0: M_bb = K_b, e_a = 0 and the task's error falls as exp(−K_b t), for any two tasks.
    row, J_b = tasks(seed, m)
    a = analyse(row, J_b, 0.0, K_a, K_b)
    assert_allclose(a.M[1:, 1:], K_b * np.eye(m), atol=1e-7)
    assert a.condition_holds and a.survival == 1.0
    e = a.error(0.3, np.random.default_rng(seed).normal(size=m))
    assert e[0] == 0.0 and a.lyapunov_rate(e) == pytest.approx(-2.0 * K_b * a.lyapunov(e))
    # Positive control: with equal gains and λ = 0.5, nearly parallel tasks fail the condition.
    assert not analyse(J_b[0] + 1e-3 * row, J_b, 0.5, K_a, K_a).condition_holds
    # λ = 1 is strict priority, eq. (11): the task does not affect avoidance, M_ab = 0, for any two tasks.
    a = analyse(row, J_b, 1.0, K_a, K_b)
    assert_allclose(a.M[0, 1:], 0.0, atol=1e-12)
    assert a.slowest_mode == pytest.approx(min(K_a, K_b * a.survival), rel=1e-6)


def test_degenerate_inputs() -> None:
    # A task without one or all of its directions: lower rank, finite M, the condition fails.
    row, J_b = tasks(2, 3)
    J_b[2] = 2.0 * J_b[0] - J_b[1]
    a = analyse(row, J_b, 0.5, 2.0, 2.0)
    assert (a.rank_a, a.rank_b, a.rank_stack) == (1, 2, 3) and a.independent
    assert a.slowest_mode == 0.0 and not a.condition_holds
    assert_allclose(a.coupling, np.linalg.norm(row @ np.linalg.pinv(J_b)), rtol=1e-9)
    for damped in (False, True):
        nothing = analyse(row, np.zeros((3, 7)), 0.5, 2.0, 2.0, damped)
        assert (nothing.rank_b, nothing.rank_stack) == (0, 1)
        assert_allclose(nothing.M, np.diag([nothing.M[0, 0], 0.0, 0.0, 0.0]))
        assert not nothing.condition_holds
    # K = 0 is allowed on the page: a block of M is 0; with K_a = 0 no e_a asks for λ v.
    row, J_b = tasks(1, 3)
    for K_a, K_b in ((0.0, 2.0), (2.0, 0.0), (0.0, 0.0)):
        a = analyse(row, J_b, 0.5, K_a, K_b)
        assert np.isfinite(a.M).all() and not a.condition_holds and a.slowest_mode == 0.0
    assert math.isnan(analyse(row, J_b, 0.5, 0.0, 2.0).error(0.3, np.zeros(3))[0])


@pytest.mark.parametrize("damped", [False, True])
@pytest.mark.parametrize("J_b", [np.random.default_rng(1).normal(size=(3, 7)), None], ids=["hand", "posture"])
@pytest.mark.parametrize("length", [0.0, 1e-9])
def test_no_lever(length: float, J_b: Array | None, damped: bool) -> None:
    """J_d = 0: avoidance has rank 0 and takes nothing from the task; M_aa = 0, so the condition fails."""
    a = analyse(np.full(7, length), J_b, 0.8, 2.0, 3.0, damped)
    m = 7 if J_b is None else 3
    assert (a.rank_a, a.rank_b, a.rank_stack) == (0, m, m)
    assert a.survival == 1.0 and a.rho == 0.0 and a.coupling == 0.0 and a.slowest_mode == 0.0
    assert not a.condition_holds
    assert_allclose(a.M, np.diag([0.0] + [3.0] * m), atol=1e-3 if damped else 1e-12)


@given(SEEDS, DIMENSIONS, st.floats(1e-6, 1.5))
def test_ranks_match_the_singular_values(seed: int, m: int, angle: float) -> None:
    """rank [J_a; J_b] is numpy's for [ĵ; an orthonormal basis of J_b's rows], at any angle between them."""
    row, J_b = tasks(seed, m)
    basis = np.linalg.svd(J_b, full_matrices=False)[2]
    inside = basis[0]
    outside = row - basis.T @ (basis @ row)
    outside /= np.linalg.norm(outside)
    a = analyse(0.3 * (math.cos(angle) * inside + math.sin(angle) * outside), J_b, 0.5, 1.0, 1.0)
    assert a.angle == pytest.approx(angle, abs=1e-9)
    singular = np.linalg.svd(np.vstack((math.cos(angle) * inside + math.sin(angle) * outside, basis)))[1]
    if abs(singular[-1] / TOLERANCE - 1.0) > 1e-6:
        assert a.rank_stack == int(np.count_nonzero(singular > TOLERANCE))
        assert a.independent == (singular[-1] > TOLERANCE)


def test_invalid_inputs_are_refused() -> None:
    for lam, K_a, K_b, what in (
        (-0.1, 1, 1, "λ"),
        (1.1, 1, 1, "λ"),
        (math.nan, 1, 1, "λ"),
        (0.5, -1, 1, "K_a"),
        (0.5, 1, math.inf, "K_b"),
    ):
        with pytest.raises(BadSetting, match=rf"{what} is .*; it must be"):
            analyse(*tasks(1, 3), lam, K_a, K_b)
    row, nothing = np.zeros(7), np.zeros(0)
    wrong = [
        (row, np.zeros((3, 6))),
        (row[None], np.zeros((3, 7))),
        (row, row),
        (row, np.zeros((0, 7))),
        (nothing, None),
    ]
    for J_d, J_b in [*wrong, (row + np.nan, None), (row, np.full((3, 7), np.inf))]:
        with pytest.raises(ValueError, match="J_d"):
            analyse(J_d, J_b, 0.5, 1.0, 1.0)
