"""The laws that know the hand's task: null-space avoidance keeps it whatever comes, intermediate values as long as they can."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from controllers.kinematics import Array, null_space_projector
from controllers.laws.intermediate_value import TASK_DAMPING, IntermediateValue
from controllers.laws.null_space_avoidance import NullSpaceAvoidance
from controllers.laws.situation import AUTHORITY, Situation, row_damping
from controllers.laws.smooth_priority import SmoothPriority
from controllers.laws.task_space import free_part, mostly_free_part
from tests.controllers.test_laws_all import SEEDS, jump_ratio, regular_situation

DIMENSIONS = st.sampled_from([1, 3, 6])
HAND_FIRST = NullSpaceAvoidance(0.15, 0.30, 0.30)
PAPER = SmoothPriority(0.15, 6.0, 0.30)
INTERMEDIATE = IntermediateValue(0.15, 6.0, 0.30)


def near_situation(seed: int, m: int) -> Situation:
    """Return a random situation near an obstacle, with a regular task and a row of any freedom in its null space."""
    rng = np.random.default_rng(seed)
    while True:
        J = rng.uniform(-1.0, 1.0, (m, 7))
        if np.linalg.svd(J)[1][-1] > 0.05:
            break
    row = rng.uniform(-0.5, 0.5, 7)
    # Often mostly, sometimes wholly in the row space of J: there the hand feels everything that the obstacle feels.
    row -= free_part(row, J) * float(rng.choice([0.0, 0.9, 1.0]))
    return Situation(np.zeros(7), rng.uniform(-1.5, 1.5, 7), row, float(rng.uniform(-0.1, 0.25)), 0.0, J)


def task(situation: Situation) -> Array:
    assert situation.task_jacobian is not None
    return situation.task_jacobian


def row_under_task(turn: float) -> Situation:
    """A row that turns from the task's null space (0) into its row space (π/2)."""
    rng = np.random.default_rng(11)
    J = rng.uniform(-1.0, 1.0, (3, 7))
    free, felt = free_part(rng.uniform(-1.0, 1.0, 7), J), J[0]
    row = 0.4 * (np.cos(turn) * free / np.linalg.norm(free) + np.sin(turn) * felt / np.linalg.norm(felt))
    return Situation(np.zeros(7), rng.uniform(-1.0, 1.0, 7), row, 0.1, 0.0, J)


@given(SEEDS, DIMENSIONS, st.floats(1e-3, 1.0))
def test_free_parts_of_a_row(seed: int, m: int, damping: float) -> None:
    """J_d N with N of eq. (6) built as a matrix, J (J_d N)ᵀ = 0; mostly free: (JᵀJ + μ² I) r = μ² J_dᵀ."""
    situation = near_situation(seed, m)
    J, square = task(situation), damping * damping
    free = free_part(situation.row, J)
    assert_allclose(free, null_space_projector(J) @ situation.row, atol=1e-9)
    assert_allclose(J @ free, 0.0, atol=1e-12)
    way = mostly_free_part(situation.row, J, square)
    assert_allclose((J.T @ J + square * np.eye(7)) @ way, square * situation.row, atol=1e-9)


def test_special_tasks() -> None:
    # Two equal rows in J: J Jᵀ is singular, and the free part is that of the row alone.
    rng = np.random.default_rng(2)
    once, row = rng.uniform(-1.0, 1.0, (2, 7)), rng.uniform(-1.0, 1.0, 7)
    assert_allclose(free_part(row, np.vstack([once, once[:1]])), free_part(row, once), atol=1e-9)
    # The paper's law changes the hand's velocity by decimetres a second, so that the formula's test is not empty.
    situation = regular_situation(4)._replace(distance=0.1)
    assert np.linalg.norm(task(situation) @ (PAPER(situation) - situation.nominal)) > 0.1
    assert np.linalg.norm(HAND_FIRST(situation) - situation.nominal) > 0.1
    # J = I, given or by default: N = 0, and the arm does not avoid at all.
    assert_array_equal(HAND_FIRST(situation._replace(task_jacobian=None)), situation.nominal)
    assert_allclose(HAND_FIRST(situation._replace(task_jacobian=np.eye(7))), situation.nominal, atol=1e-12)


@given(SEEDS, DIMENSIONS)
def test_formulas_of_the_laws_that_know_the_task(seed: int, m: int) -> None:
    # q̇ = q̇_n + N (J_d N)^# α (v + u) with numpy's matrices, where J_d N is regular; the distance rate is α v − (1 − α) u.
    situation = regular_situation(seed, 7, m)
    N = null_space_projector(task(situation))
    alpha, u = HAND_FIRST.activation(situation.distance), situation.pull
    expected = situation.nominal + N @ np.linalg.pinv(situation.row[None, :] @ N)[:, 0] * (alpha * (0.30 + u))
    velocities = HAND_FIRST(situation)
    assert_allclose(velocities, expected, atol=1e-9)
    assert float(situation.row @ velocities) == pytest.approx(alpha * 0.30 - (1.0 - alpha) * u, abs=1e-9)
    # q̇ = J_a^# ẋ_aⁱ + (J_b N_a)^# (ẋ_b − J_b J_a^# ẋ_aⁱ) with numpy's matrices, for q̇_n = J_b^# ẋ_b, where all is regular.
    situation = regular_situation(seed, 7, m)
    J_b, J_a = task(situation), situation.row[None, :]
    x_b = J_b @ situation.nominal
    situation = situation._replace(nominal=np.linalg.pinv(J_b) @ x_b)
    lam = INTERMEDIATE.activation(situation.distance)
    first = np.linalg.pinv(J_a)[:, 0] * (lam * 0.30 - (1.0 - lam) * situation.pull)
    expected = first + np.linalg.pinv(J_b @ null_space_projector(J_a)) @ (x_b - J_b @ first)
    assert_allclose(INTERMEDIATE(situation), expected, atol=1e-8)


