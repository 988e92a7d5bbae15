"""Laws that use the hand's task, and laws that activate avoidance, against the formulas of their papers."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from controllers.kinematics import Array, null_space_projector
from controllers.laws.barrier_qp import BarrierQP
from controllers.laws.continuous_inverse import ContinuousInverse
from controllers.laws.hierarchical_inverse import HierarchicalInverse
from controllers.laws.intermediate_value import TASK_DAMPING, IntermediateValue
from controllers.laws.lexicographic_qp import POSTURE_WEIGHT, LexicographicQP
from controllers.laws.null_space_avoidance import NullSpaceAvoidance
from controllers.laws.set_based_task import SetBasedTask
from controllers.laws.situation import AUTHORITY, Situation, row_damping
from controllers.laws.smooth_priority import SmoothPriority
from controllers.laws.strict_priority import StrictPriority
from controllers.laws.task_activation import DIRECTION_WEIGHT, TaskActivation
from controllers.laws.task_space import free_part, mostly_free_part
from tests.controllers.test_laws_all import SEEDS, SIZES, jump_ratio, regular_situation, with_pairs

DIMENSIONS = st.sampled_from([1, 3, 6])
HAND_FIRST = NullSpaceAvoidance(0.15, 0.30, 0.30)
PAPER = SmoothPriority(0.15, 6.0, 0.30)
INTERMEDIATE = IntermediateValue(0.15, 6.0, 0.30)


def near_situation(seed: int, m: int) -> Situation:
    """A random situation near an obstacle, with a regular task and any share of the row in its null space."""
    rng = np.random.default_rng(seed)
    while True:
        J = rng.uniform(-1.0, 1.0, (m, 7))
        if np.linalg.svd(J)[1][-1] > 0.05:
            break
    row = rng.uniform(-0.5, 0.5, 7)
    # Often mostly, sometimes completely in the row space of J: there avoidance always moves the hand.
    row -= free_part(row, J) * float(rng.choice([0.0, 0.9, 1.0]))
    return Situation(np.zeros(7), rng.uniform(-1.5, 1.5, 7), row, float(rng.uniform(-0.1, 0.25)), 0.0, J)


def task(situation: Situation) -> Array:
    assert situation.task_jacobian is not None
    return situation.task_jacobian


def row_under_task(turn: float) -> Situation:
    """Situation with a row turned from the task's null space (0) into its row space (π/2)."""
    rng = np.random.default_rng(11)
    J = rng.uniform(-1.0, 1.0, (3, 7))
    free, felt = free_part(rng.uniform(-1.0, 1.0, 7), J), J[0]
    row = 0.4 * (np.cos(turn) * free / np.linalg.norm(free) + np.sin(turn) * felt / np.linalg.norm(felt))
    return Situation(np.zeros(7), rng.uniform(-1.0, 1.0, 7), row, 0.1, 0.0, J)


@given(SEEDS, DIMENSIONS, st.floats(1e-3, 1.0))
def test_free_parts_of_a_row(seed: int, m: int, damping: float) -> None:
    """J_d N with N of eq. (6) as a matrix, J (J_d N)ᵀ = 0; mostly free: (JᵀJ + μ² I) r = μ² J_dᵀ."""
    situation = near_situation(seed, m)
    J, square = task(situation), damping * damping
    free = free_part(situation.row, J)
    assert_allclose(free, null_space_projector(J) @ situation.row, atol=1e-9)
    assert_allclose(J @ free, 0.0, atol=1e-12)
    way = mostly_free_part(situation.row, J, square)
    assert_allclose((J.T @ J + square * np.eye(7)) @ way, square * situation.row, atol=1e-9)


