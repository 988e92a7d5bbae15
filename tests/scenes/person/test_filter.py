"""The low-pass is the exact one, keeps its top speed, and does not care for the step."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from scenes.person.filter import AngleFilter

ZERO = np.zeros((2, 4))


def test_steps_rates_and_inputs() -> None:
    # Below the top speed, y = 1 − exp(−2π f t).
    low_pass = AngleFilter(np.zeros(1), cutoff_hz=0.5, top_rate=20.0)
    found = [float(low_pass.step(np.ones(1), 0.01)[0]) for _ in range(100)]
    assert_allclose(found, 1.0 - np.exp(-math.tau * 0.5 * 0.01 * np.arange(1, 101)), atol=1e-12)
    # A far goal is approached straight at the top speed, then exponentially: both by the closed form, without overshoot.
    rate, omega = 0.5, math.tau * 2.0
    slow = AngleFilter(np.zeros(1), cutoff_hz=2.0, top_rate=rate)
    knee = rate / omega
    reached = (2.0 - knee) / rate
    for k in range(1, 800):
        y = float(slow.step(np.array([2.0]), 0.01)[0])
        t = 0.01 * k
        assert math.isclose(y, rate * t if t < reached else 2.0 - knee * math.exp(-omega * (t - reached)), abs_tol=1e-9)
        assert slow.rates[0] <= rate + 1e-12
    low_pass = AngleFilter(ZERO)
    wanted = np.linspace(-1.0, 1.0, 8).reshape(2, 4)
    a = low_pass.step(wanted, 0.005)
    b = low_pass.step(wanted, 0.005)
    assert_allclose(low_pass.rates, (b - a) / 0.005, atol=1e-12)
    low_pass = AngleFilter(np.full((2, 4), 0.3))
    assert_allclose(low_pass.step(None, 0.1), 0.3)
    assert low_pass.lost
    low_pass = AngleFilter(ZERO)
    assert_allclose(low_pass.step(np.ones((2, 4)), 0.0), 0.0)
    start, wanted = np.zeros((2, 4)), np.ones((2, 4))
    low_pass, twin = AngleFilter(start), AngleFilter(ZERO)
    start[:] = 9.0
    low_pass.step(wanted, 0.01)[:] = 9.0
    wanted[:] = 9.0
    twin.step(np.ones((2, 4)), 0.01)
    assert_allclose(low_pass.step(None, 0.01), twin.step(None, 0.01), atol=0.0)


@given(
    st.lists(st.floats(-10.0, 10.0), min_size=1, max_size=6), st.floats(0.1, 50.0), st.floats(0.05, 20.0), st.floats(1e-4, 0.5),
    st.integers(2, 9),
)  # fmt: skip
def test_the_step_does_not_matter(inputs: list[float], cutoff: float, rate: float, dt: float, parts: int) -> None:
    one, many = (AngleFilter(np.zeros(1), cutoff, rate) for _ in range(2))
    for x in inputs:
        before = one.values.copy()
        a = one.step(np.array([x]), dt)
        for _ in range(parts):
            many.step(np.array([x]), dt / parts)
        assert_allclose(a, many.values, atol=1e-9)
        assert abs(a[0] - before[0]) <= rate * dt * (1.0 + 1e-9) + 1e-12
        assert abs(x - a[0]) <= abs(x - before[0]) + 1e-12


@pytest.mark.parametrize("missing", [None, np.full((2, 4), np.nan), np.array([[0, 0, 0, np.inf], [0, 0, 0, 0.0]])])
def test_lost(missing: np.ndarray | None) -> None:
    low_pass = AngleFilter(ZERO)
    seen = np.full((2, 4), 0.4)
    for _ in range(20):
        low_pass.step(seen, 0.01)
    assert (low_pass.lost, low_pass.lost_for) == (False, 0.0)
    for _ in range(300):
        low_pass.step(missing, 0.01)
    assert low_pass.lost and math.isclose(low_pass.lost_for, 3.0)
    assert_allclose(low_pass.values, seen, atol=1e-9)
    low_pass.step(seen, 0.01)
    assert (low_pass.lost, low_pass.lost_for) == (False, 0.0)
