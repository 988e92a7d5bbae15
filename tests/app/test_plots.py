"""The panel of plots: the ghost's bins beside the run's, what if, lines in a chart, all laws, pairs, and what is sent."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, cast, get_args

import numpy as np
import pytest
import viser
from hypothesis import given
from hypothesis import strategies as st

from app.own_law.own_law import OwnLaw
from app.page.bins import COLUMNS, POINTS, WINDOW, Curve, PlotBuffer, drawable
from app.page.chart import Chart, Frame
from app.page.contact import contact
from app.page.courses import colour_of, course_of
from app.page.curve import FAR, FRAME, curve_html, distances
from app.page.details import CHARTS, cells, layout_html, possible_details
from app.page.laws import LAW_NAMES, all_laws, laws_html
from app.page.pairs import pairs_html
from app.page.plots import CURTAIN, Plots
from app.page.theme import PALETTES
from app.session import Session
from app.settings import Details, PageSettings, Settings
from scenes.history import COLUMN
from scenes.rerun import WhatIf
from scenes.settings import LawName, LawSettings, RobotName, RunSettings, SceneName
from scenes.simulation import Simulation

SCENES: tuple[SceneName, ...] = get_args(SceneName)
LAWS: tuple[LawName, ...] = get_args(LawName)
DETAILS: tuple[Details, ...] = get_args(Details)


@cache
def played(
    scene: SceneName = "hold", law: LawName = "smooth_priority", robot: RobotName = "lwr", seconds: float = 1.5
) -> Simulation:
    """An experiment that its own person has moved for a while; not to be moved on."""
    settings = RunSettings(scene=scene, robot=robot, law=LawSettings(law=law))
    simulation = Simulation(settings)
    person = simulation.person()
    while simulation.time < seconds:
        simulation.step(person.target(simulation.time))
    return simulation


def text(html: str) -> str:
    """What a person reads."""
    return re.sub(r"<[^>]+>", " ", html)


# --- bins ------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("robot", get_args(RobotName))
def test_bins_of_every_arm(robot: RobotName) -> None:
    simulation, buffer = played("master_slave", robot=robot), PlotBuffer()
    buffer.feed(simulation)
    own = simulation.avoiding.joints
    count = own.stop - own.start
    names = [f"q{i + 1}" for i in range(7)] + [f"dq{i + 1}" for i in range(7)]
    series = buffer.series(tuple(COLUMNS[name] for name in names))
    sample = simulation.sample()
    newest = np.array([line[-1] for line in series[1:]])
    assert np.array_equal(newest[:count], sample.positions[own]) and np.array_equal(newest[7 : 7 + count], sample.velocities[own])
    assert np.isnan(newest[count:7]).all()
    assert len(course_of("joints", simulation).legend) == len(course_of("rates", simulation).legend) == count
    desired = [line[-1] for line in buffer.series(tuple(COLUMNS[f"qd{i + 1}"] for i in range(4)))[1:]]
    assert desired == sample.desired[own][:4].tolist()


def test_bins_of_an_arm_alone_have_an_elbow_and_no_distance() -> None:
    buffer = PlotBuffer()
    buffer.feed(played("solo"))
    _, distance, elbow, error = buffer.series((COLUMNS["d"], COLUMNS["elbow"], COLUMNS["e"]))
    assert np.isinf(distance).all() and np.isfinite(elbow).all() and np.ptp(elbow) > 0.05
    assert error[-1] == pytest.approx(played("solo").sample().error, rel=0.5)


def test_changes_of_the_closest_pair_are_counted_once() -> None:
    settings = RunSettings(scene="ball", point="arm")
    simulation, buffer = Simulation(settings), PlotBuffer()
    for step in range(3400):
        simulation.step(None)
        if step % 13 == 0:
            buffer.feed(simulation)
    buffer.feed(simulation)
    pairs = simulation.history.table()[:, COLUMN["pair"]]
    assert int(np.nansum(buffer.series((COLUMNS["changes"],))[1])) == np.count_nonzero(np.diff(pairs)) > 2


def test_another_room_begins_with_empty_bins() -> None:
    """Even if as many steps were made there meanwhile as were seen here."""
    simulation, buffer = Simulation(RunSettings()), PlotBuffer()
    for _ in range(50):
        simulation.step(None)
    buffer.feed(simulation)
    simulation.apply(RunSettings(scene="ball"))
    for _ in range(80):
        simulation.step(None)
    buffer.feed(simulation)
    times, distance = buffer.series((COLUMNS["d"],))
    table = simulation.history.table()
    assert times[0] == pytest.approx(0.12) and distance.max() <= table[:, COLUMN["d"]].max()


@pytest.mark.parametrize("steps", [30, 80, 400])
def test_a_run_that_begins_anew_begins_with_empty_bins(steps: int) -> None:
    """Also if it was not looked at until it had as many steps as before, or more: no time of the old run stays on the axis."""
    simulation, buffer = Simulation(RunSettings()), PlotBuffer()
    person = simulation.person()
    for _ in range(80):
        simulation.step(person.target(simulation.time))
    buffer.feed(simulation)
    assert buffer.series((COLUMNS["d"],))[0][-1] == pytest.approx(0.395)
    start = simulation.room.start.copy()
    start[simulation.guided.joints.start] += 0.1
    simulation.reset(start)
    for _ in range(steps):
        simulation.step(None)
    buffer.feed(simulation)
    fresh = PlotBuffer()
    fresh.feed(simulation)
    columns = (COLUMNS["d"], COLUMNS["q1"], COLUMNS["changes"])
    for here, there in zip(buffer.series(columns), fresh.series(columns), strict=True):
        assert np.array_equal(here, there)


@given(st.lists(st.sampled_from([0.3, 1.0, math.nan, math.inf]), min_size=2, max_size=12), st.booleans())
def test_a_line_is_drawable(values: list[float], follows: bool) -> None:
    """Where the axis follows the data, the first value of every line that is there is a number; nothing that is known is changed."""
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
    """The same run, begun later: the same values where both have some, and before that the run's, which it was."""
    simulation = Simulation(RunSettings())
    person = simulation.person()
    for _ in range(late):
        simulation.step(person.target(simulation.time))
    ghost = Simulation(simulation.settings)
    ghost.resume(simulation.snapshot())
    for _ in range(900):
        for run in (simulation, ghost):
            run.step(person.target(run.time))
    own, other = PlotBuffer(), PlotBuffer()
    own.feed(simulation)
    other.feed(ghost)
    columns = (COLUMNS["d"], COLUMNS["e2"])
    times, *lines = own.series(columns)
    for line, beside in zip(lines, other.beside(own, columns), strict=True):
        assert len(beside) == len(times)
        there = times > late * 0.005 + WINDOW / POINTS
        assert np.array_equal(line[there], beside[there])
        before = times < late * 0.005 - 1e-6
        assert np.array_equal(line[before], beside[before])
    # One that has not made a step yet.
    assert np.array_equal(PlotBuffer().beside(own, columns), lines)
    # Of a ghost whose newest bin is far away nothing is shown.
    for _ in range(4400):
        simulation.step(None)
    own.feed(simulation)
    assert np.isnan(other.beside(own, columns)[0]).all()


