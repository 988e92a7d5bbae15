"""Joint bounds: the box keeps the stops, and the bounded row solves its quadratic programme, or says why no velocity could."""

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import lsq_linear

from controllers.kinematics import Array
from controllers.limits import Authority, VelocityBox, bounded_row

STOPS = np.radians([170.0, 120.0, 170.0, 120.0, 170.0, 120.0, 170.0])
TOP_SPEED = np.radians([100.0, 110.0, 100.0, 130.0, 130.0, 180.0, 180.0])


def lwr_box(positions: Array, gain: float = 10.0) -> VelocityBox:
    box = VelocityBox(-STOPS, STOPS, TOP_SPEED, gain)
    box.update(positions)
    return box


def shares(size: int = 7) -> st.SearchStrategy[Array]:
    return st.lists(st.floats(-1.0, 1.0), min_size=size, max_size=size).map(lambda numbers: np.array(numbers, float))


# An entry is either none at all or clearly felt; what lies between has a test of its own.
ROWS = shares().map(lambda row: np.where(np.abs(row) < 1e-3, 0.0, row)).filter(lambda row: float(np.abs(row).max()) >= 0.05)


@st.composite
def boxed(draw: st.DrawFn) -> tuple[VelocityBox, Array, Array]:
    """A box, a task's velocity in it, and a row, all read-only."""
    box = lwr_box(draw(shares()) * STOPS)
    nominal, row = box.clip(draw(shares()) * TOP_SPEED), draw(ROWS).copy()
    nominal.flags.writeable = row.flags.writeable = False
    return box, nominal, row


BOXED = boxed()


def nearest_by_least_squares(nominal: Array, row: Array, rate: float, box: VelocityBox) -> Array:
    """Solve min |x − q̇_n|² s.t. J_d x = r, lower ≤ x ≤ upper by a general solver: r as one very heavy row of a bounded fit."""
    heavy = 1e7
    A, b = np.vstack([np.eye(7), heavy * row]), np.append(nominal, heavy * rate)
    # A joint at its stop leaves no room at all, which the solver refuses to be given.
    fit = lsq_linear(A, b, (box.lower - 1e-12, box.upper + 1e-12), method="bvls", tol=1e-14)
    return np.asarray(fit.x)


def reach(row: Array, box: VelocityBox) -> tuple[float, float]:
    """The smallest and largest distance rate that any velocity in the box has [m/s]."""
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


def test_the_speed_that_a_stop_takes_away() -> None:
    """A joint a tenth of a radian before its upper stop has lost top − 1 rad/s upwards and nothing downwards."""
    q = np.zeros(7)
    q[1] = STOPS[1] - 0.1
    box = lwr_box(q)
    up, down = box.lost_speed(np.ones(7)), box.lost_speed(-np.ones(7))
    expected = np.zeros(7)
    expected[1] = TOP_SPEED[1] - 1.0
    assert_allclose(up, expected, atol=1e-12)
    assert_allclose(down, 0.0, atol=1e-12)


@given(shares(), st.floats(1.0, 40.0))
def test_the_box_is_top_speed_or_the_way_left(share: Array, gain: float) -> None:
    """Upper bound: min(top speed, g · way to the upper stop); the lower one mirrored. Standing still is always allowed."""
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


@given(BOXED, st.floats(0.0, 1.0))
def test_it_solves_the_quadratic_programme(case: tuple[VelocityBox, Array, Array], part: float) -> None:
    """For every rate that the box can reach: in the box, at the rate, and as near to the task as a general solver gets."""
    box, nominal, row = case
    least, most = reach(row, box)
    assume(most - least > 1e-3)
    rate = least + (0.001 + 0.998 * part) * (most - least)
    bounded = bounded_row(nominal, row, rate, box)
    assert box.contains(bounded.velocities)
    assert float(row @ bounded.velocities) == pytest.approx(rate, abs=1e-9)
    assert (bounded.authority, bounded.joint) == (Authority.FULL, -1)
    assert_allclose(bounded.velocities, nearest_by_least_squares(nominal, row, rate, box), atol=1e-6)
    # A rate that the task has already changes nothing.
    assert_allclose(bounded_row(nominal, row, float(row @ nominal), box).velocities, nominal, atol=1e-12)


