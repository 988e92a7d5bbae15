"""The time plots: columns and colours of every experiment, the bins of a run, and the ghost's bins beside the run's."""

import math
import re
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.custom_law.custom_law import CustomLaw
from app.plots.bins import HIGH, LOW, POINTS, WINDOW, bin_numbers
from app.plots.plot_choice import CHARTS, cells, layout_html, possible_details
from app.plots.time_plots import colour_of, time_plot_of
from app.plots.time_series import COLUMNS, NAMES, RollingSeries, drawable
from app.theme import PALETTES
from scenes.autopilot import Autopilot
from scenes.history import COLUMN
from scenes.settings import RobotName, RunSettings, SceneName
from scenes.simulation import Simulation
from tests.app.plots.helpers import DETAILS, SCENES, ShownPanel, played


@pytest.mark.parametrize("scene", SCENES)
def test_every_plot_of_every_experiment_has_columns_and_colours(scene: SceneName) -> None:
    simulation = played(scene)
    for details in DETAILS:
        shown = cells(simulation.settings, details)
        assert len(set(shown)) == len(shown) <= 4
        assert shown[:2] == (("hand", "elbow") if scene == "solo" else ("distance", "error"))
        assert details == "none" or (details in shown) == (details in possible_details(simulation.settings))
        for name in shown:
            if name in CHARTS:
                continue
            plot = time_plot_of(name, simulation)
            assert {line.run for line in plot.lines} <= {"own", "ghost", "what_if"}
            for line in plot.lines:
                assert line.column in COLUMNS
                for palette in PALETTES.values():
                    assert re.fullmatch(r"#[0-9a-f]{6}", colour_of(line, palette))
            # Not two lines of one colour without another cue.
            own = [(line.colour, line.dash) for line in plot.lines if line.run == "own"]
            assert len(set(own)) == len(own)
    unit = time_plot_of("error", simulation).unit
    assert unit == ("rad²" if scene in ("master_slave", "imitation") else "m²")


@pytest.mark.parametrize("name", ["distance", "error", "joints", "rates", "follow"])
def test_a_plot_has_the_same_lines_in_every_experiment(name: str) -> None:
    """The page would make one with other lines again, in the moment in which its data change too."""
    settings = [RunSettings(scene=scene) for scene in ("hold", "master_slave", "imitation")]
    settings += [RunSettings(scene="imitation", avoid="both"), RunSettings(scene="master_slave", robot=get_args(RobotName)[-1])]
    lines = {tuple(line.column for line in time_plot_of(name, Simulation(s)).lines) for s in settings}
    assert len(lines) == 1


def test_a_law_of_ones_own_has_no_resting_distance(tmp_path: Path) -> None:
    path = tmp_path / "my_law.py"
    path.write_text("def law(s):\n    return s.nominal", encoding="utf-8")
    shown = ShownPanel("hold")
    assert len(shown.show(0.5)[0].data[3]) and shown.says("d*")
    with CustomLaw(path) as law:
        shown.session.simulation.use(law)
        shown.session.reset()
        shown.show(0.5)
    assert not len(shown.gui.plots[0].data[3]) and not shown.says("d*")


def test_a_column_for_every_plot() -> None:
    for shown in (("distance", "error"), ("distance", "error", "laws"), ("distance", "error", "follow", "follow_other")):
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
    assert np.array_equal(newest[:count], sample.positions[own]) and np.array_equal(newest[7 : 7 + count], sample.velocities[own])
    assert np.isnan(newest[count:7]).all()
    assert len(time_plot_of("joints", simulation).legend()) == len(time_plot_of("rates", simulation).legend()) == count
    desired = [line[-1] for line in buffer.newest([COLUMNS[f"qd{i + 1}"] for i in range(4)])[1:]]
    assert desired == sample.desired[own][:4].tolist()


def test_bins_of_an_arm_alone_have_an_elbow_and_no_distance() -> None:
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
def test_a_line_is_drawable(values: list[float], follows: bool) -> None:
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
def test_a_ghost_lies_at_the_bins_of_the_run(late: int) -> None:
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
    # Of a ghost whose newest bin is far away nothing is shown.
    for _ in range(4400):
        simulation.step(None)
    own.feed(simulation)
    late_numbers = own.bins.numbers
    assert np.isnan(other.bins.at(late_numbers, columns, own.bins.at(late_numbers, columns))).all()


@pytest.mark.parametrize(("dt", "batch", "seconds"), [(0.005, 7, 31.0), (0.00125, 50, 8.0), (0.02, 1, 47.0), (0.02, 40, 47.0)])
def test_bins_lose_no_dip(dt: float, batch: int, seconds: float) -> None:
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
    # Bins cover the last 20 s; the oldest of them may begin a little later than the newest step minus 20 s.
    width = WINDOW / POINTS
    times = buffer.bins.ends(numbers)
    assert len(times) == min(POINTS, math.ceil(seconds / width))
    assert (np.diff(times) > 0.0).all() and times[-1] == table[-1, 0]
    assert times[-1] - times[0] <= WINDOW
    stats = np.moveaxis(buffer.bins.at(numbers, list(range(len(NAMES)))), 2, 0)
    of_rows, dq = bin_numbers(table[:, 0]), simulation.history.velocities(table)[:, simulation.avoiding.joints]
    for number, b, end in zip(numbers.tolist(), stats, times.tolist(), strict=True):
        rows = of_rows == number
        for name, values in (("d", table[rows, COLUMN["d"]]), ("e2", table[rows, COLUMN["e2"]]), ("dq3", dq[rows, 2])):
            assert (b[LOW, COLUMNS[name]], b[HIGH, COLUMNS[name]]) == (values.min(), values.max())
        assert end == table[rows, 0][-1]
    assert (stats[:, [LOW, HIGH], COLUMNS["d_m"]] == settings.law.critical_distance).all()
    assert np.nanmin(stats[:, LOW, COLUMNS["d*"]]) > 0.0


@pytest.mark.parametrize("steps", [30, 80, 400])
@pytest.mark.parametrize("scene", ["hold", "ball"])
def test_a_restarted_run_begins_with_empty_bins(scene: SceneName, steps: int) -> None:
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
