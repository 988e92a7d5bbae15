"""The laws whose avoidance comes and goes, against their papers' formulas: task activation, continuous inverse, set-based task."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from controllers.kinematics import Array, null_space_projector
from controllers.laws.continuous_inverse import ContinuousInverse
from controllers.laws.set_based_task import SetBasedTask
from controllers.laws.situation import Situation
from controllers.laws.smooth_priority import SmoothPriority
from controllers.laws.strict_priority import StrictPriority
from controllers.laws.task_activation import DIRECTION_WEIGHT, TaskActivation
from tests.controllers.test_laws_all import SEEDS, SIZES, jump_ratio, regular_situation
from tests.controllers.test_laws_hand import DIMENSIONS, near_situation, row_under_task, task

ACTIVATION = TaskActivation(0.15, 0.30, 0.30)
CONTINUOUS = ContinuousInverse(0.15, 6.0, 0.30)
FROZEN, RETURNING = SetBasedTask(0.15, 0.0), SetBasedTask(0.15, 5.0)
BUFFER = st.floats(0.14, 0.31)


# ---- task activation --------------------------------------------------------------------------------------------------------------


def bell(square: float) -> float:
    """P of a singular value of XᵀX [m²/rad²]: 0 from .12² upwards, .06² at 0."""
    return (0.06 * max(1.0 - square / 0.12**2, 0.0)) ** 2


def regularised(X: Array, A: Array, Q: Array, damped: bool) -> Array:
    """X^{#,A,Q} as in the paper, with n × n matrices and a singular value decomposition."""
    away = np.eye(X.shape[1]) - Q
    U, values, Vt = np.linalg.svd(X.T @ A @ X + DIRECTION_WEIGHT * away.T @ away)
    inverses = [1.0 / (v + bell(v)) if damped else (1.0 / v if v > 1e-12 else 0.0) for v in values]
    return Vt.T @ np.diag(inverses) @ U.T @ X.T @ A @ A


def levels(situation: Situation, a: float, v: float) -> Array:
    """The recursion over both levels, from q̇_n and I."""
    n = len(situation.row)
    J = np.eye(n) if situation.task_jacobian is None else situation.task_jacobian
    hand = (J, np.eye(len(J)), J @ situation.nominal, True)
    rho, Q = situation.nominal, np.eye(n)
    for jacobian, A, wanted, damped in ((situation.row[None, :], np.array([[a]]), np.array([v]), False), hand):
        X = jacobian @ Q
        inverse = regularised(X, A, np.eye(n), damped)
        W = X @ regularised(X, A, Q, damped)
        rho = rho + Q @ inverse @ W @ (wanted - jacobian @ rho)
        Q = Q @ (np.eye(n) - inverse @ X)
    return rho


@given(SEEDS, SIZES, st.one_of(DIMENSIONS, st.just(0)), BUFFER)
def test_task_activation_is_the_papers_recursion(seed: int, n: int, m: int, distance: float) -> None:
    """Both levels written out with n × n matrices; m = 0 stands for a task that uses every joint."""
    situation = regular_situation(seed, n, min(max(m, 1), n - 1))._replace(distance=distance)
    if m == 0:
        situation = situation._replace(task_jacobian=None)
    assert_allclose(ACTIVATION(situation), levels(situation, ACTIVATION.row_activation(distance), 0.30), atol=1e-9)


@given(SEEDS, DIMENSIONS, BUFFER)
def test_half_active_the_hand_takes_its_share(seed: int, m: int, distance: float) -> None:
    """The distance rate lies between the task's and that of the line, whatever the hand wants; where a = 1 it is v."""
    situation = near_situation(seed, m)._replace(distance=distance)
    if float(np.linalg.norm(situation.row)) < 0.12:
        return
    wanted = ACTIVATION.correction(distance, situation.pull, 0.0)
    gained = float(situation.row @ (ACTIVATION(situation) - situation.nominal))
    assert -1e-9 <= gained * math.copysign(1.0, wanted) <= abs(wanted) + 1e-9
    first = ACTIVATION(situation._replace(distance=0.15))
    assert float(situation.row @ first) == pytest.approx(0.30, abs=1e-9)


def test_an_active_task_leaves_the_hand_what_it_does_not_need() -> None:
    """a = 1: v, and the hand's own velocity, since the joints can do both; a = 0: q̇_n to the bit. The paper's law moves the hand."""
    situation = regular_situation(4)
    J, active = task(situation), situation._replace(distance=0.15)
    assert_allclose(J @ ACTIVATION(active), J @ situation.nominal, atol=1e-9)
    assert np.linalg.norm(J @ (SmoothPriority(0.15, 6.0, 0.30)(active) - situation.nominal)) > 0.1
    assert_array_equal(ACTIVATION(situation._replace(distance=0.30)), situation.nominal)


def test_activation_is_continuous_where_both_need_the_same_joint() -> None:
    """The row in the hand's row space, a from 0 to 1: without η, W = I, the hand keeps all until it loses all at a = 1."""
    situation = row_under_task(math.pi / 2.0)
    assert 0.4 < jump_ratio(lambda d: ACTIVATION(situation._replace(distance=d)), 0.14, 0.31) < 0.6
    assert 0.4 < jump_ratio(lambda turn: ACTIVATION(row_under_task(turn)), 0.0, math.pi / 2.0) < 0.6
    # Positive control: the same recursion without η and P.
    row, J = situation.row, task(situation)

    def bare(distance: float) -> Array:
        a = ACTIVATION.row_activation(distance)
        inverse = np.linalg.pinv(row[None, :])[:, 0]
        Q, change = np.eye(7) - a * np.outer(inverse, row), inverse * a * a * (0.30 + situation.pull)
        return change - Q @ np.linalg.pinv(J @ Q, rcond=1e-9) @ J @ change

    assert jump_ratio(bare, 0.149, 0.151, 100) > 0.9


# ---- continuous inverse -----------------------------------------------------------------------------------------------------------


@given(SEEDS, DIMENSIONS)
def test_the_continuous_inverse_weighs_the_inverses_of_both_sets(seed: int, m: int) -> None:
    """(1 − λ) [0, J^#] + λ [J_d; J]^# with numpy's inverses, for q̇_n = J^# ẋ_b."""
    situation = regular_situation(seed, 7, m)
    J = task(situation)
    x_b = J @ situation.nominal
    situation = situation._replace(nominal=np.linalg.pinv(J) @ x_b)
    lam = CONTINUOUS.activation(situation.distance)
    without = np.hstack([np.zeros((7, 1)), np.linalg.pinv(J)])
    both = np.linalg.pinv(np.vstack([situation.row, J]))
    expected = ((1.0 - lam) * without + lam * both) @ np.append(0.30, x_b)
    assert_allclose(CONTINUOUS(situation), expected, atol=1e-8)


@given(SEEDS)
def test_where_the_joints_cannot_do_both_it_is_a_compromise(seed: int) -> None:
    """A task in every joint: the least squares of both, |J_d|² / (1 + |J_d|²) of the retreat, up to the damping."""
    situation = regular_situation(seed)._replace(distance=0.1, task_jacobian=None)
    row, c = situation.row, 0.30 + situation.pull
    # |J_d Δ − c|² + |Δ|² as one fit.
    fit = np.linalg.lstsq(np.vstack([row, np.eye(7)]), np.append(c, np.zeros(7)), rcond=None)[0]
    change = CONTINUOUS(situation) - situation.nominal
    assert_allclose(change, fit, atol=0.06**2 * abs(c))
    assert_allclose(CONTINUOUS(situation._replace(task_jacobian=np.eye(7))) - situation.nominal, change, atol=1e-9)
    # Neither comes first: less than the paper's law gives the distance, more than with the hand first, which gives it nothing.
    assert 0.0 < abs(float(row @ change)) < abs(c)


def test_the_compromise_is_continuous() -> None:
    """As the row turns into the hand's row space, the rank of the stack falls, and q̇ does not jump; numpy's inverse does."""
    assert 0.4 < jump_ratio(lambda turn: CONTINUOUS(row_under_task(turn)), 0.0, math.pi / 2.0) < 0.6

    def bare(turn: float) -> Array:
        situation = row_under_task(turn)
        return np.asarray(np.linalg.pinv(np.vstack([situation.row, task(situation)]))[:, 0], np.float64)

    assert np.abs(bare(math.pi / 2.0 - 1e-3)).max() > 100.0 * np.abs(bare(math.pi / 2.0)).max()


# ---- set-based task ---------------------------------------------------------------------------------------------------------------


@given(SEEDS, st.floats(-0.1, 0.3))
def test_the_tangent_cone_decides(seed: int, distance: float) -> None:
    """Inside the set, or where the task does not lead out of it: q̇_n to the bit. Else the null space of J_d, and a frozen distance."""
    situation = regular_situation(seed)._replace(distance=distance)
    velocities = FROZEN(situation)
    if distance > 0.15 or situation.pull <= 0.0:
        assert_array_equal(velocities, situation.nominal)
        return
    assert_allclose(velocities, null_space_projector(situation.row[None, :]) @ situation.nominal, atol=1e-9)
    assert float(situation.row @ velocities) == pytest.approx(0.0, abs=1e-12)
    # Returning at k_r (d_m − d) is strict priority with that speed, unless the task itself is faster.
    returning = StrictPriority(0.15, 5.0 * (0.15 - distance), switched=True)
    assert_allclose(RETURNING(situation), returning(situation), atol=1e-12)


def test_a_set_based_task_jumps_and_says_so() -> None:
    """At d_m the rate jumps from −u to 0, on any grid; against an obstacle that comes at w it rests at d_m − w / k_r, frozen nowhere."""
    situation = regular_situation(5)
    situation = situation._replace(nominal=situation.nominal * math.copysign(1.0, situation.pull))
    assert jump_ratio(lambda d: FROZEN(situation._replace(distance=d)), 0.05, 0.5) == pytest.approx(1.0)
    below, above = (FROZEN(situation._replace(distance=d)) for d in (0.15, 0.15 + 1e-12))
    assert float(situation.row @ (below - above)) == pytest.approx(situation.pull)
    assert SetBasedTask.__doc__ is not None and "discontinuous by design" in SetBasedTask.__doc__

    def after(law: SetBasedTask, seconds: float) -> float:
        d, w = 0.2, 0.1
        for _ in range(round(seconds / 0.002)):
            d += 0.002 * (law.line_rate(d, 0.2, w, 0.2) - w)
        return d

    assert after(RETURNING, 10.0) == pytest.approx(0.15 - 0.1 / 5.0, abs=1e-3)
    assert after(FROZEN, 3.0) < 0.0
    assert after(SetBasedTask(0.15, 0.0, feed_forward=True), 10.0) == pytest.approx(0.15, abs=1e-3)
