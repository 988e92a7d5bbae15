"""Time plots: columns and colours of every experiment; bins keep extremes and steps, also the ghost's."""

import math
import re
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.plots.bins import AT_HIGH, HIGH, LAST, LOW, POINTS, WINDOW, Bins, bin_numbers, polyline
from app.plots.plot_choice import cells, first_plots, is_chart, layout_html, possible_details
from app.plots.time_plots import colour_of, time_plot_of
from app.plots.time_series import COLUMNS, NAMES, RollingSeries, drawable
from app.theme import PALETTES
from controllers.kinematics import Array
from scenes.history import COLUMN
from scenes.settings import RobotName, RunSettings
from scenes.simulation import Simulation
from scenes.two_arms import Autopilot
from tests.app.plots.helpers import DETAILS, SCENES, played


def test_the_first_two_plots_replace_impossible_ones() -> None:
    alone = RunSettings(scene="solo")
    assert cells(alone, "none", ("pairs",)) == first_plots(alone) and cells(
        alone, "none", ("pairs", "rates")
    ) == ("rates",)


@pytest.mark.parametrize("scene", SCENES)
def test_every_plot_of_every_experiment_has_columns_and_colours(scene: str) -> None:
    simulation = played(scene)
    for details in DETAILS:
        shown = cells(simulation.settings, details)
        assert len(set(shown)) == len(shown) <= 4
        assert shown[:2] == (("hand", "elbow") if scene == "solo" else ("distance", "error"))
        assert details == "none" or (details in shown) == (details in possible_details(simulation.settings))
        for name in shown:
            if is_chart(name):
                continue
            plot = time_plot_of(name, simulation)
            assert {line.run for line in plot.lines} <= {"own", "ghost", "what_if"}
            for line in plot.lines:
                assert line.column in COLUMNS
                for palette in PALETTES.values():
                    assert re.fullmatch(r"#[0-9a-f]{6}", colour_of(line, palette))
            # Lines of one colour need another cue.
            own = [(line.colour, line.dash) for line in plot.lines if line.run == "own"]
            assert len(set(own)) == len(own)
    unit = time_plot_of("error", simulation).unit
    assert unit == ("rad²" if scene in ("master_slave", "imitation") else "m²")


def test_a_plot_has_the_same_lines_in_every_experiment() -> None:
    """The page would rebuild a plot with other lines while its data change."""
    settings = [RunSettings(scene=scene) for scene in ("hold", "master_slave", "imitation")]
    settings += [
        RunSettings(scene="imitation", avoid="both"),
        RunSettings(scene="master_slave", robot=get_args(RobotName)[-1]),
    ]
    simulations = [Simulation(s) for s in settings]
    for name in ("distance", "error", "joints", "rates", "follow"):
        assert (
            len({tuple(line.column for line in time_plot_of(name, one).lines) for one in simulations}) == 1
        ), name


def test_the_layout_has_a_column_for_every_plot() -> None:
    for shown in (
        ("distance", "error"),
        ("distance", "error", "laws"),
        ("distance", "error", "follow", "follow_other"),
    ):
        wide, narrow = re.findall(r"--duet-\w+:([^;}]*)", layout_html(shown))
        assert wide.count("minmax") == len(shown)
        assert narrow.count("minmax") == (2 if shown[-1] == "laws" else min(len(shown), 3))


@pytest.mark.parametrize("robot", get_args(RobotName))
def test_bins_of_every_arm(robot: RobotName) -> None:
    simulation, buffer = played("master_slave", robot=robot), RollingSeries()
    buffer.feed(simulation)
    own = simulation.avoiding.joints
    count = own.stop - own.start
    names = [f"q{i + 1}" for i in range(7)] + [f"dq{i + 1}" for i in range(7)]
    series = buffer.newest([COLUMNS[name] for name in names])
    sample = simulation.sample()
    newest = np.array([line[-1] for line in series[1:]])
    assert np.array_equal(newest[:count], sample.positions[own]) and np.array_equal(
        newest[7 : 7 + count], sample.velocities[own]
    )
    assert np.isnan(newest[count:7]).all()
    assert (
        len(time_plot_of("joints", simulation).legend())
        == len(time_plot_of("rates", simulation).legend())
        == count
    )
    for name in ("joints", "rates"):
        *joints, ghost = time_plot_of(name, simulation).legend(("ghost",))
        assert ghost == ("", "mix", "ghost") and "mix" not in {dash for _, dash, _ in joints}
    desired = [line[-1] for line in buffer.newest([COLUMNS[f"qd{i + 1}"] for i in range(4)])[1:]]
    assert desired == sample.desired[own][:4].tolist()