def test_special_tasks() -> None:
    # Two equal rows in J: J Jᵀ is singular, and the free part is that of a single row.
    rng = np.random.default_rng(2)
    once, row = rng.uniform(-1.0, 1.0, (2, 7)), rng.uniform(-1.0, 1.0, 7)
    assert_allclose(free_part(row, np.vstack([once, once[:1]])), free_part(row, once), atol=1e-9)
    # The paper's law changes the hand's velocity by over .1 m/s, so the formula's test is not trivial.
    situation = regular_situation(4)._replace(distance=0.1)
    assert np.linalg.norm(task(situation) @ (PAPER(situation) - situation.nominal)) > 0.1
    assert np.linalg.norm(HAND_FIRST(situation) - situation.nominal) > 0.1
    # J = I, given or by default: N = 0, and the arm does not avoid.
    assert_array_equal(HAND_FIRST(situation._replace(task_jacobian=None)), situation.nominal)
    assert_allclose(HAND_FIRST(situation._replace(task_jacobian=np.eye(7))), situation.nominal, atol=1e-12)


@given(SEEDS, DIMENSIONS)
def test_formulas_of_the_laws_that_know_the_task(seed: int, m: int) -> None:
    # q̇ = q̇_n + N (J_d N)^# α (v + u) with numpy and a regular J_d N; the rate is α v − (1 − α) u.
    situation = regular_situation(seed, 7, m)
    N = null_space_projector(task(situation))
    alpha, u = HAND_FIRST.activation(situation.distance), situation.pull
    expected = situation.nominal + N @ np.linalg.pinv(situation.row[None, :] @ N)[:, 0] * (alpha * (0.30 + u))
    velocities = HAND_FIRST(situation)
    assert_allclose(velocities, expected, atol=1e-9)
    assert float(situation.row @ velocities) == pytest.approx(alpha * 0.30 - (1.0 - alpha) * u, abs=1e-9)
    # q̇ = J_a^# ẋ_aⁱ + (J_b N_a)^# (ẋ_b − J_b J_a^# ẋ_aⁱ) with numpy, for q̇_n = J_b^# ẋ_b, all regular.
    situation = regular_situation(seed, 7, m)
    J_b, J_a = task(situation), situation.row[None, :]
    x_b = J_b @ situation.nominal
    situation = situation._replace(nominal=np.linalg.pinv(J_b) @ x_b)
    lam = INTERMEDIATE.activation(situation.distance)
    first = np.linalg.pinv(J_a)[:, 0] * (lam * 0.30 - (1.0 - lam) * situation.pull)
    expected = first + np.linalg.pinv(J_b @ null_space_projector(J_a)) @ (x_b - J_b @ first)
    assert_allclose(INTERMEDIATE(situation), expected, atol=1e-8)


@given(SEEDS, DIMENSIONS, st.floats(0.0, 1.0))
def test_the_hand_keeps_its_velocity_and_the_correction_is_bounded(seed: int, m: int, room: float) -> None:
    """J q̇ = J q̇_n always, |Δ| ≤ 11 c however short J_d N is; a box shortens Δ only as far as needed."""
    situation = near_situation(seed, m)
    nominal, change = situation.nominal, HAND_FIRST(situation) - situation.nominal
    assert (
        np.linalg.norm(change)
        <= 11.0 * abs(HAND_FIRST.correction(situation.distance, situation.pull, 0.0)) + 1e-12
    )
    bounded = HAND_FIRST(situation._replace(lower=nominal - room, upper=nominal + room)) - nominal
    assert np.abs(bounded).max() <= room + 1e-12
    reach = float(np.abs(change).max())
    assert_allclose(bounded, min(1.0, room / reach if reach > 0.0 else 1.0) * change, atol=1e-9)
    for motion in (change, bounded):
        assert_allclose(task(situation) @ motion, 0.0, atol=1e-9)


def test_activation_of_null_space_avoidance() -> None:
    # d_i ≤ d_m: 1 up to d_m, 0 beyond, no division by zero.
    for influence in (0.15, 0.10):
        law = NullSpaceAvoidance(0.15, influence, 0.3)
        assert [law.activation(d) for d in (0.1, 0.15, 0.15 + 1e-9, 0.4)] == [1.0, 1.0, 0.0, 0.0]
    # α = 1, ½ and 0 at d_m, midway and d_i, with slope 0 at both ends.
    assert [HAND_FIRST.activation(d) for d in (0.15, 0.225, 0.30)] == pytest.approx([1.0, 0.5, 0.0])
    for end in (0.15, 0.30):
        assert abs(HAND_FIRST.activation(end + 1e-6) - HAND_FIRST.activation(end - 1e-6)) < 1e-9