@given(SEEDS, DIMENSIONS, st.floats(0.0, 1.0))
def test_the_hand_keeps_its_velocity_with_little_motion(seed: int, m: int, room: float) -> None:
    """J q̇ = J q̇_n whatever the obstacle does, |Δ| ≤ 11 c however short J_d N is; a box shortens Δ as far as it must."""
    situation = near_situation(seed, m)
    nominal, change = situation.nominal, HAND_FIRST(situation) - situation.nominal
    assert np.linalg.norm(change) <= 11.0 * abs(HAND_FIRST.correction(situation.distance, situation.pull, 0.0)) + 1e-12
    bounded = HAND_FIRST(situation._replace(lower=nominal - room, upper=nominal + room)) - nominal
    assert np.abs(bounded).max() <= room + 1e-12
    reach = float(np.abs(change).max())
    assert_allclose(bounded, min(1.0, room / reach if reach > 0.0 else 1.0) * change, atol=1e-9)
    for motion in (change, bounded):
        assert_allclose(task(situation) @ motion, 0.0, atol=1e-9)


def test_activation_of_null_space_avoidance() -> None:
    # d_i ≤ d_m: 1 up to d_m, 0 beyond, nothing divided by zero.
    for influence in (0.15, 0.10):
        law = NullSpaceAvoidance(0.15, influence, 0.3)
        assert [law.activation(d) for d in (0.1, 0.15, 0.15 + 1e-9, 0.4)] == [1.0, 1.0, 0.0, 0.0]
    # α = 1, ½ and 0 at d_m, half way and d_i, with slope 0 at either end.
    assert [HAND_FIRST.activation(d) for d in (0.15, 0.225, 0.30)] == pytest.approx([1.0, 0.5, 0.0])
    for end in (0.15, 0.30):
        assert abs(HAND_FIRST.activation(end + 1e-6) - HAND_FIRST.activation(end - 1e-6)) < 1e-9


@given(SEEDS, DIMENSIONS)
def test_the_papers_distance_rate_with_less_disturbance(seed: int, m: int) -> None:
    """J_d q̇ is the paper's law's, and the hand's velocity changes by no more than with it."""
    situation = near_situation(seed, m)
    assume(float(np.linalg.norm(situation.row)) > 1e-3)
    paper, ours = PAPER(situation) - situation.nominal, INTERMEDIATE(situation) - situation.nominal
    assert float(situation.row @ ours) == pytest.approx(float(situation.row @ paper), abs=1e-9)
    J = task(situation)
    assert np.linalg.norm(J @ ours) <= np.linalg.norm(J @ paper) + 1e-9


@pytest.mark.parametrize(("turn", "share"), [(0.0, 1e-9), (0.5, 1e-9), (1.2, 1e-9), (1.4, 0.5), (np.pi / 2.0, 1.0)])
def test_how_much_the_hand_gives_way(turn: float, share: float) -> None:
    """Not at all while |J_d N| > .12 m/rad (turn ≤ 1.26), then by degrees, still less than with the paper's law."""
    situation = row_under_task(turn)
    J = task(situation)
    paper = float(np.linalg.norm(J @ (PAPER(situation) - situation.nominal)))
    ours = float(np.linalg.norm(J @ (INTERMEDIATE(situation) - situation.nominal)))
    assert ours <= share * paper + 1e-9
    # Without freedom the hand has to move.
    assert (ours > 1e-2) == (turn > 1.3)


def test_the_hand_gives_way_smoothly() -> None:
    for law in (HAND_FIRST, INTERMEDIATE):
        assert 0.4 < jump_ratio(lambda turn, law=law: law(row_under_task(turn)), 0.0, np.pi / 2.0) < 0.6


@given(SEEDS, DIMENSIONS)
def test_with_little_freedom_it_is_the_damped_optimum(seed: int, m: int) -> None:
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
def test_a_task_in_every_joint_makes_it_the_papers_law(seed: int) -> None:
    """J_b = I, given or by default: exactly the paper's law, for rows of any length."""
    situation = regular_situation(seed)
    for length in (1.0, 0.1, 1e-3, 0.0):
        short = situation._replace(row=situation.row * length, task_jacobian=None)
        assert_array_equal(INTERMEDIATE(short), PAPER(short))
        assert_allclose(INTERMEDIATE(short._replace(task_jacobian=np.eye(7))), PAPER(short), atol=1e-8)


@given(SEEDS, st.floats(0.0, 1.0))
def test_short_rows_give_the_papers_damped_rate(seed: int, length: float) -> None:
    """Below .12 m/rad the rate is what `along_row` reaches: c |J_d|² / (|J_d|² + μ²)."""
    situation = near_situation(seed, 3)
    row = situation.row * (length * AUTHORITY / max(float(np.linalg.norm(situation.row)), 1e-6))
    short, square = situation._replace(row=row), float(row @ row)
    assume(square > 1e-8)
    c = INTERMEDIATE.correction(short.distance, short.pull, 0.0)
    reached = float(row @ (INTERMEDIATE(short) - short.nominal))
    assert reached == pytest.approx(c * square / (square + row_damping(square)), abs=1e-9)
