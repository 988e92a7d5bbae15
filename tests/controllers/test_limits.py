"""Joint bounds: the box keeps the stops; the bounded row solves its quadratic programme or gives a reason."""

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import lsq_linear

from controllers.kinematics import Array
from controllers.laws.situation import AUTHORITY, ROW_DAMPING
from controllers.limits import Authority, VelocityBox, bounded_row

STOPS = np.radians([170.0, 120.0, 170.0, 120.0, 170.0, 120.0, 170.0])
TOP_SPEED = np.radians([100.0, 110.0, 100.0, 130.0, 130.0, 180.0, 180.0])


def lwr_box(positions: Array, gain: float = 10.0) -> VelocityBox:
    box = VelocityBox(-STOPS, STOPS, TOP_SPEED, gain)
    box.update(positions)
    return box


def shares(size: int = 7) -> st.SearchStrategy[Array]:
    return st.lists(st.floats(-1.0, 1.0), min_size=size, max_size=size).map(
        lambda numbers: np.array(numbers, float)
    )


ROWS = shares()
TINY = st.sampled_from([0.0, 1e-300, 1e-17, 1e-9, 1.2e-6, 1e-3, 0.02])


@st.composite
def boxed(draw: st.DrawFn) -> tuple[VelocityBox, Array, Array]:
    """A box, a task velocity inside it, and a row, all read-only."""
    box = lwr_box(draw(shares()) * STOPS)
    nominal, row = box.clip(draw(shares()) * TOP_SPEED), draw(ROWS).copy()
    # Some levers, often all, are tiny.
    row[draw(st.integers(0, 7)) :] *= draw(TINY)
    nominal.flags.writeable = row.flags.writeable = False
    return box, nominal, row


BOXED = boxed()


def nearest_by_least_squares(nominal: Array, row: Array, rate: float, box: VelocityBox) -> Array:
    """min |x − q̇_n|² s.t. J_d x = r, lower ≤ x ≤ upper, by a bounded fit with r as a very heavy row."""
    heavy = 1e7
    A, b = np.vstack([np.eye(7), heavy * row]), np.append(nominal, heavy * rate)
    # At a stop lower = upper, which the solver refuses.
    fit = lsq_linear(A, b, (box.lower - 1e-12, box.upper + 1e-12), method="bvls", tol=1e-14)
    return np.asarray(fit.x)


def reach(row: Array, box: VelocityBox) -> tuple[float, float]:
    """Smallest and largest distance rate of any velocity in the box [m/s]."""
    a, b = row * box.lower, row * box.upper
    return float(np.minimum(a, b).sum()), float(np.maximum(a, b).sum())


@given(shares(), st.integers(0, 1000), st.floats(1.0, 40.0), st.floats(0.00125, 0.020))
def test_the_box_keeps_the_stops(share: Array, seed: int, gain: float, dt: float) -> None:
    random = np.random.default_rng(seed)
    box = VelocityBox(-STOPS, STOPS, TOP_SPEED, gain)
    q = share * STOPS
    push = np.where(random.random(7) < 0.5, -100.0, 100.0)
    for _ in range(60):
        box.update(q)
        dq = box.clip(push + random.normal(size=7))
        assert box.contains(dq) and (np.abs(dq) <= TOP_SPEED + 1e-12).all()
        q = q + dq * dt
        assert (np.abs(q) <= STOPS + 1e-12).all()


def test_lost_speed_at_a_stop() -> None:
    """0.1 rad before its upper stop a joint loses top − 1 rad/s upwards and nothing downwards."""
    q = np.zeros(7)
    q[1] = STOPS[1] - 0.1
    box = lwr_box(q)
    up, down = box.lost_speed(np.ones(7)), box.lost_speed(-np.ones(7))
    expected = np.zeros(7)
    expected[1] = TOP_SPEED[1] - 1.0
    assert_allclose(up, expected, atol=1e-12)
    assert_allclose(down, 0.0, atol=1e-12)