@given(st.lists(st.floats(0.0, 30.0), min_size=1, max_size=60, unique=True), st.booleans())
def test_another_curve_keeps_the_extremes_of_its_bins(times: list[float], smallest: bool) -> None:
    stamps = np.sort(np.array(times))
    values = np.sin(97.0 * stamps)
    curve = Curve(stamps, values, smallest)
    numbers = (stamps * (POINTS / WINDOW)).astype(int)
    for number, value in zip(curve.numbers, curve.values, strict=True):
        inside = values[numbers == number]
        assert value == (inside.min() if smallest else inside.max())
    buffer = PlotBuffer()
    simulation = played(seconds=3.0)
    buffer.feed(simulation)
    times_shown, own = buffer.series((COLUMNS["d"],))
    found, shown = buffer.along(curve, COLUMNS["d"]), (times_shown * (POINTS / WINDOW)).astype(int)
    assert len(found) == len(shown)
    for number, value, before in zip(shown.tolist(), found.tolist(), own.tolist(), strict=True):
        inside = values[numbers == number]
        if len(inside):
            assert value == (inside.min() if smallest else inside.max())
        else:
            # What was before the curve was the run itself.
            assert value == before if number < numbers[0] else math.isnan(value)


# --- courses ---------------------------------------------------------------------------------------------------------------------


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
            course = course_of(name, simulation)
            assert {line.run for line in course.lines} <= {"own", "ghost", "what_if"}
            for line in course.lines:
                assert line.column in COLUMNS
                for palette in PALETTES.values():
                    assert re.fullmatch(r"#[0-9a-f]{6}", colour_of(line, palette))
            # Not two lines of one colour without another cue.
            own = [(line.colour, line.dash) for line in course.lines if line.run == "own"]
            assert len(set(own)) == len(own)
    unit = course_of("error", simulation).unit
    assert unit == ("rad²" if scene in ("master_slave", "imitation") else "m²")


