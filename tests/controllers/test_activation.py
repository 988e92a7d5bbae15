"""λ(d), eq. (31): its range, its shape, its slope, and the values of Fig. 2."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.activation import activation, activation_slope

DISTANCES = st.floats(-0.5, 5.0)
CRITICAL = st.floats(0.03, 0.30)
ORDERS = st.floats(1.0, 20.0)


@given(DISTANCES, CRITICAL, ORDERS)
def test_it_is_a_share(d: float, dm: float, n: float) -> None:
    """λ stays in [0, 1], and never quite reaches 0."""
    assert 0.0 < activation(d, dm, n) <= 1.0


@given(st.floats(-1.0, 1.0), CRITICAL, ORDERS)
def test_it_is_one_up_to_the_critical_distance(share: float, dm: float, n: float) -> None:
    """λ = 1 for every d ≤ d_m, in contact and in overlap too, and below 1 as soon as d is clearly above."""
    assert activation(share * dm, dm, n) == 1.0
    assert activation(dm, dm, n) == 1.0
    assert activation(1.001 * dm, dm, n) < 1.0


@given(DISTANCES, st.floats(0.0, 1.0), CRITICAL, ORDERS)
def test_it_falls_with_distance(d: float, further: float, dm: float, n: float) -> None:
    """λ never grows with d, and falls strictly above d_m."""
    assert activation(d + further, dm, n) <= activation(d, dm, n)
    if d > dm and further > 1e-6:
        assert activation(d + further, dm, n) < activation(d, dm, n)


@given(DISTANCES, CRITICAL, ORDERS, st.floats(0.0, 5.0))
def test_it_falls_with_order(d: float, dm: float, n: float, more: float) -> None:
    """A larger n takes over later: λ never grows with n, and falls strictly above d_m."""
    assert activation(d, dm, n + more) <= activation(d, dm, n)
    if d > 1.001 * dm and more > 1e-3:
        assert activation(d, dm, n + more) < activation(d, dm, n)


@given(CRITICAL, ORDERS, st.floats(1e-9, 1e-3))
def test_it_is_continuous_at_the_critical_distance(dm: float, n: float, off: float) -> None:
    """Coming from above, 1 − λ falls like n (d − d_m)/d_m: no jump where the formula changes."""
    gap = 1.0 - activation(dm * (1.0 + off), dm, n)
    assert 0.0 <= gap <= n * off + 1e-12
    assert gap == pytest.approx(n * off, rel=0.5 * (n + 1.0) * off + 1e-6)


@given(st.floats(1.001, 20.0), CRITICAL, ORDERS)
def test_slope_against_finite_differences(ratio: float, dm: float, n: float) -> None:
    """dλ/dd above d_m is the derivative of λ."""
    d, h = ratio * dm, 1e-6 * dm
    numeric = (activation(d + h, dm, n) - activation(d - h, dm, n)) / (2.0 * h)
    assert activation_slope(d, dm, n) == pytest.approx(numeric, rel=1e-5, abs=1e-9)


@given(st.floats(-2.0, 1.0), CRITICAL, ORDERS)
def test_the_slope_jumps_at_the_critical_distance(share: float, dm: float, n: float) -> None:
    """dλ/dd is 0 up to d_m and −n/d_m right above it: λ is continuous, its slope is not."""
    assert activation_slope(share * dm, dm, n) == 0.0
    assert activation_slope(dm * (1.0 + 1e-9), dm, n) == pytest.approx(-n / dm, rel=1e-6)


@pytest.mark.parametrize(
    ("d", "one", "two", "ten"),
    [
        (0.05, 1.0, 1.0, 1.0),
        (0.1, 1.0, 1.0, 1.0),
        (0.125, 0.8, 0.64, 0.1073741824),
        (0.2, 0.5, 0.25, 1.0 / 1024.0),
        (0.5, 0.2, 0.04, 1.024e-7),
        (1.0, 0.1, 0.01, 1e-10),
    ],
)
def test_figure_2(d: float, one: float, two: float, ten: float) -> None:
    """The curves of Fig. 2: d_m = 0.1 m, n = 1, 2, 10."""
    assert activation(d, 0.1, 1) == pytest.approx(one, rel=1e-12)
    assert activation(d, 0.1, 2) == pytest.approx(two, rel=1e-12)
    assert activation(d, 0.1, 10) == pytest.approx(ten, rel=1e-12)