@given(shares(), st.floats(1.0, 40.0))
def test_the_box_is_the_top_speed_or_proportional_to_the_distance_left(share: Array, gain: float) -> None:
    """Upper bound: min(top speed, g · distance to the stop); the lower one mirrored; 0 is always allowed."""
    q = share * STOPS
    box = lwr_box(q, gain)
    assert_allclose(box.upper, np.minimum(TOP_SPEED, gain * (STOPS - q)), atol=1e-12)
    assert_allclose(box.lower, -np.minimum(TOP_SPEED, gain * (q + STOPS)), atol=1e-12)
    assert box.contains(np.zeros(7))


@given(shares(), shares())
def test_clip_is_the_nearest_velocity_in_the_box(share: Array, wish: Array) -> None:
    box = lwr_box(share * STOPS)
    wish = 5.0 * wish
    wish.flags.writeable = False
    clipped = box.clip(wish)
    assert box.contains(clipped)
    assert_allclose(clipped, np.clip(wish, box.lower, box.upper))
    assert_array_equal(box.clip(clipped), clipped)
    assert box.contains(wish) is bool(np.array_equal(clipped, wish))


def left_of(row: Array, velocities: Array, box: VelocityBox) -> float:
    """|J_d| of the joints at no bound [m/rad]."""
    return float(np.linalg.norm(row[(velocities > box.lower + 1e-9) & (velocities < box.upper - 1e-9)]))


@given(BOXED, st.floats(0.0, 1.0))
def test_bounded_row_solves_the_quadratic_programme(
    case: tuple[VelocityBox, Array, Array], part: float
) -> None:
    """With authority left: inside the box, at the rate, and as near to the task as a general solver."""
    box, nominal, row = case
    least, most = reach(row, box)
    rate = least + (0.001 + 0.998 * part) * (most - least)
    bounded = bounded_row(nominal, row, rate, box)
    assert box.contains(bounded.velocities)
    # The task's own rate changes nothing.
    assert_allclose(bounded_row(nominal, row, float(row @ nominal), box).velocities, nominal, atol=1e-12)
    assume(left_of(row, bounded.velocities, box) > AUTHORITY)
    assert float(row @ bounded.velocities) == pytest.approx(rate, abs=1e-9)
    assert (bounded.authority, bounded.joint) == (Authority.FULL, -1)
    assert_allclose(bounded.velocities, nearest_by_least_squares(nominal, row, rate, box), atol=1e-6)


@given(BOXED, st.floats(-3.0, 3.0))
def test_bounded_row_moves_along_the_row_and_reports_a_missing_rate(
    case: tuple[VelocityBox, Array, Array], rate: float
) -> None:
    """Always q̇ = clip(q̇_n + c J_d) with a bounded c, never past the rate; FULL if the rate is reached."""
    box, nominal, row = case
    asked = rate - float(row @ nominal)
    bounded = bounded_row(nominal, row, rate, box)
    most = abs(asked) / ROW_DAMPING**2
    inside = (bounded.velocities > box.lower + 1e-9) & (bounded.velocities < box.upper - 1e-9)
    free = inside & (np.abs(row) > 1e-6)
    c = (bounded.velocities - nominal)[free] / row[free]
    assert np.ptp(c) <= 1e-6 * (1.0 + most) if len(c) else True
    assert (np.abs(bounded.velocities - nominal) <= most * np.abs(row) + 1e-9).all()
    gained = float(row @ bounded.velocities) - float(row @ nominal)
    assert -1e-9 <= gained * np.sign(asked) <= abs(asked) + 1e-9
    assert (bounded.authority is Authority.FULL) == (abs(asked - gained) <= 1e-6)
    assert bounded.authority in (Authority.FULL, Authority.STOP, Authority.SPEED)


FLIPPING_ROW = np.array([0.3, 0.2, 0.0, 5e-9, 0.0, 0.0, 0.0])