@pytest.mark.parametrize("name", ["distance", "error", "joints", "rates", "follow"])
def test_a_plot_has_the_same_lines_in_every_experiment(name: str) -> None:
    """The page would make one with other lines anew, in the moment in which its data change too."""
    settings = [RunSettings(scene=scene) for scene in ("hold", "master_slave", "imitation")]
    settings += [RunSettings(scene="imitation", avoid="both"), RunSettings(scene="master_slave", robot=get_args(RobotName)[-1])]
    lines = {tuple(line.column for line in course_of(name, Simulation(s)).lines) for s in settings}
    assert len(lines) == 1


def test_a_law_of_ones_own_has_no_resting_distance(tmp_path: Path) -> None:
    """Neither its line nor its name, from the moment on in which it runs, whatever the settings' law is."""
    path = tmp_path / "my_law.py"
    path.write_text("def law(s):\n    return s.nominal", encoding="utf-8")
    session = session_of("hold", "none")
    plots, gui = panel(session)
    go_on(session, 0.5)
    plots.show(session, 0.0)
    assert len(gui.plots[0].data[3]) and any("d*" in block.content for block in gui.blocks)
    with OwnLaw(path) as law:
        session.simulation.use(law)
        session.reset()
        go_on(session, 0.5)
        plots.show(session, 1.0)
    assert not len(gui.plots[0].data[3]) and not any("d*" in block.content for block in gui.blocks)


def test_a_column_for_every_plot() -> None:
    for shown in (("distance", "error"), ("distance", "error", "laws"), ("distance", "error", "follow", "follow_other")):
        wide, narrow = re.findall(r"--duet-\w+:([^;}]*)", layout_html(shown))
        assert wide.count("minmax") == len(shown)
        assert narrow.count("minmax") == (2 if shown[-1] == "laws" else min(len(shown), 3))


# --- charts ----------------------------------------------------------------------------------------------------------------------


def paths(html: str, kind: str) -> list[np.ndarray]:
    """The points of the lines of a kind, in thousandths of the chart's width and height."""
    return [
        np.array([[float(v) for v in point.split()] for point in re.findall(r"(-?\d+ -?\d+)", d)])
        for d in re.findall(rf'<path class="{kind}" d="M([^"]*)"', html)
    ]


def marks(html: str, kind: str) -> list[tuple[float, float]]:
    """Where the marks of a kind are, in shares of the chart's width and height."""
    found = re.findall(rf'<b class="{kind}" style="left:([\d.]+)%;top:([\d.]+)%">', html)
    return [(float(x) / 100.0, float(y) / 100.0) for x, y in found]


@given(st.lists(st.floats(-2.0, 2.0), min_size=2, max_size=60), st.floats(0.2, 3.0))
def test_a_line_with_fewer_points_is_the_same_line(values: list[float], span: float) -> None:
    frame = Frame((0.0, 1.0), (-span, span), (), ())
    chart, xs = Chart(frame), np.linspace(0.0, 1.0, len(values))
    ys = np.array(values)
    chart.line(xs, ys, "lam", 1.0)
    (points,) = paths(chart.html(100), "lam")
    assert (np.diff(points[:, 0]) >= 0).all() and points[0, 0] == 0.0 and points[-1, 0] == 1000.0
    drawn = np.interp(1000.0 * xs, points[:, 0], points[:, 1])
    meant = 1000.0 * np.clip((span - ys) / (2.0 * span), -1.0, 2.0)
    # In thousandths: rounding of two ends, and what is left out; steeper lines leave more room for the rounding of x.
    slope = np.abs(np.diff(meant)).max(initial=0.0) * len(values) / 1000.0
    assert np.abs(drawn - meant).max() <= 1.5 + 1.5 * slope


