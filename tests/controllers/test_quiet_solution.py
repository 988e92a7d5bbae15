"""Damping of an arm that cannot reach its target: closed forms and stable rest of stretched chains."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from controllers.kinematics import (
    DAMPING,
    LONGEST_STEP,
    Array,
    damped_solution,
    largest_bend,
    null_space_basis,
    quiet_solution,
)

LENGTHS = st.lists(st.floats(0.02, 0.6), min_size=2, max_size=7).map(np.array)

SHORTEST_REACH = 0.25
"""Arms with a shorter reach may tremble at the longest time step and a strong pull [m]."""

ARMS = LENGTHS.map(lambda lengths: lengths * max(1.0, SHORTEST_REACH / lengths.sum()))


def chain(lengths: Array, q: Array) -> tuple[Array, Array]:
    """Hand (2,) and J (2, m) of a planar chain."""
    angles = np.cumsum(q)
    links = lengths * np.array([np.cos(angles), np.sin(angles)])
    ways = np.cumsum(links[:, ::-1], axis=1)[:, ::-1]
    return links.sum(axis=1), np.array([-ways[1], ways[0]])


def bending(lengths: Array) -> Array:
    """H (m, m), second derivative of the reach at q = 0: −(distance from the later joint to the hand)."""
    ways = np.cumsum(lengths[::-1])[::-1]
    index = np.arange(len(lengths))
    return -ways[np.maximum.outer(index, index)]


def velocities(lengths: Array, q: Array, beyond: float, gain: float) -> Array:
    """q̇ towards a target out of reach along x."""
    hand, J = chain(lengths, q)
    pull = gain * (np.array([lengths.sum() + beyond, 0.0]) - hand)
    return quiet_solution(J, pull, largest_bend(float(lengths.sum()), len(lengths)))


def test_two_links_bend_by_their_harmonic_sum() -> None:
    """With the hand fixed across the pull, the reach falls by L₁ L₂/(L₁ + L₂) φ²/2 for an elbow turn φ."""
    lengths = np.array([0.4, 0.468])
    way = np.array([-lengths[1] / lengths.sum(), 1.0])
    assert_allclose(chain(lengths, np.zeros(2))[1] @ way, 0.0, atol=1e-15)
    assert -way @ bending(lengths) @ way == pytest.approx(0.4 * 0.468 / 0.868)


@given(LENGTHS)
def test_no_chain_bends_more_than_the_bound(lengths: Array) -> None:
    """Largest eigenvalue of −H in the null space of J ≤ L (m − 1)/4, twice `largest_bend`."""
    null = null_space_basis(chain(lengths, np.zeros(len(lengths)))[1][1:])
    largest = np.linalg.eigvalsh(-null.T @ bending(lengths) @ null).max()
    assert largest <= 2.0 * largest_bend(float(lengths.sum()), len(lengths)) + 1e-12


def test_the_bound_is_reached() -> None:
    """Two joints at the same point in the middle of an arm: L · 2/4; two equal links: L/4."""
    for lengths, bend in (([0.5, 0.5], 0.25), ([0.5, 1e-12, 0.5], 0.5)):
        null = null_space_basis(chain(np.array(lengths), np.zeros(len(lengths)))[1][1:])
        largest = np.linalg.eigvalsh(-null.T @ bending(np.array(lengths)) @ null)
        assert largest_bend(1.0, len(lengths)) == pytest.approx(bend / 2.0)
        # Per |q̇|², which includes the shoulder's part.
        assert 0.6 * bend < largest.max() <= bend + 1e-9


@given(ARMS, st.floats(0.001, 1.0), st.floats(0.1, 20.0))
def test_rest_out_of_reach_is_stable(lengths: Array, beyond: float, gain: float) -> None:
    """∂q̇/∂q = (I − P) H |ẋ|/μ² − K P at rest; Euler's longest time step reduces small deviations."""
    m, step = len(lengths), 1e-6
    numeric = np.empty((m, m))
    for i in range(m):
        turn = step * np.eye(m)[i]
        ahead, back = (velocities(lengths, sign * turn, beyond, gain) for sign in (1.0, -1.0))
        numeric[:, i] = (ahead - back) / (2.0 * step)
    _, J = chain(lengths, np.zeros(m))
    pull = gain * beyond
    damping = DAMPING**2 + LONGEST_STEP * largest_bend(float(lengths.sum()), m) * pull
    P = J.T @ np.linalg.solve(J @ J.T + damping * np.eye(2), J)
    closed = (np.eye(m) - P) @ bending(lengths) * pull / damping - gain * P
    assert_allclose(numeric, closed, atol=1e-5 * (1.0 + np.abs(closed).max()))
    values = np.linalg.eigvals(closed)
    assert_allclose(values.imag, 0.0, atol=1e-6 * np.abs(values).max())
    assert values.real.max() < 1e-9
    assert (1.0 + LONGEST_STEP * values.real).min() > -1.0


@given(st.floats(1e-3, 1.0), st.floats(0.05, 20.0), st.floats(-3.0, 0.0))
def test_a_single_elbow_never_overshoots(bend: float, pull: float, exponent: float) -> None:
    """σ = a φ, φ̇ = −σ |ẋ|/(σ² + μ²): the longest step turns by at most φ, for any start."""
    sigma = 10.0**exponent
    speed = float(quiet_solution(np.array([[sigma]]), np.array([pull]), bend)[0])
    assert LONGEST_STEP * bend * speed <= sigma + 1e-12


@given(st.integers(0, 10_000), st.floats(0.0, 0.5))
def test_a_regular_posture_is_hardly_affected(seed: int, pull: float) -> None:
    """Without a bend the same bits as `damped_solution`; with one, nearly the same for feasible tasks."""
    dice = np.random.default_rng(seed)
    basis = np.linalg.qr(dice.normal(size=(7, 3)))[0].T
    J = np.diag(dice.uniform(0.3, 1.0, 3)) @ basis
    task = dice.normal(size=3)
    task *= pull / np.linalg.norm(task)
    assert_array_equal(quiet_solution(J, task, 0.0), damped_solution(J, task))
    assert_allclose(quiet_solution(J, task, 0.65), damped_solution(J, task), atol=1e-3 * pull)
    assert_array_equal(quiet_solution(J, np.zeros(3), 0.65), np.zeros(7))