def test_bins_of_a_single_arm_have_an_elbow_and_no_distance() -> None:
    buffer = RollingSeries()
    buffer.feed(played("solo"))
    _, distance, elbow, error = buffer.newest([COLUMNS["d"], COLUMNS["elbow"], COLUMNS["e"]])
    assert np.isinf(distance).all() and np.isfinite(elbow).all() and np.ptp(elbow) > 0.05
    assert error[-1] == pytest.approx(played("solo").sample().error, rel=0.5)


def test_changes_of_the_closest_pair_are_counted_once() -> None:
    settings = RunSettings(scene="ball", point="arm")
    simulation, buffer = Simulation(settings), RollingSeries()
    for step in range(3400):
        simulation.step(None)
        if step % 13 == 0:
            buffer.feed(simulation)
    buffer.feed(simulation)
    pairs = simulation.history.table()[:, COLUMN["pair"]]
    assert int(buffer.newest([COLUMNS["changes"]])[1][-1]) == np.count_nonzero(np.diff(pairs)) > 2


@given(st.lists(st.sampled_from([0.3, 1.0, math.nan, math.inf]), min_size=2, max_size=12), st.booleans())
def test_a_drawable_line_begins_with_a_known_value(values: list[float], follows: bool) -> None:
    line = np.array(values)
    before = line.copy()
    drawn = drawable(line, follows)
    assert np.array_equal(line, before, equal_nan=True)
    known = np.isfinite(line) if follows else ~np.isnan(line)
    assert len(drawn) == (len(line) if known.any() else 0)
    if len(drawn):
        assert np.array_equal(drawn[known], line[known])
        first = int(known.argmax())
        assert np.array_equal(drawn[first:], line[first:], equal_nan=True)
        assert (drawn[:first] == line[first]).all() if follows else np.isnan(drawn[:first]).all()


@pytest.mark.parametrize("late", [0, 700])
def test_a_ghost_uses_the_bins_of_the_run(late: int) -> None:
    simulation = Simulation(RunSettings())
    person = simulation.source()
    for _ in range(late):
        simulation.step(person.target(simulation.time))
    ghost = Simulation(simulation.settings)
    ghost.resume(simulation.snapshot())
    for _ in range(900):
        for run in (simulation, ghost):
            run.step(person.target(run.time))
    own, other = RollingSeries(), RollingSeries()
    own.feed(simulation)
    other.feed(ghost)
    columns = [COLUMNS["d"], COLUMNS["e2"]]
    numbers = own.bins.numbers
    mine = own.bins.at(numbers, columns)
    times, beside = own.bins.ends(numbers), other.bins.at(numbers, columns, mine)
    there = times > late * 0.005 + WINDOW / POINTS
    assert np.array_equal(mine[:, :, there], beside[:, :, there], equal_nan=True)
    before = times < late * 0.005 - 1e-6
    assert np.array_equal(mine[:, :, before], beside[:, :, before], equal_nan=True)
    assert np.array_equal(RollingSeries().bins.at(numbers, columns, mine), mine, equal_nan=True)
    # A ghost with a newest bin far in the past is not shown.
    for _ in range(4400):
        simulation.step(None)
    own.feed(simulation)
    late_numbers = own.bins.numbers
    assert np.isnan(other.bins.at(late_numbers, columns, own.bins.at(late_numbers, columns))).all()


@pytest.mark.parametrize(("dt", "batch", "seconds"), [(0.005, 7, 31.0), (0.00125, 50, 8.0), (0.02, 40, 47.0)])
def test_bins_keep_every_dip(dt: float, batch: int, seconds: float) -> None:
    settings = RunSettings(dt=dt)
    simulation, buffer = Simulation(settings, 100_000), RollingSeries()
    person = Autopilot(simulation.room, settings.guided, settings.seed)
    for step in range(round(seconds / dt)):
        simulation.step(person.target(simulation.time))
        if step % batch == 0:
            buffer.feed(simulation)
    buffer.feed(simulation)
    table = simulation.history.table()
    numbers = buffer.bins.numbers
    # Bins cover the last 20 s; the oldest one may begin slightly later.
    width = WINDOW / POINTS
    times = buffer.bins.ends(numbers)
    assert len(times) == min(POINTS, math.ceil(seconds / width))
    assert (np.diff(times) > 0.0).all() and times[-1] == table[-1, 0]
    assert times[-1] - times[0] <= WINDOW
    stats = np.moveaxis(buffer.bins.at(numbers, list(range(len(NAMES)))), 2, 0)
    of_rows, dq = (
        bin_numbers(table[:, 0]),
        simulation.history.velocities(table)[:, simulation.avoiding.joints],
    )
    for number, b, end in zip(numbers.tolist(), stats, times.tolist(), strict=True):
        rows = of_rows == number
        for name, values in (
            ("d", table[rows, COLUMN["d"]]),
            ("e2", table[rows, COLUMN["e2"]]),
            ("dq3", dq[rows, 2]),
        ):
            assert (b[LOW, COLUMNS[name]], b[HIGH, COLUMNS[name]]) == (values.min(), values.max())
        assert end == table[rows, 0][-1]
    assert (stats[:, [LOW, HIGH], COLUMNS["d_m"]] == settings.law.critical_distance).all()
    assert np.nanmin(stats[:, LOW, COLUMNS["d*"]]) > 0.0