@given(SEEDS, DIMENSIONS)
def test_the_papers_distance_rate_with_less_disturbance(seed: int, m: int) -> None:
    """Same J_d q̇ as the paper's law, and the hand's velocity changes no more."""
    situation = near_situation(seed, m)
    assume(float(np.linalg.norm(situation.row)) > 1e-3)
    paper, ours = PAPER(situation) - situation.nominal, INTERMEDIATE(situation) - situation.nominal
    assert float(situation.row @ ours) == pytest.approx(float(situation.row @ paper), abs=1e-9)
    J = task(situation)
    assert np.linalg.norm(J @ ours) <= np.linalg.norm(J @ paper) + 1e-9


@pytest.mark.parametrize(
    ("turn", "share"), [(0.0, 1e-9), (0.5, 1e-9), (1.2, 1e-9), (1.4, 0.5), (np.pi / 2.0, 1.0)]
)
def test_the_hand_moves_only_without_freedom(turn: float, share: float) -> None:
    """No motion while |J_d N| > .12 m/rad (turn ≤ 1.26), then gradually more, below the paper's law."""
    situation = row_under_task(turn)
    J = task(situation)
    paper = float(np.linalg.norm(J @ (PAPER(situation) - situation.nominal)))
    ours = float(np.linalg.norm(J @ (INTERMEDIATE(situation) - situation.nominal)))
    assert ours <= share * paper + 1e-9
    # Without freedom the hand has to move.
    assert (ours > 1e-2) == (turn > 1.3)


def test_the_hand_s_motion_is_continuous() -> None:
    for law in (HAND_FIRST, INTERMEDIATE):
        assert 0.4 < jump_ratio(lambda turn, law=law: law(row_under_task(turn)), 0.0, np.pi / 2.0) < 0.6


@given(SEEDS, DIMENSIONS)
def test_with_little_freedom_the_intermediate_law_is_the_damped_optimum(seed: int, m: int) -> None:
    """(JᵀJ + μ² I) Δ is parallel to J_dᵀ: no other Δ with this rate has a smaller |J Δ|² + μ² |Δ|²."""
    situation = near_situation(seed, m)
    J, row = task(situation), situation.row
    freedom = float(np.linalg.norm(free_part(row, J)) / AUTHORITY) ** 2
    assume(freedom < 0.95 and float(np.linalg.norm(row)) > 1e-2)
    change = INTERMEDIATE(situation) - situation.nominal
    gradient = J.T @ (J @ change) + (TASK_DAMPING * (1.0 - freedom)) ** 2 * change
    along = row * float(row @ gradient) / float(row @ row)
    assert_allclose(gradient, along, atol=1e-9)


@given(SEEDS)
def test_with_a_task_in_every_joint_it_equals_the_papers_law(seed: int) -> None:
    """J_b = I, given or by default, for rows of any length."""
    situation = regular_situation(seed)
    for length in (1.0, 0.1, 1e-3, 0.0):
        short = situation._replace(row=situation.row * length, task_jacobian=None)
        assert_array_equal(INTERMEDIATE(short), PAPER(short))
        assert_allclose(INTERMEDIATE(short._replace(task_jacobian=np.eye(7))), PAPER(short), atol=1e-8)


