"""Properties of every law: finite, reproducible, no effect without obstacles, the rate of `line_rate`."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from controllers.kinematics import Array
from controllers.laws.barrier_qp import BarrierQP
from controllers.laws.continuous_inverse import ContinuousInverse
from controllers.laws.hand_lever import HandLever
from controllers.laws.hierarchical_inverse import HierarchicalInverse
from controllers.laws.intermediate_value import IntermediateValue
from controllers.laws.lexicographic_qp import POSTURE_WEIGHT, LexicographicQP
from controllers.laws.null_space_avoidance import NullSpaceAvoidance
from controllers.laws.potential_field import PotentialField
from controllers.laws.set_based_task import SetBasedTask
from controllers.laws.situation import AUTHORITY, Law, Situation
from controllers.laws.smooth_priority import SmoothPriority
from controllers.laws.strict_priority import StrictPriority
from controllers.laws.task_activation import TaskActivation
from controllers.laws.task_space import free_part, mostly_free_part
from controllers.laws.unprotected import Unprotected

LAWS: dict[str, Law] = {
    "smooth": SmoothPriority(0.15, 6.0, 0.30),
    "smooth_fed": SmoothPriority(0.15, 2.0, 0.30, feed_forward=True, one_sided=True),
    "strict_always": StrictPriority(0.30),
    "strict_switched": StrictPriority(0.30, 0.15),
    "null_space": NullSpaceAvoidance(0.15, 0.30, 0.30),
    "potential": PotentialField(0.30, 0.005),
    "barrier": BarrierQP(0.15, 5.0),
    "barrier_fed": BarrierQP(0.15, 5.0, feed_forward=True),
    "intermediate": IntermediateValue(0.15, 6.0, 0.30),
    "activation": TaskActivation(0.15, 0.30, 0.30),
    "continuous": ContinuousInverse(0.15, 6.0, 0.30),
    "hierarchical": HierarchicalInverse(0.15, 6.0, 0.30),
    "lexicographic": LexicographicQP(0.15, 5.0),
    "lexicographic_fed": LexicographicQP(0.15, 5.0, feed_forward=True),
    "set_based": SetBasedTask(0.15, 5.0),
    "set_based_fed": SetBasedTask(0.15, 0.0, feed_forward=True),
    "lever": HandLever(0.4, 0.30),
    "unprotected": Unprotected(),
}
JUMPING = {"strict_switched", "set_based", "set_based_fed"}
ANY_LAW = st.sampled_from(sorted(LAWS))
SEEDS = st.integers(0, 100_000)
SIZES = st.sampled_from([6, 7, 14])
DISTANCES = st.floats(-0.2, 1.0)


def regular_situation(seed: int, n: int = 7, m: int = 3) -> Situation:
    """A random situation of one pair with a regular row, also in the null space of the task."""
    rng = np.random.default_rng(seed)
    while True:
        row, J = rng.uniform(-0.6, 0.6, n), rng.uniform(-1.0, 1.0, (m, n))
        if float(np.linalg.norm(free_part(row, J))) > 1.01 * AUTHORITY and np.linalg.svd(J)[1][-1] > 0.05:
            q, nominal = rng.uniform(-2.0, 2.0, n), rng.uniform(-1.5, 1.5, n)
            return Situation(q, nominal, row, float(rng.uniform(-0.1, 0.6)), float(rng.uniform(-0.5, 0.5)), J)


def with_pairs(situation: Situation, seed: int, pairs: int = 12) -> Situation:
    """The situation with bounds and more pairs; the first pair is its own."""
    rng = np.random.default_rng(seed)
    n = len(situation.row)
    rows = rng.uniform(-0.5, 0.5, (pairs, n))
    rows[0] = situation.row
    distances = situation.distance + rng.uniform(0.0, 0.5, pairs)
    distances[0] = situation.distance
    bounds = rng.uniform(1.5, 2.5, (2, n))
    return situation._replace(
        rows=rows,
        distances=distances,
        approaches=rng.uniform(-0.3, 0.3, pairs),
        lower=-bounds[0],
        upper=bounds[1],
    )


def jump_ratio(velocities: Callable[[float], Array], low: float, high: float, steps: int = 1500) -> float:
    """Largest step of q̇(x) on a grid twice as fine relative to the coarse one: .5 if smooth, 1 at a jump."""
    largest = []
    for count in (steps, 2 * steps):
        path = np.array([velocities(float(x)) for x in np.linspace(low, high, count + 1)])
        largest.append(float(np.abs(np.diff(path, axis=0)).max()))
    return largest[1] / largest[0]


@given(
    ANY_LAW,
    SEEDS,
    SIZES,
    st.floats(0.0, 1.5),
    st.one_of(DISTANCES, st.just(math.inf), st.just(0.0)),
    st.integers(0, 12),
)
@example("barrier_fed", 0, 7, 0.0, -0.2, 6)
@example("intermediate", 0, 14, 1e-12, 0.0, 12)
def test_velocities_are_finite_for_any_situation(
    name: str, seed: int, n: int, length: float, distance: float, m: int
) -> None:
    """Rows of any length, overlap, d = 0, d = ∞, and tasks of any rank: m = 0, singular, more than n."""
    rng = np.random.default_rng(seed)
    situation = with_pairs(regular_situation(seed, n), seed)
    assert situation.rows is not None and situation.distances is not None
    row = situation.row * (length / float(np.linalg.norm(situation.row)))
    rows, distances = situation.rows.copy(), situation.distances.copy()
    rows[0], rows[1], rows[2], rows[3] = row, 0.0, -rows[4], rows[5]
    distances[:5], distances[6] = distance, math.inf
    # Rank 2 at most: a singular task for m > 2.
    J = rng.normal(size=(m, 2)) @ rng.normal(size=(2, n)) if m else None
    hard = situation._replace(row=row, distance=distance, rows=rows, distances=distances, task_jacobian=J)
    for case in (hard, hard._replace(task_jacobian=np.zeros((3, n))), hard._replace(lower=None, upper=None)):
        velocities = LAWS[name](case)
        assert velocities.shape == (n,) and np.isfinite(velocities).all()
        # Bounded: |J_d^#| ≤ 11 rad/m of the damped row; motion around the task is at most a few times that.
        assert np.abs(velocities).max() < 100.0 * max(1.0, abs(getattr(LAWS[name], "push", float)(distance)))


@given(ANY_LAW, SEEDS, SIZES)
def test_without_obstacles_the_task_passes_unchanged(name: str, seed: int, n: int) -> None:
    """d = ∞ and rows of zeros: λ = 0, q̇ = q̇_n to the bit, and `line_rate` is −u."""
    law, zeros = LAWS[name], np.zeros((12, n))
    situation = with_pairs(regular_situation(seed, n), seed)
    alone = situation._replace(
        row=zeros[0], distance=math.inf, approach=0.0, rows=zeros, distances=np.full(12, math.inf)
    )
    assert law.activation(math.inf) == 0.0 and law.line_rate(math.inf, 0.2, 0.0, 0.0) == -0.2
    assert_array_equal(law(alone), alone.nominal)
    none = alone._replace(rows=zeros[:0], distances=np.zeros(0), approaches=np.zeros(0))
    assert_array_equal(law(none), alone.nominal)


@given(ANY_LAW, SEEDS, SIZES)
def test_the_line_is_the_distance_rate(name: str, seed: int, n: int) -> None:
    """J_d q̇ of one pair, with a regular row and redundancy; plots may use `line_rate` for the arm."""
    situation = regular_situation(seed, n)
    rate = LAWS[name].line_rate(
        situation.distance, situation.pull, situation.approach, float(situation.row @ situation.row)
    )
    if name == "activation":
        # At partial activation the hand changes the rate; `line_rate` assumes a hand that is not affected.
        assert situation.task_jacobian is not None
        unfelt = free_part(situation.task_jacobian[0], situation.row[None, :])
        situation = situation._replace(task_jacobian=unfelt[None, :])
    assert float(situation.row @ LAWS[name](situation)) == pytest.approx(rate, abs=2e-6)


@given(ANY_LAW, DISTANCES, st.floats(0.0, 0.5), st.floats(-0.29, 1.0), st.floats(-0.5, 0.5))
def test_lambda_and_rate_never_grow_with_the_distance(
    name: str, distance: float, farther: float, pull: float, approach: float
) -> None:
    """λ is in [0, 1]; the rate is monotonic as long as the task does not retreat faster than v."""
    law = LAWS[name]
    assert 0.0 <= law.activation(distance + farther) <= law.activation(distance) <= 1.0
    near, far = (law.line_rate(d, pull, approach, 0.2) for d in (distance, distance + farther))
    # With w fed forward, a retreating obstacle (w < 0) reduces v: v + w + u may be negative.
    if "fed" not in name or approach >= 0.0:
        assert far <= near + 1e-12


@pytest.mark.parametrize("name", sorted(set(LAWS) - JUMPING - {"strict_always", "lever", "unprotected"}))
def test_smooth_in_the_distance(name: str) -> None:
    situation = regular_situation(5)
    situation = situation._replace(nominal=situation.nominal * math.copysign(1.0, situation.pull))
    assert 0.4 < jump_ratio(lambda d: LAWS[name](situation._replace(distance=d)), 0.05, 0.5) < 0.6


def rest(law: Law, pull: float, square: float) -> float:
    """Distance after 60 s in steps of 2 ms, from 1 m, under ḋ = line_rate(d, u)."""
    d = 1.0
    for _ in range(30_000):
        d += 0.002 * law.line_rate(d, pull, 0.0, square)
    return d


def test_resting_distances() -> None:
    """Under a constant pull of .2 m/s each law rests at its closed form, or never."""
    u, v, square = 0.2, 0.3, 0.2
    share = u / (u + v)
    assert rest(LAWS["smooth"], u, square) == pytest.approx(0.15 * (1.0 / share) ** (1.0 / 6.0), abs=1e-6)
    assert rest(LAWS["intermediate"], u, square) == pytest.approx(
        0.15 * (1.0 / share) ** (1.0 / 6.0), abs=1e-6
    )
    assert rest(LAWS["null_space"], u, square) == pytest.approx(
        0.15 + 0.15 / math.pi * math.acos(2.0 * share - 1.0), abs=1e-6
    )
    assert rest(LAWS["continuous"], u, square) == pytest.approx(0.15 * (1.0 / share) ** (1.0 / 6.0), abs=1e-6)
    buffered = 0.15 + 0.15 / math.pi * math.acos(2.0 * math.sqrt(share) - 1.0)
    assert rest(LAWS["activation"], u, square) == pytest.approx(buffered, abs=1e-6)
    assert abs(rest(LAWS["set_based"], u, square) - 0.15) < 0.002
    assert rest(LAWS["hierarchical"], u, square) == pytest.approx(
        0.15 * (1.0 / share) ** (1.0 / 6.0), abs=1e-6
    )
    assert rest(LAWS["lexicographic"], u, square) == pytest.approx(0.15, abs=1e-6)
    assert rest(LAWS["barrier"], u, square) == pytest.approx(0.15, abs=1e-6)
    field = PotentialField(0.30, 0.005)
    assert square * field.push(rest(field, u, square)) == pytest.approx(u, abs=1e-6)
    assert rest(field, 2.0 * u, square) < rest(field, u, square) < 0.15
    assert abs(rest(LAWS["strict_switched"], u, square) - 0.15) < 0.002
    assert rest(LAWS["strict_always"], u, square) == pytest.approx(1.0 + 60.0 * v)
    assert rest(LAWS["unprotected"], u, square) == pytest.approx(1.0 - 60.0 * u)


def lever_of(law: Law, situation: Situation) -> Array:
    """Joint direction along which a law moves one arm."""
    row, J = situation.row, situation.task_jacobian
    if J is None or not law.wants_task:
        return row
    return (
        mostly_free_part(row, J, POSTURE_WEIGHT**2) if isinstance(law, LexicographicQP) else free_part(row, J)
    )


@given(ANY_LAW, SEEDS)
def test_with_coupling_both_arms_avoid(name: str, seed: int) -> None:
    law = LAWS[name]
    one, other = regular_situation(seed), regular_situation(seed + 1)
    row, nominal = np.concatenate([one.row, other.row]), np.concatenate([one.nominal, other.nominal])
    J = np.zeros((6, 14))
    J[:3, :7], J[3:, 7:] = one.task_jacobian, other.task_jacobian
    both = Situation(np.zeros(14), nominal, row, 0.1, 0.0, J)
    if both.pull < 0.0:
        both = both._replace(nominal=-nominal)
    change = law(both) - both.nominal
    rate = law.line_rate(0.1, both.pull, 0.0, float(row @ row))
    gained = float(row @ change)
    assert gained == pytest.approx(rate + both.pull, abs=2e-6)
    if name == "unprotected":
        assert gained == 0.0
        return
    # Each arm's share of the rate is proportional to |J_d|², or |J_d N|² where the hand has priority.
    squares = [float(s.row @ lever_of(law, s)) for s in (one, other)]
    for arm, square in ((slice(0, 7), squares[0]), (slice(7, 14), squares[1])):
        assert float(row[arm] @ change[arm]) == pytest.approx(gained * square / sum(squares), abs=1e-5)


def test_laws_read_only_the_declared_inputs() -> None:
    # Without pairs or task, the laws that do not declare them give the same bits.
    situation = with_pairs(regular_situation(7)._replace(distance=0.1), 7)
    assert {name for name, law in LAWS.items() if law.wants_all_pairs} == {
        "barrier",
        "barrier_fed",
        "lexicographic",
        "lexicographic_fed",
    }
    hand = {
        "null_space",
        "intermediate",
        "activation",
        "continuous",
        "hierarchical",
        "lexicographic",
        "lexicographic_fed",
    }
    assert {name for name, law in LAWS.items() if law.wants_task} == hand
    for name, law in LAWS.items():
        blind = situation
        if not law.wants_all_pairs:
            blind = blind._replace(rows=None, distances=None, approaches=None)
        if not law.wants_task:
            blind = blind._replace(task_jacobian=None)
        assert_array_equal(law(blind), law(situation), err_msg=name)
    # Positive control: declared inputs change the result, here a second pair in contact.
    assert situation.distances is not None
    situation.distances[1] = 0.0
    for name, unseen in (("barrier", {"rows": None}), ("null_space", {"task_jacobian": None})):
        assert not np.array_equal(LAWS[name](situation._replace(**unseen)), LAWS[name](situation))


@given(ANY_LAW, SEEDS, SIZES)
def test_laws_have_no_state_and_change_no_input(name: str, seed: int, n: int) -> None:
    law = LAWS[name]
    situation = with_pairs(regular_situation(seed, n), seed)
    arrays = [value for value in situation if isinstance(value, np.ndarray)]
    copies = [array.copy() for array in arrays]
    for array in arrays:
        array.flags.writeable = False
    first = law(situation).copy()
    law(with_pairs(regular_situation(seed + 1, n), seed + 1))
    assert_array_equal(law(situation), first)
    for array, copy in zip(arrays, copies, strict=True):
        assert_array_equal(array, copy)