@given(BOXED, st.sampled_from([-1.0, 1.0]), st.floats(1e-4, 2.0))
def test_beyond_its_reach_it_gives_all_it_has(case: tuple[VelocityBox, Array, Array], side: float, beyond: float) -> None:
    box, nominal, row = case
    furthest = reach(row, box)[1 if side > 0.0 else 0]
    bounded = bounded_row(nominal, row, furthest + side * beyond, box)
    assert box.contains(bounded.velocities)
    assert float(row @ bounded.velocities) == pytest.approx(furthest, abs=1e-9)
    assert bounded.authority in (Authority.STOP, Authority.SPEED)
    idle = row == 0.0
    assert_array_equal(bounded.velocities[idle], nominal[idle])


@given(BOXED, st.floats(-2.0, 2.0), st.floats(0.0, 1e-6))
def test_continuous_in_the_rate(case: tuple[VelocityBox, Array, Array], rate: float, change: float) -> None:
    box, nominal, row = case
    before, after = bounded_row(nominal, row, rate, box), bounded_row(nominal, row, rate + change, box)
    lever = float(np.abs(row[row != 0.0]).min())
    assert np.abs(after.velocities - before.velocities).max() <= change / lever + 1e-8


NOISY_ROW = np.array([0.31, -0.47, 0.0, 0.23, 0.0, 0.11, 0.0])


@given(st.sampled_from([2, 4, 6]), st.floats(-1e-15, 1e-15), st.integers(0, 500), st.floats(1e-3, 0.5))
@example(joint=6, noise=1e-17, seed=0, beyond=0.05)
def test_rounding_noise_in_the_row_is_no_lever(joint: int, noise: float, seed: int, beyond: float) -> None:
    """A roll joint whose entry is 0 but for rounding neither hides that a rate is missed nor spins at top speed to no effect."""
    row = NOISY_ROW * np.random.default_rng(seed).uniform(0.5, 1.0, 7)
    row[joint] = noise
    box, nominal = lwr_box(np.zeros(7)), np.zeros(7)
    most = reach(row, box)[1]
    bounded = bounded_row(nominal, row, most + beyond, box)
    assert bounded.authority is Authority.SPEED
    assert float(row @ bounded.velocities) == pytest.approx(most, abs=1e-6)
    assert abs(bounded.velocities[joint]) < 1e-6


def test_the_reason_is_the_costliest_joint() -> None:
    # Far from every stop only the top speeds can be in the way; the joint with the longest lever is named.
    row = np.array([0.1, 0.0, -0.5, 0.2, 0.0, 0.0, 0.05])
    box = lwr_box(np.zeros(7))
    most = reach(row, box)[1]
    bounded = bounded_row(np.zeros(7), row, most + 0.1, box)
    assert (bounded.authority, bounded.joint) == (Authority.SPEED, 2)
    assert_allclose(bounded.velocities, np.sign(row) * TOP_SPEED)
    assert bounded_row(np.zeros(7), row, most - 0.1, box).authority is Authority.FULL
    # Of two joints at their stops it is the one whose lever times lost speed is larger, not the one with the longer lever
    # alone.
    row = np.array([0.0, 0.30, 0.0, 0.0, 0.0, 0.28, 0.0])
    q = np.zeros(7)
    q[1], q[5] = STOPS[1], STOPS[5]
    bounded = bounded_row(np.zeros(7), row, 0.5, lwr_box(q))
    assert (bounded.authority, bounded.joint) == (Authority.STOP, 5)
    assert float(row @ bounded.velocities) == pytest.approx(0.0)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_reason_is_a_stop_at_a_stop(side: float) -> None:
    row = np.array([0.05, 0.1, 0.0, 0.5 * side, 0.0, 0.1, 0.0])
    q = np.zeros(7)
    q[3] = side * STOPS[3]
    cornered = bounded_row(np.zeros(7), row, 1.0, lwr_box(q))
    assert (cornered.authority, cornered.joint) == (Authority.STOP, 3)
    assert cornered.velocities[3] == 0.0
    free = bounded_row(np.zeros(7), row, 1.0, lwr_box(-q))
    assert (free.authority, free.joint) == (Authority.FULL, -1)