@given(st.floats(0.03, 0.3), st.floats(1.0, 20.0), st.sampled_from(LAWS), st.floats(0.04, 0.59))
def test_the_dot_is_on_the_curve_of_fig_2(d_m: float, order: float, name: LawName, distance: float) -> None:
    simulation = played()
    law = LawSettings(law=name, critical_distance=d_m, order=order)
    shown = cast(Simulation, _Shown(replace(simulation.settings, law=law), all_laws(law)[name]))
    sample = replace(simulation.sample(), law_distance=distance, activation=shown.law.activation(distance))
    html = curve_html(shown, None, sample, 150)
    ((x, y),) = marks(html, "dot lam")
    assert x == pytest.approx(distance / FAR, abs=6e-4) and y == pytest.approx(FRAME.down(sample.activation), abs=6e-4)
    (line,) = paths(html, "lam")
    # Across a jump either end will do; the curve is drawn with straight pieces.
    near = np.interp(1000.0 * x + np.array([-4.0, 0.0, 4.0]), line[:, 0], line[:, 1])
    assert near.min() - 12.0 <= 1000.0 * y <= near.max() + 12.0
    assert len(paths(html, "faint")) == 3 and text(html).count("n = ") == 3
    assert len(paths(curve_html(shown, shown, sample, 150), "ghost")) == 1


@dataclass
class _Shown:
    """What the charts read of a simulation."""

    settings: RunSettings
    law: Any


def test_distances_to_draw_at_include_both_sides_of_every_kink() -> None:
    xs = distances(0.15, 0.3)
    assert (np.diff(xs) > 0.0).all() and xs[0] == 0.0 and xs[-1] == FAR
    for kink in (0.15, 0.3):
        assert {kink - 1e-6, kink, kink + 1e-6} <= set(xs.tolist())


@pytest.mark.parametrize("name", LAWS)
def test_all_laws_are_compared_at_the_present_pull(name: LawName) -> None:
    simulation = played("hold", name, seconds=4.0)
    sample = simulation.sample()
    now = contact(simulation, sample)
    html = laws_html(simulation, None, now, 150)
    lines: dict[LawName, list[np.ndarray]] = {law: paths(html, f"law{i + 1}") for i, law in enumerate(LAW_NAMES)}
    assert all(len(found) == 1 for found in lines.values())
    # Thick is the present one, and it is drawn last.
    widths = re.findall(r'<path class="law(\d)" d="[^"]*" stroke-width="([\d.]+)"', html)
    assert widths[-1] == (str(list(LAW_NAMES).index(name) + 1), "3.2") and {w for _, w in widths[:-1]} == {"1.5"}
    # A line goes through what its law says.
    labels = [float(v.replace("−", "-")) for v in re.findall(r'class="ys">.*?<i style="top:0.0%">([^<]*)<', html)]
    labels = labels or [float(v.replace("−", "-")) for v in re.findall(r'<i style="top:0.0%">([^<]*)</i>', html)]
    span = labels[0]
    for law, (points,) in lines.items():
        for d in (0.05, 0.22, 0.5):
            rate = all_laws(simulation.settings.law)[law].line_rate(d, now.pull, now.approach, now.square)
            meant = 1000.0 * min(max((span - rate) / (2.0 * span), -1.0), 2.0)
            assert np.interp(1000.0 * d / FAR, points[:, 0], points[:, 1]) == pytest.approx(meant, abs=12.0), (law, d)
    kind = f"law{list(LAW_NAMES).index(name) + 1}"
    ((x, y),) = marks(html, f"dot {kind}")
    assert x == pytest.approx(min(now.distance / FAR, 1.0), abs=1e-3)
    assert y == pytest.approx(min(max((span - now.rate) / (2.0 * span), 0.0), 1.0), abs=1e-3)
    # Numbers on the lines, and the same in the legend.
    assert [len(marks(html, f"digit law{i + 1}")) for i in range(8)] == [1] * 8
    assert re.findall(r"<li[^>]*><i[^>]*>(\d)</i>(?:<b>)?([^<]*)", html) == [
        (str(i + 1), v) for i, v in enumerate(LAW_NAMES.values())
    ]
    assert f"<b>{LAW_NAMES[name]}</b>" in html