@given(BOXED, st.floats(-3.0, 3.0), st.integers(0, 10_000), st.sampled_from([1e-8, 1e-6, 1e-4]))
@example(case=(lwr_box(np.zeros(7)), np.zeros(7), FLIPPING_ROW), rate=1.2, seed=0, change=1e-8)
def test_bounded_row_is_lipschitz_in_every_input(
    case: tuple[VelocityBox, Array, Array], rate: float, seed: int, change: float
) -> None:
    """Small changes of task, row, rate and bounds change q̇ little, also where a rate becomes infeasible."""
    box, nominal, row = case
    random = np.random.default_rng(seed)
    other = lwr_box(np.zeros(7))
    other.lower, other.upper = box.lower - change * random.random(7), box.upper + change * random.random(7)
    task, lever = nominal + change * random.uniform(-1.0, 1.0, 7), row + change * random.uniform(-1.0, 1.0, 7)
    before = bounded_row(nominal, row, rate, box).velocities
    after = bounded_row(
        other.clip(task), lever, rate + change * float(random.uniform(-1.0, 1.0)), other
    ).velocities
    # c is at most the wanted change over μ²: q̇ follows J_d by c, and all else by a lever over μ².
    asked = abs(rate) + 2.0 * float(np.abs(row) @ TOP_SPEED) + 1.0
    assert np.abs(after - before).max() <= 20.0 * asked / ROW_DAMPING**2 * change


@given(st.sampled_from([2, 4, 6]), st.sampled_from([-1.0, 1.0]), st.floats(0.0, 1e-5), st.floats(1e-3, 0.5))
@example(joint=6, sign=1.0, lever=1e-17, beyond=0.05)
@example(joint=4, sign=-1.0, lever=1.2e-6, beyond=0.05)
def test_a_joint_without_a_lever_keeps_a_low_speed(
    joint: int, sign: float, lever: float, beyond: float
) -> None:
    """A joint that hardly moves the closest point neither hides a missed rate nor spins without effect."""
    row = np.array([0.31, -0.47, 0.0, 0.23, 0.0, 0.11, 0.0])
    row[joint] = sign * lever
    box = lwr_box(np.zeros(7))
    bounded = bounded_row(np.zeros(7), row, reach(row, box)[1] + beyond, box)
    assert bounded.authority is Authority.SPEED
    assert abs(bounded.velocities[joint]) <= lever * (1.0 + beyond) / ROW_DAMPING**2
    assert_allclose(np.abs(bounded.velocities[[0, 1, 3]]), TOP_SPEED[[0, 1, 3]])


def test_the_reason_is_the_costliest_joint() -> None:
    # Far from every stop only top speeds limit; the joint with the longest lever is named.
    row = np.array([0.2, 0.0, -0.5, 0.2, 0.0, 0.0, 0.15])
    box = lwr_box(np.zeros(7))
    most = reach(row, box)[1]
    bounded = bounded_row(np.zeros(7), row, most + 0.1, box)
    assert (bounded.authority, bounded.joint) == (Authority.SPEED, 2)
    assert_allclose(bounded.velocities, np.sign(row) * TOP_SPEED)
    assert bounded_row(np.zeros(7), row, most - 0.1, box).authority is Authority.FULL
    # Of two joints at stops, the larger product of lever and lost speed counts, not the longer lever.
    row = np.array([0.0, 0.30, 0.0, 0.0, 0.0, 0.28, 0.0])
    q = np.zeros(7)
    q[1], q[5] = STOPS[1], STOPS[5]
    bounded = bounded_row(np.zeros(7), row, 0.5, lwr_box(q))
    assert (bounded.authority, bounded.joint) == (Authority.STOP, 5)
    assert float(row @ bounded.velocities) == pytest.approx(0.0)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_at_a_stop_the_reason_is_that_stop(side: float) -> None:
    row = np.array([0.05, 0.1, 0.0, 0.5 * side, 0.0, 0.1, 0.0])
    q = np.zeros(7)
    q[3] = side * STOPS[3]
    cornered = bounded_row(np.zeros(7), row, 1.0, lwr_box(q))
    assert (cornered.authority, cornered.joint) == (Authority.STOP, 3)
    assert cornered.velocities[3] == 0.0
    free = bounded_row(np.zeros(7), row, 1.0, lwr_box(-q))
    assert (free.authority, free.joint) == (Authority.FULL, -1)