@pytest.mark.parametrize("steps", [30, 80, 400])
@pytest.mark.parametrize("scene", ["hold", "ball"])
def test_a_restarted_run_begins_with_empty_bins(scene: str, steps: int) -> None:
    simulation, buffer = Simulation(RunSettings()), RollingSeries()
    assert not len(buffer.newest([COLUMNS["d"]])[1])
    person = simulation.source()
    for _ in range(80):
        simulation.step(person.target(simulation.time))
    buffer.feed(simulation)
    assert buffer.newest([COLUMNS["d"]])[0][-1] == pytest.approx(0.395)
    if scene == "hold":
        start = simulation.room.start.copy()
        start[simulation.guided.joints.start] += 0.1
        simulation.reset(start)
    else:
        simulation.apply(RunSettings(scene=scene))
    for _ in range(steps):
        simulation.step(None)
    buffer.feed(simulation)
    fresh = RollingSeries()
    fresh.feed(simulation)
    columns = [COLUMNS["d"], COLUMNS["q1"], COLUMNS["changes"]]
    for here, there in zip(buffer.newest(columns), fresh.newest(columns), strict=True):
        assert np.array_equal(here, there)


TOLERANCE = 0.02

runs = st.tuples(
    st.integers(0, 2**32 - 1),
    st.sampled_from([0.00125, 0.005, 0.02]),
    st.integers(1, 3),
    st.integers(2, 4000),
    st.integers(1, 70),
)
"""Seed, time step, number of signals, number of steps, and steps per batch."""


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
        # The line within the bin, from its entry on.
        here = (xs > before) & (xs <= end)
        edges = [np.interp(x, xs, line) for x in (max(before, xs[0]), end) for line in lines.T]
        for column, line in enumerate(lines.T):
            reached = np.concatenate([line[here], edges[column::columns]])
            assert reached.max() >= inside[:, column].max() - 2.0 * TOLERANCE
            assert reached.min() <= inside[:, column].min() + 2.0 * TOLERANCE
            # The line does not exceed the data.
            if here.any():
                assert line[here].max() <= max(inside[:, column].max(), came_from[column]) + 2.0 * TOLERANCE
        before = end


@given(runs, st.integers(1, 3999), st.floats(0.1, 2.0), st.booleans())
def test_a_single_step_is_drawn_as_an_edge(
    run: tuple[int, float, int, int, int], at: int, size: float, spike: bool
) -> None:
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


def test_a_straight_line_needs_few_points_and_a_slope_is_not_a_step() -> None:
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


def test_missing_values_stay_missing_and_the_ring_drops_old_ones() -> None:
    times: Array = np.linspace(0.0, 3.99, 400)
    values = np.column_stack([times, np.full(400, np.nan), np.full(400, np.inf)])
    values[100:, 1] = 1.0
    bins = binned(times, values, 10)
    _, lines = drawn(bins, [0, 1, 2])
    assert np.isnan(lines[0, 1]) and lines[-1, 1] == 1.0 and np.isinf(lines[:, 2]).all()
    assert bins.at(np.array([0]), [1])[LAST, 0, 0] != 1.0
    # After a long pause only the new value remains.
    bins.take(np.array([4.0 + 2.0 * WINDOW]), np.array([[7.0, 8.0, 9.0]]))
    assert len(bins.numbers) == 1 and bins.at(bins.numbers, [0])[[LOW, HIGH, AT_HIGH], 0, 0].tolist() == [
        7.0,
        7.0,
        44.0,
    ]