@given(SEEDS, st.floats(0.0, 1.0))
def test_short_rows_give_the_papers_damped_rate(seed: int, length: float) -> None:
    """Below .12 m/rad the rate equals `along_row`'s: c |J_d|² / (|J_d|² + μ²)."""
    situation = near_situation(seed, 3)
    row = situation.row * (length * AUTHORITY / max(float(np.linalg.norm(situation.row)), 1e-6))
    short, square = situation._replace(row=row), float(row @ row)
    assume(square > 1e-8)
    c = INTERMEDIATE.correction(short.distance, short.pull, 0.0)
    reached = float(row @ (INTERMEDIATE(short) - short.nominal))
    assert reached == pytest.approx(c * square / (square + row_damping(square)), abs=1e-9)


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
    """The recursion over both levels, starting at q̇_n and I."""
    n = len(situation.row)
    J = np.eye(n) if situation.task_jacobian is None else situation.task_jacobian
    hand = (J, np.eye(len(J)), J @ situation.nominal, True)
    rho, Q = situation.nominal, np.eye(n)
    for jacobian, A, wanted, damped in (
        (situation.row[None, :], np.array([[a]]), np.array([v]), False),
        hand,
    ):
        X = jacobian @ Q
        inverse = regularised(X, A, np.eye(n), damped)
        W = X @ regularised(X, A, Q, damped)
        rho = rho + Q @ inverse @ W @ (wanted - jacobian @ rho)
        Q = Q @ (np.eye(n) - inverse @ X)
    return rho


@given(SEEDS, SIZES, st.one_of(DIMENSIONS, st.just(0)), BUFFER)
def test_task_activation_is_the_papers_recursion(seed: int, n: int, m: int, distance: float) -> None:
    """Both levels with n × n matrices; m = 0: a task in every joint."""
    situation = regular_situation(seed, n, min(max(m, 1), n - 1))._replace(distance=distance)
    if m == 0:
        situation = situation._replace(task_jacobian=None)
    assert_allclose(
        ACTIVATION(situation), levels(situation, ACTIVATION.row_activation(distance), 0.30), atol=1e-9
    )


@given(SEEDS, DIMENSIONS, BUFFER)
def test_at_partial_activation_the_rate_is_between_task_and_line(seed: int, m: int, distance: float) -> None:
    """For any task of the hand; with a = 1 the rate is v."""
    situation = near_situation(seed, m)._replace(distance=distance)
    if float(np.linalg.norm(situation.row)) < 0.12:
        return
    wanted = ACTIVATION.correction(distance, situation.pull, 0.0)
    gained = float(situation.row @ (ACTIVATION(situation) - situation.nominal))
    assert -1e-9 <= gained * math.copysign(1.0, wanted) <= abs(wanted) + 1e-9
    first = ACTIVATION(situation._replace(distance=0.15))
    assert float(situation.row @ first) == pytest.approx(0.30, abs=1e-9)


def test_activation_is_continuous_where_both_need_the_same_joint() -> None:
    """The row is in the hand's row space, a from 0 to 1. Without η, W = I: the hand keeps all until a = 1."""
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
def test_the_continuous_inverse_blends_the_inverses_of_both_sets(seed: int, m: int) -> None:
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
def test_without_redundancy_the_continuous_inverse_is_a_compromise(seed: int) -> None:
    """Task in every joint: the least squares of both, up to damping |J_d|² / (1 + |J_d|²) of the retreat."""
    situation = regular_situation(seed)._replace(distance=0.1, task_jacobian=None)
    row, c = situation.row, 0.30 + situation.pull
    # |J_d Δ − c|² + |Δ|² as one fit.
    fit = np.linalg.lstsq(np.vstack([row, np.eye(7)]), np.append(c, np.zeros(7)), rcond=None)[0]
    change = CONTINUOUS(situation) - situation.nominal
    assert_allclose(change, fit, atol=0.06**2 * abs(c))
    assert_allclose(
        CONTINUOUS(situation._replace(task_jacobian=np.eye(7))) - situation.nominal, change, atol=1e-9
    )
    # Neither has priority: less distance rate than the paper's law, more than hand-first, which gives none.
    assert 0.0 < abs(float(row @ change)) < abs(c)


def test_the_compromise_is_continuous() -> None:
    """As the row turns into the hand's row space, the stack loses a rank; q̇ does not jump, numpy's does."""
    assert 0.4 < jump_ratio(lambda turn: CONTINUOUS(row_under_task(turn)), 0.0, math.pi / 2.0) < 0.6

    def bare(turn: float) -> Array:
        situation = row_under_task(turn)
        return np.asarray(np.linalg.pinv(np.vstack([situation.row, task(situation)]))[:, 0], np.float64)

    assert np.abs(bare(math.pi / 2.0 - 1e-3)).max() > 100.0 * np.abs(bare(math.pi / 2.0)).max()