def test_the_ghost_of_all_laws_is_dashed() -> None:
    simulation, ghost = played("hold"), played("hold", "barrier_qp")
    html = laws_html(simulation, ghost, contact(simulation, simulation.sample()), 150)
    assert re.findall(r'<path class="law(\d)"[^>]*stroke-dasharray', html) == ["6"] and "ghost" in text(html)


def test_the_axis_of_speeds_does_not_breathe() -> None:
    """A pull that comes and goes within what v asks for anyway leaves the axis as it is."""
    simulation = played("hold")
    now = contact(simulation, simulation.sample())
    axes = set[str]()
    for pull in (-0.2, 0.0, 0.1, 0.29):
        html = laws_html(simulation, None, now._replace(pull=pull), 150)
        axes.add(re.findall(r'class="ys">(.*?)</div>', html)[0])
    assert len(axes) == 1


# --- pairs -----------------------------------------------------------------------------------------------------------------------


def test_the_strips_show_who_was_closest_when() -> None:
    simulation, buffer = Simulation(RunSettings(scene="ball", point="arm")), PlotBuffer()
    for _ in range(2400):
        simulation.step(None)
    buffer.feed(simulation)
    html = pairs_html(simulation, buffer)
    _, pairs = buffer.series((COLUMNS["pair"],))
    shown = np.full(len(pairs), -1.0)
    order = sorted({int(pair) for pair in pairs})
    strips = re.findall(r'<path d="([^"]*)"/>', html)
    assert len(strips) == len(order) > 1
    for pair, strip in zip(order, strips, strict=True):
        for start, length in re.findall(r"M(\d+) 0h(\d+)v1", strip):
            assert (shown[int(start) : int(start) + int(length)] == -1.0).all()
            shown[int(start) : int(start) + int(length)] = pair
    assert np.array_equal(shown, pairs)
    assert "hand · ball" in text(html) and html.count('class="now"') == 1
    changes = np.count_nonzero(np.diff(simulation.history.table()[:, COLUMN["pair"]]))
    assert f"{changes} changes among {len(order)} pairs." in text(html)


def test_one_pair_never_changes() -> None:
    buffer = PlotBuffer()
    buffer.feed(played("ball"))
    assert "never changes" in pairs_html(played("ball"), buffer)
    assert "<path" not in pairs_html(played("ball"), PlotBuffer())


# --- the panel ---------------------------------------------------------------------------------------------------------------------


@dataclass
class Handle:
    """What a plot or a block was told, in order."""

    told: list[tuple[str, Any]] = field(default_factory=list)

    def __setattr__(self, name: str, value: Any) -> None:
        if name != "told":
            self.told.append((name, value))
        object.__setattr__(self, name, value)


@dataclass
class Gui:
    """Makes blocks and plots."""

    blocks: list[Any] = field(default_factory=list)
    plots: list[Any] = field(default_factory=list)

    def add_html(self, content: str, **options: Any) -> Any:
        """A block."""
        handle = Handle()
        handle.content, handle.visible, handle.order = content, True, options["order"]
        self.blocks.append(handle)
        return handle

    def add_uplot(self, **options: Any) -> Any:
        """A plot; viser asks for arrays of one length here."""
        assert len(options["data"]) == len(options["series"]) and len({len(line) for line in options["data"]}) == 1
        handle = Handle()
        for name, value in options.items():
            setattr(handle, name, value)
        handle.visible = True
        self.plots.append(handle)
        return handle


class Tab:
    """A place."""

    def __enter__(self) -> None:
        """Nothing to do."""

    def __exit__(self, *_: object) -> None:
        """Nothing to do."""


def panel(session: Session) -> tuple[Plots, Gui]:
    """The panel of a session, without a browser."""
    gui = Gui()
    page = session.settings.page
    return Plots(cast(viser.GuiApi, gui), cast(viser.GuiTabHandle, Tab()), page, 150), gui


