"""λ(d), eq. (31), and the budget ḋ = λ v − (1 − λ) u − w: closed forms against independent formulas."""

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from controllers import budget
from controllers.activation import activation

DISTANCES = st.floats(-0.5, 5.0)
CRITICAL = st.floats(0.03, 0.30)
ORDERS = st.floats(1.0, 20.0)
NOMINAL = st.floats(0.05, 1.0)
PULL = st.floats(0.0, 1.0)
SOME_PULL = st.floats(0.02, 1.0)
SHARE = st.floats(0.0, 0.95)


def rate_at(d: float, dm: float, n: float, v: float, u: float, w: float) -> float:
    """ḋ of line (R), computed without the product's code."""
    lam = 1.0 if d <= dm else (dm / d) ** n
    return lam * v - (1.0 - lam) * u - w


def euler(
    d: float, dt: float, steps: int, dm: float, n: float, v: float, u: float, w: float = 0.0
) -> list[float]:
    path = [d]
    for _ in range(steps):
        path.append(path[-1] + dt * budget.distance_rate(activation(path[-1], dm, n), v, u, w))
    return path


@given(st.floats(0.0, 1.0), NOMINAL, st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_the_line_is_a_blend_of_retreat_and_pull(lam: float, v: float, u: float, w: float) -> None:
    """λ = 1: v − w; λ = 0: −u − w; straight in between."""
    assert budget.distance_rate(lam, v, u, w) == pytest.approx(
        lam * (v - w) + (1.0 - lam) * (-u - w), abs=1e-12
    )


def test_limits_of_the_threshold() -> None:
    # w = v holds exactly at d_m; a slightly larger w does not.
    assert budget.resting_distance(0.15, 6, 0.3, 0.2, 0.3) == pytest.approx(0.15)
    assert math.isnan(budget.resting_distance(0.15, 6, 0.3, 0.2, 0.3 + 1e-9))
    # u + v = 0: λ has no effect and any step is stable; otherwise there is a limit.
    assert budget.largest_step(0.15, 6, 0.3, -0.3) == math.inf
    assert math.isfinite(budget.largest_step(0.15, 6, 0.3, -0.2))


@given(CRITICAL, ORDERS, NOMINAL, st.floats(0.01, 1.0), SHARE)
def test_nothing_moves_at_rest(dm: float, n: float, v: float, u: float, share: float) -> None:
    """At d* the rate is 0; nearer it is positive, farther negative; the time constant is −1/slope."""
    w = share * v
    rest = budget.resting_distance(dm, n, v, u, w)
    assert rest >= dm and rate_at(rest, dm, n, v, u, w) == pytest.approx(0.0, abs=1e-9)
    assert activation(rest, dm, n) == pytest.approx((u + w) / (u + v), rel=1e-9)
    assert rate_at(0.99 * rest, dm, n, v, u, w) > 0.0 > rate_at(1.01 * rest, dm, n, v, u, w)
    h = 1e-6 * rest
    if rest > dm + h and u >= 0.02 and share <= 0.9:
        slope = (rate_at(rest + h, dm, n, v, u, w) - rate_at(rest - h, dm, n, v, u, w)) / (2.0 * h)
        assert budget.settling_time(dm, n, v, u, w) == pytest.approx(-1.0 / slope, rel=1e-5)


@given(CRITICAL, ORDERS, NOMINAL, st.floats(-0.5, 1.0), st.floats(0.0, 2.0))
def test_d_m_holds_up_to_an_obstacle_speed_of_v(dm: float, n: float, v: float, u: float, w: float) -> None:
    """At d_m line (R) gives v − w for any u: d holds if and only if w ≤ v; otherwise it is lost at w − v."""
    at_threshold = rate_at(dm, dm, n, v, u, w)
    assert at_threshold == pytest.approx(v - w, abs=1e-12)
    assert budget.distance_loss_rate(v, w) == pytest.approx(max(0.0, -at_threshold), abs=1e-12)


@given(CRITICAL, ORDERS, NOMINAL, PULL, st.floats(-1.0, 1.0), st.floats(1e-6, 1.0))
def test_without_a_resting_distance_the_results_are_inf_or_nan(
    dm: float, n: float, v: float, u: float, w: float, more: float
) -> None:
    """u + w ≤ 0: no approach, d* = inf; w > v: λ would exceed 1, d* = nan. The time constant likewise."""
    following = budget.resting_distance, budget.settling_time
    assume(-w - more + w <= 0.0)
    assert [value(dm, n, v, -w - more, w) for value in following] == [math.inf] * 2
    assert all(math.isnan(value(dm, n, v, u, v + more)) for value in following)


def test_euler_by_example() -> None:
    # Integrated finely, a deviation of 1 mm from the rest falls to 1/e in one settling time.
    dm, n, v, u, w = 0.15, 6.0, 0.3, 0.1, 0.05
    rest, tau = budget.resting_distance(dm, n, v, u, w), budget.settling_time(dm, n, v, u, w)
    end = euler(rest + 1e-3, tau / 2000.0, 2000, dm, n, v, u, w)[-1]
    assert (end - rest) / 1e-3 == pytest.approx(math.exp(-1.0), rel=0.02)
    # Positive control of the test below: at .95 of the limit near the threshold the path crosses its rest.
    path = euler(0.5 * 0.15, 0.95 * budget.largest_step(0.15, 6.0, 0.3, 0.2), 400, 0.15, 6.0, 0.3, 0.2, 0.28)
    assert max(path) > budget.resting_distance(0.15, 6.0, 0.3, 0.2, 0.28) * (1.0 + 1e-6)


@given(CRITICAL, ORDERS, NOMINAL, SOME_PULL, SHARE)
def test_the_limits_of_explicit_euler(dm: float, n: float, v: float, u: float, share: float) -> None:
    """A deviation of 1 nm shrinks at .95 of the limit and grows at 1.05; the limit is smallest at d_m."""
    w = share * v
    rest, limit = budget.resting_distance(dm, n, v, u, w), 2.0 * budget.settling_time(dm, n, v, u, w)
    least = budget.largest_step(dm, n, v, u)
    assert least <= limit * (1.0 + 1e-12)
    # With half of the smallest limit the distance approaches its rest without crossing it.
    assert max(euler(0.5 * dm, 0.499 * least, 60, dm, n, v, u, w)) <= rest * (1.0 + 1e-9)
    if rest > 1.001 * dm and share <= 0.8:
        below, above = (euler(rest + 1e-9, part * limit, 20, dm, n, v, u, w)[-1] for part in (0.95, 1.05))
        assert abs(below - rest) < 0.6e-9 and abs(above - rest) > 2e-9
    # As the obstacle's speed nears v, the rest nears d_m and its limit the smallest: neither is too cautious.
    if n >= 1.5:
        assert 2.0 * budget.settling_time(dm, n, v, u, (1.0 - 1e-7) * v) == pytest.approx(least, rel=1e-5)


@pytest.mark.parametrize(
    ("d", "n", "speed"), [(0.15, 6, 0.3), (0.10, 6, 0.3), (0.30, 1, 0.15), (0.30, 2, 0.075)]
)
def test_far_bias(d: float, n: float, speed: float) -> None:
    assert budget.far_bias_speed(d, 0.15, n, 0.3) == pytest.approx(speed)


@given(DISTANCES, CRITICAL, ORDERS, st.floats(0.0, 1.0), st.floats(0.0, 5.0))
def test_lambda_falls_with_distance_and_order(
    d: float, dm: float, n: float, further: float, more: float
) -> None:
    """λ is in (0, 1]; above d_m it falls strictly with d and n: a larger n acts later."""
    lam = activation(d, dm, n)
    assert 0.0 < activation(d + further, dm, n) <= lam <= 1.0 and activation(d, dm, n + more) <= lam
    if d > dm and further > 1e-6:
        assert activation(d + further, dm, n) < lam
    if d > 1.001 * dm and more > 1e-3:
        assert activation(d, dm, n + more) < lam


@given(st.floats(-2.0, 1.0), CRITICAL, ORDERS, st.floats(1e-9, 1e-3))
def test_lambda_is_one_up_to_the_critical_distance_and_continuous(
    share: float, dm: float, n: float, off: float
) -> None:
    """λ = 1 for d ≤ d_m, also in overlap; above, 1 − λ ≈ n (d − d_m)/d_m: the slope jumps to −n/d_m."""
    assert activation(share * dm, dm, n) == activation(dm, dm, n) == 1.0
    assert activation(1.001 * dm, dm, n) < 1.0
    gap = 1.0 - activation(dm * (1.0 + off), dm, n)
    assert 0.0 <= gap <= n * off + 1e-12
    assert gap == pytest.approx(n * off, rel=0.5 * (n + 1.0) * off + 1e-6)
