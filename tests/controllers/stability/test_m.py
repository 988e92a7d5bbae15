"""M of eq. (25), and what follows from it: eigenvalues, the condition, and when V falls."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from controllers.laws.situation import textbook_projector
from controllers.stability import analyse
from tests.controllers.stability.helpers import DIMENSIONS, GAINS, SEEDS, SHARES, in_metric, sym, tasks


@given(SEEDS, DIMENSIONS, SHARES, GAINS, GAINS)
def test_m_is_eq_25(seed: int, m: int, lam: float, K_a: float, K_b: float) -> None:
    """The blocks as eqs (12) and (21) give them with numpy's pseudo-inverses and N' as a matrix."""
    row, J_b = tasks(seed, m)
    J_a, J_b_sharp = row[None, :], np.linalg.pinv(J_b)
    J_a_sharp, N_a = np.linalg.pinv(J_a), textbook_projector(row, lam)
    a = analyse(row, J_b, lam, K_a, K_b)
    assert_allclose(a.M_aa, J_a @ J_a_sharp * K_a, atol=1e-9)
    assert_allclose(a.M_ab, J_a @ N_a @ J_b_sharp * K_b, atol=1e-8)
    assert_allclose(a.M_ab, (1.0 - lam) * J_a @ J_b_sharp * K_b, atol=1e-8)
    assert_allclose(a.M_ba, J_b @ J_a_sharp * K_a, atol=1e-8)
    assert_allclose(a.M_bb, J_b @ N_a @ J_b_sharp * K_b, atol=1e-8)
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
def test_the_surviving_share_and_the_slowest_mode(seed: int, m: int, lam: float, K_a: float, K_b: float) -> None:
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
    # All eigenvalues of M are real and positive while the tasks are independent, whatever λ: the frozen loop is stable.
    assume(a.independent)
    values = np.linalg.eigvals(a.M)
    # Nearly equal eigenvalues of a matrix that is not symmetric are only good to the root of the machine's precision.
    assert_allclose(values.imag, 0.0, atol=1e-4)
    assert values.real.min() == pytest.approx(a.slowest_mode, abs=1e-4, rel=1e-4)
    assert a.slowest_mode > 0.0
    assert a.smallest_eigenvalue <= a.slowest_mode + 1e-6
    # While the flag is up no error lets V rise; while it is down the eigenvector of sym(M) does not let V fall.
    if a.condition_holds:
        for e in np.random.default_rng(seed).normal(size=(20, m + 1)) * ([1.0] * (m + 1) if lam else [0.0] + [1.0] * m):
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


def test_the_flag_by_example() -> None:
    # Positive control of the test above: both answers occur among such tasks, for independent tasks too.
    answers = [analyse(*tasks(seed, 3), 0.7, 2.0, 2.0) for seed in range(200)]
    assert all(a.independent for a in answers)
    assert 10 < sum(a.condition_holds for a in answers) < 190
    # Sufficient, not necessary: sym(M) has a negative eigenvalue, V rises for a while, and e dies out all the same.
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