def session_of(scene: SceneName, details: Details, **page: Any) -> Session:
    """A session without a clock."""
    return Session(Settings(RunSettings(scene=scene), PageSettings(details=details, **page)))


def go_on(session: Session, seconds: float) -> None:
    """Simulate, whatever the time of day is."""
    until = session.simulation.time + seconds
    while session.simulation.time < until:
        session.advance(0.02)


@pytest.mark.parametrize("scene", SCENES)
def test_everything_can_be_shown_in_every_experiment(scene: SceneName) -> None:
    session = session_of(scene, "none", ghost="unprotected")
    plots, gui = panel(session)
    go_on(session, 0.4)
    for i, details in enumerate(DETAILS):
        plots.choose(details)
        go_on(session, 0.05)
        plots.show(session, 1.0 * i)
        shown = cells(session.settings.run, details)
        visible = [plot for plot in gui.plots if plot.visible]
        assert len(visible) == len([name for name in shown if name not in CHARTS])
        for plot in visible:
            assert len(plot.data) == len(plot.series)
            assert {len(line) for line in plot.data} <= {len(plot.data[0]), 0} and len(plot.data[0]) <= 200
            newest = session.simulation.sample().time
            assert plot.data[0][-1] == pytest.approx(newest)
        captions = [block for block in gui.blocks if block.visible and "duet-title" in block.content]
        assert len(captions) == len(shown)
        # On a phone each caption stands right above its plot.
        orders = sorted([block.order for block in captions] + [plot.order for plot in visible])
        assert len(set(orders)) == len(orders)


def test_what_is_hidden_is_told_nothing() -> None:
    session = session_of("hold", "lambda")
    plots, gui = panel(session)
    for i in range(3):
        go_on(session, 0.2)
        plots.show(session, 1.0 * i)
    third = gui.plots[2]
    plots.choose("laws")
    plots.show(session, 3.0)
    assert third.visible is False
    told = len(third.told)
    chart = next(block for block in gui.blocks if "duet-laws" in block.content)
    plots.choose("none")
    plots.show(session, 4.0)
    after = len(chart.told)
    for i in range(5, 9):
        go_on(session, 0.2)
        plots.show(session, 1.0 * i)
    assert len(third.told) == told and len(chart.told) == after and chart.visible is False


def test_ten_refreshes_a_second_at_most() -> None:
    session = session_of("master_slave", "joints")
    plots, gui = panel(session)
    for frame in range(90):
        go_on(session, 0.03)
        plots.show(session, frame / 30.0)
    refreshes = [sum(name == "data" for name, _ in plot.told) for plot in gui.plots]
    assert all(count <= 3.0 * 10.0 + 2 for count in refreshes) and min(refreshes) >= 10
    # Nothing new, nothing sent.
    plots.show(session, 9.0)
    before = [len(plot.told) for plot in gui.plots]
    plots.show(session, 10.0)
    assert [len(plot.told) for plot in gui.plots] == before


def test_a_ghost_costs_nothing_while_there_is_none() -> None:
    session = session_of("hold", "none")
    plots, gui = panel(session)
    go_on(session, 1.0)
    plots.show(session, 0.0)
    assert [len(line) for line in gui.plots[0].data[4:]] == [0, 0]
    series = list(gui.plots[0].told)
    session.change("ghost", "unprotected")
    go_on(session, 1.0)
    plots.show(session, 1.0)
    ghost = gui.plots[0].data[4]
    # It was the run itself until then. Without a first value the page would find no range for the axis.
    own = gui.plots[0].data[1]
    assert np.isfinite(ghost).all() and (ghost[:7] == own[:7]).all()
    # The lines stay the ones that they were: a chart that is made anew would flicker.
    assert not any(name == "series" for name, _ in gui.plots[0].told[len(series) :])
    assert sum("ghost" in block.content for block in gui.blocks) == 2
    session.change("ghost", "off")
    plots.show(session, 2.0)
    assert len(gui.plots[0].data[4]) == 0 and not any("ghost" in block.content for block in gui.blocks)


