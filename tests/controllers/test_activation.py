"""λ(d), eq. (31): its range, its shape, its slope, and the values of Fig. 2."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.activation import activation, activation_slope

DISTANCES = st.floats(-0.5, 5.0)
CRITICAL = st.floats(0.03, 0.30)
ORDERS = st.floats(1.0, 20.0)


@given(DISTANCES, CRITICAL, ORDERS, st.floats(0.0, 1.0), st.floats(0.0, 5.0))
def test_it_is_a_share_that_falls_with_distance_and_order(d: float, dm: float, n: float, further: float, more: float) -> None:
    """λ is in (0, 1]; above d_m it falls strictly with d and n, so that a larger n takes over later."""
    lam = activation(d, dm, n)
    assert 0.0 < activation(d + further, dm, n) <= lam <= 1.0
    assert activation(d, dm, n + more) <= lam
    if d > dm and further > 1e-6:
        assert activation(d + further, dm, n) < lam
    if d > 1.001 * dm and more > 1e-3:
        assert activation(d, dm, n + more) < lam


@given(st.floats(-2.0, 1.0), CRITICAL, ORDERS, st.floats(1e-9, 1e-3))
def test_it_is_one_up_to_the_critical_distance_and_continuous_there(share: float, dm: float, n: float, off: float) -> None:
    """λ = 1 for d ≤ d_m, overlap included; above, 1 − λ grows like n (d − d_m)/d_m, so that the slope jumps from 0 to −n/d_m."""
    assert activation(share * dm, dm, n) == activation(dm, dm, n) == 1.0
    assert activation(1.001 * dm, dm, n) < 1.0
    gap = 1.0 - activation(dm * (1.0 + off), dm, n)
    assert 0.0 <= gap <= n * off + 1e-12
    assert gap == pytest.approx(n * off, rel=0.5 * (n + 1.0) * off + 1e-6)
    assert activation_slope(share * dm, dm, n) == 0.0
    assert activation_slope(dm * (1.0 + 1e-9), dm, n) == pytest.approx(-n / dm, rel=1e-6)


@given(st.floats(1.001, 20.0), CRITICAL, ORDERS)
def test_slope_against_finite_differences(ratio: float, dm: float, n: float) -> None:
    d, h = ratio * dm, 1e-6 * dm
    numeric = (activation(d + h, dm, n) - activation(d - h, dm, n)) / (2.0 * h)
    assert activation_slope(d, dm, n) == pytest.approx(numeric, rel=1e-5, abs=1e-9)


@pytest.mark.parametrize(
    ("order", "expected"),
    [(1, (1, 1, 0.8, 0.5, 0.2, 0.1)), (2, (1, 1, 0.64, 0.25, 0.04, 0.01)), (10, (1, 1, 0.1073741824, 2**-10, 1.024e-7, 1e-10))],
)
def test_figure_2(order: float, expected: tuple[float, ...]) -> None:
    curve = [activation(d, 0.1, order) for d in (0.05, 0.1, 0.125, 0.2, 0.5, 1.0)]
    assert curve == pytest.approx(expected, rel=1e-12)