# ---- set-based task ---------------------------------------------------------------------------------------------------------------


@given(SEEDS, st.floats(-0.1, 0.3))
def test_the_tangent_cone_decides(seed: int, distance: float) -> None:
    """q̇_n to the bit inside the set, or if the task stays in it; otherwise the null space of J_d."""
    situation = regular_situation(seed)._replace(distance=distance)
    velocities = FROZEN(situation)
    if distance > 0.15 or situation.pull <= 0.0:
        assert_array_equal(velocities, situation.nominal)
        return
    assert_allclose(velocities, null_space_projector(situation.row[None, :]) @ situation.nominal, atol=1e-9)
    assert float(situation.row @ velocities) == pytest.approx(0.0, abs=1e-12)
    # With the return speed k_r (d_m − d) it is strict priority, unless the task itself is faster.
    returning = StrictPriority(5.0 * (0.15 - distance), 0.15)
    assert_allclose(RETURNING(situation), returning(situation), atol=1e-12)


def test_a_set_based_task_is_discontinuous_and_documented_so() -> None:
    """At d_m the rate jumps from −u to 0; with an obstacle of speed w it rests at d_m − w / k_r, or never."""
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


# ---- the inverse of a hierarchy ------------------------------------------------------------------------------------------------------


@given(SEEDS, DIMENSIONS)
def test_the_hierarchical_inverse_blends_both_solutions(seed: int, m: int) -> None:
    """(1 − λ) q̇_b + λ q̇_ab, for q̇_n = J^# ẋ_b; no change if the task retreats faster than v."""
    law, situation = HierarchicalInverse(0.15, 6.0, 0.30), regular_situation(seed, 7, m)
    J, row = task(situation), situation.row
    x_b = J @ situation.nominal
    alone = np.linalg.pinv(J) @ x_b
    situation = situation._replace(nominal=alone)
    first = row / float(row @ row) * 0.30
    N = null_space_projector(row[None, :])
    behind = first + np.linalg.pinv(J @ N) @ (x_b - J @ first)
    lam = law.activation(situation.distance) if situation.pull > -0.30 else 0.0
    assert_allclose(law(situation), (1.0 - lam) * alone + lam * behind, atol=1e-7)


# ---- one level after the other -------------------------------------------------------------------------------------------------------


@given(SEEDS, DIMENSIONS)
def test_the_lexicographic_qp_keeps_every_row_and_moves_the_hand_less(seed: int, m: int) -> None:
    flat, levels = BarrierQP(0.15, 5.0), LexicographicQP(0.15, 5.0)
    situation = with_pairs(regular_situation(seed, 7, m), seed)
    J, rows, nominal = task(situation), situation.rows, situation.nominal
    assert rows is not None and situation.distances is not None
    lower, upper = situation.lower, situation.upper
    assert lower is not None and upper is not None
    least = -5.0 * (situation.distances - 0.15)
    first, second = flat(situation), levels(situation)
    assert (rows @ second >= np.minimum(least, rows @ first) - 1e-5).all()
    assert (second >= lower).all() and (second <= upper).all()

    def cost(velocities: Array) -> float:
        change = velocities - nominal
        return float(np.sum((J @ change) ** 2) + POSTURE_WEIGHT**2 * change @ change)

    assert cost(second) <= cost(first) + 1e-6
    # Without the hand's task it equals the flat programme, to the bit.
    free = situation._replace(task_jacobian=None)
    assert_array_equal(levels(free), flat(free))


def test_with_redundancy_the_hand_hardly_moves() -> None:
    """One pair and a regular row in the hand's null space; the flat programme moves the hand."""
    situation = regular_situation(11)._replace(distance=0.05, approach=0.0)
    J = task(situation)
    moved = [
        float(np.linalg.norm(J @ (law(situation) - situation.nominal)))
        for law in (LexicographicQP(0.15, 5.0), BarrierQP(0.15, 5.0))
    ]
    assert moved[0] < 0.02 * moved[1] and moved[1] > 0.05
