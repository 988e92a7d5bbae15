"""The bins of the plots over time: extremes and steps of every signal are in the lines that are drawn, at any width."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.plots.bins import AT_HIGH, HIGH, LAST, LOW, POINTS, WINDOW, Bins, bin_numbers, polyline
from controllers.kinematics import Array

TOLERANCE = 0.02

runs = st.tuples(
    st.integers(0, 2**32 - 1),
    st.sampled_from([0.00125, 0.005, 0.02]),
    st.integers(1, 3),
    st.integers(2, 4000),
    st.integers(1, 70),
)
"""Seed, time step, number of signals, of steps, and of steps taken in at once."""


def signals(seed: int, dt: float, columns: int, steps: int) -> tuple[Array, Array]:
    """Smooth motion with jumps, spikes of one sample, and chatter in between."""
    rng = np.random.default_rng(seed)
    times: Array = np.linspace(0.0, (steps - 1) * dt, steps)
    values = np.sin(times[:, None] * rng.uniform(0.1, 6.0, columns) + rng.uniform(0.0, 6.0, columns))
    for column in range(columns):
        for _ in range(rng.integers(4)):
            at = rng.integers(steps)
            match rng.integers(3):
                case 0:
                    values[at:, column] += rng.uniform(-1.0, 1.0)
                case 1:
                    values[at, column] += rng.uniform(-1.0, 1.0)
                case _:
                    piece = values[at : at + 200, column]
                    piece[::2] += 0.3
    return times, values


def binned(times: Array, values: Array, batch: int) -> Bins:
    bins = Bins(values.shape[1])
    for begin in range(0, len(times), batch):
        bins.take(times[begin : begin + batch], values[begin : begin + batch])
    return bins


def drawn(bins: Bins, columns: list[int]) -> tuple[Array, Array]:
    numbers = bins.numbers
    times, values = polyline(numbers, bins.ends(numbers), bins.at(numbers, columns), TOLERANCE)
    return times, values.T


@given(runs)
def test_the_extremes_of_every_bin_are_drawn(run: tuple[int, float, int, int, int]) -> None:
    seed, dt, columns, steps, batch = run
    times, values = signals(seed, dt, columns, steps)
    bins = binned(times, values, batch)
    xs, lines = drawn(bins, list(range(columns)))
    assert (np.diff(xs) >= 0.0).all() and len(xs) <= 5 * POINTS
    assert xs[-1] == times[-1] and np.array_equal(lines[-1], values[-1])
    numbers, before = bin_numbers(times), -np.inf
    for number in bins.numbers:
        rows = np.flatnonzero(numbers == number)
        inside, came_from = values[rows], values[max(rows[0] - 1, 0)]
        end = times[rows[-1]]
        # The line within the bin, from where it comes in.
        here = (xs > before) & (xs <= end)
        edges = [np.interp(x, xs, line) for x in (max(before, xs[0]), end) for line in lines.T]
        for column, line in enumerate(lines.T):
            reached = np.concatenate([line[here], edges[column::columns]])
            assert reached.max() >= inside[:, column].max() - 2.0 * TOLERANCE
            assert reached.min() <= inside[:, column].min() + 2.0 * TOLERANCE
            # Nothing is drawn that was not there.
            if here.any():
                assert line[here].max() <= max(inside[:, column].max(), came_from[column]) + 2.0 * TOLERANCE
        before = end


@given(runs, st.integers(1, 3999), st.floats(0.1, 2.0), st.booleans())
def test_a_single_step_is_drawn_as_an_edge(run: tuple[int, float, int, int, int], at: int, size: float, spike: bool) -> None:
    _, dt, _, steps, batch = run
    at = at % (steps - 1) + 1
    times, values = np.linspace(0.0, (steps - 1) * dt, steps), np.zeros((steps, 1))
    values[at : at + 1 if spike else None] = size
    bins = binned(times, values, batch)
    xs, lines = drawn(bins, [0])
    if times[at] < xs[0]:
        return
    up = np.flatnonzero(np.diff(lines[:, 0]) > size / 2.0)
    if at > 0 and times[at - 1] >= xs[0]:
        assert len(up) == 1 and lines[up[0], 0] == 0.0 and lines[up[0] + 1, 0] == size
        np.testing.assert_allclose((xs[up[0]], xs[up[0] + 1]), (times[at - 1], times[at]), atol=1e-12)


def test_a_straight_line_costs_few_points_and_a_slope_is_no_step() -> None:
    times: Array = np.linspace(0.0, 20.0, 4001)
    for values in (np.zeros(4001), 3.0 * times):
        xs, lines = drawn(binned(times, values[:, None], 20), [0])
        assert len(xs) < POINTS / 4
        np.testing.assert_allclose(lines[:, 0], np.interp(xs, times, values), atol=1e-9)


def test_corners_stay_while_the_window_moves() -> None:
    times: Array = np.linspace(0.0, 39.995, 8000)
    values = np.sin(times)[:, None]
    bins = Bins(1)
    before: set[float] = set()
    for begin in range(0, 8000, 25):
        bins.take(times[begin : begin + 25], values[begin : begin + 25])
        corners = {float(x) for x in drawn(bins, [0])[0]}
        # The newest bins are not settled yet.
        inside = {x for x in before if corners and min(corners) + 2.0 < x < max(before) - 2.0}
        assert inside <= corners
        before = corners


def test_what_is_missing_stays_missing_and_the_ring_forgets() -> None:
    times: Array = np.linspace(0.0, 3.99, 400)
    values = np.column_stack([times, np.full(400, np.nan), np.full(400, np.inf)])
    values[100:, 1] = 1.0
    bins = binned(times, values, 10)
    _, lines = drawn(bins, [0, 1, 2])
    assert np.isnan(lines[0, 1]) and lines[-1, 1] == 1.0 and np.isinf(lines[:, 2]).all()
    assert bins.at(np.array([0]), [1])[LAST, 0, 0] != 1.0
    # After a long pause only what is new is there.
    bins.take(np.array([4.0 + 2.0 * WINDOW]), np.array([[7.0, 8.0, 9.0]]))
    assert len(bins.numbers) == 1 and bins.at(bins.numbers, [0])[[LOW, HIGH, AT_HIGH], 0, 0].tolist() == [7.0, 7.0, 44.0]
    bins.clear()
    assert not len(bins.numbers)