def test_what_if_is_drawn_over_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    session = session_of("hold", "none")
    plots, gui = panel(session)
    go_on(session, 2.0)
    plots.show(session, 0.0)
    times = session.simulation.history.table()[:200, COLUMN["t"]]
    answer: WhatIf | None = cast(WhatIf, _Answer(times, np.full(200, 0.2), np.full(200, 0.01)))
    monkeypatch.setattr(Session, "what_if", property(lambda _: answer))
    plots.show(session, 1.0)
    for plot, value in zip(gui.plots, (0.2, 0.01), strict=True):
        line = plot.data[-1]
        inside = plot.data[0] < times[-1] - WINDOW / POINTS
        assert (line[inside] == value).all() and np.isnan(line[-1])
    assert sum("what if" in block.content for block in gui.blocks) == 2
    # The exact answer after the draft: other times, so that nothing can be compared element by element.
    answer = cast(WhatIf, _Answer(times[::2], np.full(100, 0.3), np.full(100, 0.02)))
    plots.show(session, 2.0)
    assert np.nanmax(gui.plots[0].data[-1]) == 0.3
    answer = None
    plots.show(session, 3.0)
    assert len(gui.plots[0].data[-1]) == 0 and not any("what if" in block.content for block in gui.blocks)


@dataclass
class _Answer:
    times: np.ndarray
    distance: np.ndarray
    squared_error: np.ndarray


def test_another_experiment_changes_lines_and_names() -> None:
    session = session_of("hold", "none")
    plots, gui = panel(session)
    go_on(session, 0.5)
    plots.show(session, 0.0)
    error = gui.plots[1]
    session.change("scene", "imitation")
    go_on(session, 0.5)
    plots.show(session, 1.0)
    assert len(error.series) == len(error.data) == 5 and any("[rad²]" in block.content for block in gui.blocks)
    session.change("scene", "solo")
    go_on(session, 0.5)
    plots.show(session, 2.0)
    assert [plot.visible for plot in gui.plots] == [False, False, True, True]
    session.change("scene", "ball")
    go_on(session, 0.5)
    plots.show(session, 3.0)
    assert [plot.visible for plot in gui.plots] == [True, True, False, False] and len(error.series) == 5
    assert sum(name == "series" for name, _ in error.told) == 1


def test_a_second_arm_that_begins_to_keep_clear_does_not_blank_the_plot() -> None:
    """Its error is a line that begins in the middle; and after a reset that waits, the axes are there all the same."""
    session = session_of("imitation", "none")
    session.change("avoid", "free")
    plots, gui = panel(session)
    go_on(session, 0.6)
    plots.show(session, 0.0)
    error = gui.plots[1]
    assert [len(line) for line in error.data[2:]] == [0, 0, 0]
    session.change("avoid", "both")
    go_on(session, 0.6)
    plots.show(session, 1.0)
    first, second = error.data[1:3]
    assert len(second) == len(first) and np.isfinite([first[0], second[0]]).all()
    session.paused = True
    session.reset()
    plots.show(session, 2.0)
    assert error.data[1][0] == 0.0 and np.isnan(error.data[1][1]) and [len(line) for line in error.data[2:]] == [0, 0, 0]


def test_another_theme_dresses_all_plots_anew() -> None:
    session = session_of("hold", "joints")
    plots, gui = panel(session)
    plots.show(session, 0.0)
    before = [plot.series[1]["stroke"] for plot in gui.plots]
    plots.dress(PageSettings(theme="dark", profile="projector"))
    after = [plot.series[1]["stroke"] for plot in gui.plots]
    assert all(a != b for a, b in zip(before, after, strict=True)) and len(after) == 3
    # What the page makes anew gets no data in that moment, and is begun afresh.
    told = [len(plot.told) for plot in gui.plots]
    go_on(session, 0.3)
    plots.show(session, 1.0)
    assert [plot.told[n:] for n, plot in zip(told, gui.plots, strict=True)] == [[("visible", False)]] * 3
    plots.show(session, 1.1)
    assert not any(plot.visible for plot in gui.plots)
    plots.show(session, 1.1 + CURTAIN)
    for plot in gui.plots:
        assert plot.visible and plot.told[-1][0] == "data"
