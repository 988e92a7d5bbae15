"""The charts beside the time plots: lines, the curve of Fig. 2, all laws, and the closest pairs."""

import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.plots.activation_curve import FAR, FRAME, curve_html, distances
from app.plots.chart import Chart, ChartAxes
from app.plots.laws_chart import LAW_NAMES, all_laws, laws_html
from app.plots.pair_strips import pairs_html
from app.plots.time_series import COLUMNS, RollingSeries
from app.session.contact import contact
from scenes.history import COLUMN
from scenes.settings import LawName, LawSettings, RunSettings
from scenes.simulation import Simulation
from tests.app.plots.helpers import LAWS, marks, paths, played, text


@given(st.lists(st.floats(-2.0, 2.0), min_size=2, max_size=60), st.floats(0.2, 3.0))
def test_a_line_with_fewer_points_is_the_same_line(values: list[float], span: float) -> None:
    frame = ChartAxes((0.0, 1.0), (-span, span), (), ())
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
    shown: Any = SimpleNamespace(settings=replace(simulation.settings, law=law), law=all_laws(law)[name])
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
    widths = re.findall(r'<path class="law(\d+)" d="[^"]*" stroke-width="([\d.]+)"', html)
    assert widths[-1] == (str(list(LAW_NAMES).index(name) + 1), "3.2") and {w for _, w in widths[:-1]} == {"1.5"}
    span = float(re.findall(r'<i style="top:0.0%">([^<]*)</i>', html)[0].replace("−", "-"))
    for law, (points,) in lines.items():
        for d in (0.05, 0.22, 0.5):
            rate = all_laws(simulation.settings.law)[law].line_rate(d, now.pull, now.approach, now.square)
            meant = 1000.0 * min(max((span - rate) / (2.0 * span), -1.0), 2.0)
            assert np.interp(1000.0 * d / FAR, points[:, 0], points[:, 1]) == pytest.approx(meant, abs=12.0), (law, d)
    kind = f"law{list(LAW_NAMES).index(name) + 1}"
    ((x, y),) = marks(html, f"dot {kind}")
    assert x == pytest.approx(min(now.distance / FAR, 1.0), abs=1e-3)
    assert y == pytest.approx(min(max((span - now.rate) / (2.0 * span), 0.0), 1.0), abs=1e-3)
    assert [len(marks(html, f"digit law{i + 1}")) for i in range(11)] == [1] * 11
    names = [(str(i + 1), v) for i, v in enumerate(LAW_NAMES.values())]
    assert re.findall(r"<li[^>]*><i[^>]*>(\d+)</i>(?:<b>)?([^<]*)", html) == names
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


def test_the_strips_show_who_was_closest_when() -> None:
    simulation, buffer = Simulation(RunSettings(scene="ball", point="arm")), RollingSeries()
    for _ in range(2400):
        simulation.step(None)
    buffer.feed(simulation)
    html = pairs_html(simulation, buffer)
    _, pairs = buffer.newest([COLUMNS["pair"]])
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
    buffer = RollingSeries()
    buffer.feed(played("ball"))
    assert "never changes" in pairs_html(played("ball"), buffer)
    assert "<path" not in pairs_html(played("ball"), RollingSeries())
