"""The distance budget ḋ = λ v − (1 − λ) u − w: its closed forms against each other, the paper's numbers and the line itself."""

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from controllers import budget
from controllers.activation import activation

CRITICAL = st.floats(0.03, 0.30)
ORDERS = st.floats(1.0, 20.0)
NOMINAL = st.floats(0.05, 1.0)
PULL = st.floats(0.0, 1.0)
SHARE = st.floats(0.0, 0.95)


def rate_at(d: float, dm: float, n: float, v: float, u: float, w: float) -> float:
    """Return ḋ of line (R) at a distance, written out here."""
    lam = 1.0 if d <= dm else (dm / d) ** n
    return lam * v - (1.0 - lam) * u - w


def euler(d: float, dt: float, steps: int, dm: float, n: float, v: float, u: float, w: float = 0.0) -> list[float]:
    """Return the distances that explicit Euler makes of line (R)."""
    path = [d]
    for _ in range(steps):
        path.append(path[-1] + dt * budget.distance_rate(activation(path[-1], dm, n), v, u, w))
    return path


@given(st.floats(0.0, 1.0), NOMINAL, st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_the_line_is_a_blend_of_retreat_and_pull(lam: float, v: float, u: float, w: float) -> None:
    """λ = 1: v − w whatever u; λ = 0: −u − w whatever v; straight in between."""
    assert budget.distance_rate(1.0, v, u, w) == pytest.approx(v - w)
    assert budget.distance_rate(0.0, v, u, w) == pytest.approx(-u - w)
    assert budget.distance_rate(lam, v, u, w) == pytest.approx(lam * (v - w) + (1.0 - lam) * (-u - w), abs=1e-12)


@given(st.floats(0.0, 1.0), NOMINAL, PULL, PULL)
def test_both_arms(lam: float, v: float, left: float, right: float) -> None:
    """Each arm is the other's obstacle: with w = −J_d q̇ of the other, two single lines make the line for both."""
    other = lam * v - (1.0 - lam) * right
    assert budget.distance_rate_both(lam, v, left, right) == pytest.approx(budget.distance_rate(lam, v, left, -other), abs=1e-12)
    assert budget.distance_rate_both(1.0, v, left, right) == pytest.approx(2.0 * v)


@pytest.mark.parametrize(("n", "expected"), [(1, 0.375), (2, 0.2372), (10, 0.1644)])
def test_the_papers_examples(n: int, expected: float) -> None:
    """d_m .15, v .3, u .2, w 0."""
    assert budget.resting_distance(0.15, n, 0.3, 0.2, 0.0) == pytest.approx(expected, abs=5e-5)


def test_limits_of_the_threshold() -> None:
    # u = w = .1, v = .3: λ* = .2/.4 = 1/2, so d* = d_m 2^(1/n).
    assert budget.resting_activation(0.3, 0.1, 0.1) == pytest.approx(0.5)
    assert budget.resting_distance(0.15, 1, 0.3, 0.1, 0.1) == pytest.approx(0.30)
    assert budget.resting_distance(0.15, 4, 0.3, 0.1, 0.1) == pytest.approx(0.15 * 2**0.25)
    # w = v still holds, at d_m exactly; the least bit more does not.
    assert budget.holds_distance(0.3, 0.3)
    assert budget.resting_distance(0.15, 6, 0.3, 0.2, 0.3) == pytest.approx(0.15)
    assert budget.resting_activation(0.3, 0.2, 0.3) == pytest.approx(1.0)
    assert not budget.holds_distance(0.3, 0.3 + 1e-9)
    # u + v = 0: λ does not matter, λ* is nan; a little off it is a number again.
    assert math.isnan(budget.resting_activation(0.3, -0.3, 0.1))
    assert budget.resting_activation(0.3, -0.2, 0.25) == pytest.approx(0.5)
    assert budget.largest_step(0.15, 6, 0.3, -0.3) == math.inf
    assert math.isfinite(budget.largest_step(0.15, 6, 0.3, -0.2))


@given(CRITICAL, ORDERS, NOMINAL, st.floats(0.01, 1.0), SHARE)
def test_nothing_moves_at_rest(dm: float, n: float, v: float, u: float, share: float) -> None:
    """At d* the rate is 0 and λ is λ*; nearer it is positive, further away negative: the rest attracts."""
    w = share * v
    rest = budget.resting_distance(dm, n, v, u, w)
    assert rest >= dm
    assert rate_at(rest, dm, n, v, u, w) == pytest.approx(0.0, abs=1e-9)
    assert activation(rest, dm, n) == pytest.approx(budget.resting_activation(v, u, w), rel=1e-9)
    assert rate_at(0.99 * rest, dm, n, v, u, w) > 0.0 > rate_at(1.01 * rest, dm, n, v, u, w)


@given(CRITICAL, ORDERS, NOMINAL, st.floats(-0.5, 1.0), st.floats(0.0, 2.0))
def test_the_threshold_is_the_obstacles_speed(dm: float, n: float, v: float, u: float, w: float) -> None:
    """At d_m line (R) gives v − w whatever u: the distance holds if and only if w ≤ v, and is lost at w − v if not."""
    at_threshold = rate_at(dm, dm, n, v, u, w)
    assert at_threshold == pytest.approx(v - w, abs=1e-12)
    assert budget.holds_distance(v, w) is (w <= v)
    assert budget.loss_rate(v, w) == pytest.approx(max(0.0, -at_threshold), abs=1e-12)


@given(CRITICAL, ORDERS, st.floats(0.0, 1.0), st.floats(-1.0, 1.0), st.floats(0.0, 1.0))
def test_without_a_pull_there_is_no_rest(dm: float, n: float, v: float, w: float, more: float) -> None:
    """u + w ≤ 0: nothing draws the bodies together, d* = inf, and so are the times that follow from it."""
    u = -w - more
    assume(u + w <= 0.0)
    assert budget.resting_distance(dm, n, v, u, w) == math.inf
    assert budget.settling_time(dm, n, v, u, w) == math.inf
    assert budget.largest_step_at_rest(dm, n, v, u, w) == math.inf


@given(CRITICAL, ORDERS, NOMINAL, PULL, st.floats(1e-6, 1.0))
def test_a_faster_obstacle_leaves_no_rest(dm: float, n: float, v: float, u: float, faster: float) -> None:
    """w > v: λ* would have to exceed 1; d*, and the times that follow from it, are nan."""
    w = v + faster
    assert budget.resting_activation(v, u, w) > 1.0
    assert math.isnan(budget.resting_distance(dm, n, v, u, w))
    assert math.isnan(budget.settling_time(dm, n, v, u, w))
    assert math.isnan(budget.largest_step_at_rest(dm, n, v, u, w))


@given(CRITICAL, ORDERS, NOMINAL, st.floats(0.02, 1.0), st.floats(0.0, 0.9))
def test_settling_time_against_finite_differences(dm: float, n: float, v: float, u: float, share: float) -> None:
    """The time constant at d* is −1 over the slope of ḋ(d) there."""
    w = share * v
    rest = budget.resting_distance(dm, n, v, u, w)
    h = 1e-6 * rest
    assume(rest > dm + h)
    slope = (rate_at(rest + h, dm, n, v, u, w) - rate_at(rest - h, dm, n, v, u, w)) / (2.0 * h)
    assert budget.settling_time(dm, n, v, u, w) == pytest.approx(-1.0 / slope, rel=1e-5)


def test_euler_by_example() -> None:
    # Integrated finely, 1 mm off the rest has fallen to 1/e after one settling time.
    dm, n, v, u, w = 0.15, 6.0, 0.3, 0.1, 0.05
    rest, tau = budget.resting_distance(dm, n, v, u, w), budget.settling_time(dm, n, v, u, w)
    end = euler(rest + 1e-3, tau / 2000.0, 2000, dm, n, v, u, w)[-1]
    assert (end - rest) / 1e-3 == pytest.approx(math.exp(-1.0), rel=0.02)
    # Positive control of the test before: at .95 of the limit near the threshold the path does cross its rest.
    dm, n, v, u, w = 0.15, 6.0, 0.3, 0.2, 0.28
    path = euler(0.5 * dm, 0.95 * budget.largest_step(dm, n, v, u), 400, dm, n, v, u, w)
    assert max(path) > budget.resting_distance(dm, n, v, u, w) * (1.0 + 1e-6)


@given(CRITICAL, ORDERS, NOMINAL, st.floats(0.02, 1.0), st.floats(0.0, 0.8))
def test_explicit_euler_is_stable_just_below_its_limit_and_unstable_just_above(
    dm: float, n: float, v: float, u: float, share: float
) -> None:
    """A nanometre off the rest shrinks at .95 of the limit, grows at 1.05 of it."""
    w = share * v
    rest, limit = budget.resting_distance(dm, n, v, u, w), budget.largest_step_at_rest(dm, n, v, u, w)
    assume(rest > 1.001 * dm)
    off = 1e-9
    below = euler(rest + off, 0.95 * limit, 20, dm, n, v, u, w)
    above = euler(rest + off, 1.05 * limit, 20, dm, n, v, u, w)
    assert abs(below[-1] - rest) < 0.6 * off
    assert abs(above[-1] - rest) > 2.0 * off


@given(CRITICAL, ORDERS, NOMINAL, st.floats(0.02, 1.0), SHARE)
def test_the_limit_at_the_critical_distance(dm: float, n: float, v: float, u: float, share: float) -> None:
    # Below `largest_step` no rest is unstable, whatever the obstacle's speed.
    assert budget.largest_step(dm, n, v, u) <= budget.largest_step_at_rest(dm, n, v, u, share * v) * (1.0 + 1e-12)
    # With dt ≤ half of `largest_step` the distance comes to rest from its side; at .9 of the whole it may cross over.
    w = share * v
    rest = budget.resting_distance(dm, n, v, u, w)
    path = euler(0.5 * dm, 0.499 * budget.largest_step(dm, n, v, u), 60, dm, n, v, u, w)
    assert max(path) <= rest * (1.0 + 1e-9)


@given(CRITICAL, st.floats(1.5, 20.0), NOMINAL, st.floats(0.02, 1.0))
def test_the_limit_at_the_critical_distance_is_where_lambda_is_steepest(dm: float, n: float, v: float, u: float) -> None:
    """As the obstacle's speed nears v, the rest nears d_m, and its limit nears `largest_step`: neither is too cautious."""
    w = (1.0 - 1e-7) * v
    assert budget.largest_step_at_rest(dm, n, v, u, w) == pytest.approx(budget.largest_step(dm, n, v, u), rel=1e-5)


@pytest.mark.parametrize(("d", "n", "speed"), [(0.15, 6, 0.3), (0.10, 6, 0.3), (0.30, 1, 0.15), (0.30, 2, 0.075)])
def test_far_bias(d: float, n: float, speed: float) -> None:
    """An arm with nothing to do is pushed away at λ v, even at twice d_m."""
    assert budget.far_bias_speed(d, 0.15, n, 0.3) == pytest.approx(speed)
