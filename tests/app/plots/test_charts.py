"""The charts: lines, Fig. 2, all laws, the closest pairs, and stability."""

import math
import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.i18n.speaking import set_language
from app.plots.chart import Chart, ChartAxes, ticks_of
from app.plots.drawing_axes import activation_axes, axes_text, board_svg
from app.plots.lap_charts import laps_html
from app.plots.law_charts import FAR, FRAME, all_laws, curve_html, distances, laws_html, laws_legend
from app.plots.pair_strips import pairs_html
from app.plots.plot_choice import chart_title
from app.plots.stability_text import condition_text, error_text, ranks_text, section_html, stability_html
from app.plots.ticked_laws import TickedLaws
from app.plots.time_series import COLUMNS, RollingSeries
from app.session.frame import contact
from controllers.kinematics import Array
from controllers.stability import Analysis, analyse, barrier
from scenes.history import COLUMN
from scenes.law_answers import LawAnswers, ReplayedLaw
from scenes.laws import LAWS
from scenes.settings import LawSettings, RunSettings
from scenes.simulation import Simulation
from tests.app.html_reader import HtmlReader
from tests.app.plots.helpers import marks, paths, played, text
from tests.scenes.helpers import moved


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
    # In thousandths: rounding of both ends and omitted points; steeper lines allow for the rounding of x.
    slope = np.abs(np.diff(meant)).max(initial=0.0) * len(values) / 1000.0
    assert np.abs(drawn - meant).max() <= 1.5 + 1.5 * slope


@given(st.floats(0.03, 0.3), st.floats(1.0, 20.0), st.sampled_from(tuple(LAWS)), st.floats(0.04, 0.59))
def test_the_dot_is_on_the_curve_of_fig_2(d_m: float, order: float, name: str, distance: float) -> None:
    simulation = played()
    law = LawSettings(law=name, critical_distance=d_m, order=order)
    shown: Any = SimpleNamespace(settings=replace(simulation.settings, law=law), law=all_laws(law)[name])
    sample = replace(simulation.sample(), law_distance=distance, activation=shown.law.activation(distance))
    html = curve_html(shown, None, sample, 150)
    ((x, y),) = marks(html, "dot lam")
    assert x == pytest.approx(distance / FAR, abs=6e-4) and y == pytest.approx(
        FRAME.down(sample.activation), abs=6e-4
    )
    (line,) = paths(html, "lam")
    # At a jump both ends are valid; the curve has straight pieces.
    near = np.interp(1000.0 * x + np.array([-4.0, 0.0, 4.0]), line[:, 0], line[:, 1])
    assert near.min() - 12.0 <= 1000.0 * y <= near.max() + 12.0
    assert len(paths(html, "faint")) == 3 and text(html).count("n = ") == 3
    # A text line has 1/5 of the lowest chart's height: names do not overlap, even for close curves.
    assert np.diff([y for _, y in marks(html, "name faint")]).min() > 0.2
    assert len(paths(curve_html(shown, shown, sample, 150), "ghost")) == 1


def test_drawn_distances_include_both_sides_of_every_kink() -> None:
    xs = distances(LawSettings(critical_distance=0.15, influence_distance=0.3))
    assert (np.diff(xs) > 0.0).all() and xs[0] == 0.0 and xs[-1] == FAR
    for kink in (0.15, 0.3):
        assert {kink - 1e-6, kink, kink + 1e-6} <= set(xs.tolist())


@pytest.mark.parametrize("name", LAWS)
def test_a_ticked_law_is_compared_at_the_present_pull(name: str) -> None:
    running = "smooth_priority" if name != "smooth_priority" else "barrier_qp"
    simulation = played("hold", running, seconds=4.0)
    now, far = contact(simulation, simulation.sample()), 2.0 * simulation.settings.law.critical_distance
    html = laws_html(simulation, None, now, 150, {name: 0})
    span = float(re.findall(r'<i style="top:0.0%">([^<]*)</i>', html)[0].replace("−", "-"))
    assert re.findall(r'class="xs">.*?>0</i>.*?>([^<]+)</i>.*?>([^<]+)</i></div>', html, re.DOTALL) == [
        ("0.15", "0.3")
    ]
    for law in (name, running):
        kind = f"law{list(LAWS).index(law) + 1}"
        (points,) = paths(html, kind)
        assert points[0, 0] == 0.0 and points[-1, 0] == 1000.0, "the line does not go from 0 to 2 d_m"
        for d in (0.05, 0.22, 0.28):
            rate = all_laws(simulation.settings.law)[law].line_rate(d, now.pull, now.approach, now.square)
            meant = 1000.0 * min(max((span - rate) / (2.0 * span), -1.0), 2.0)
            assert np.interp(1000.0 * d / far, points[:, 0], points[:, 1]) == pytest.approx(
                meant, abs=12.0
            ), (law, d)
        assert len(marks(html, f"digit {kind}")) == 1
    assert html.count('stroke-width="3.2"') == 1 and html.count("digit ") == 2, "a line of another law"
    ((x, y),) = marks(html, f"dot law{list(LAWS).index(running) + 1}")
    assert x == pytest.approx(now.distance / far, abs=1e-3)
    assert y == pytest.approx(min(max((span - now.rate) / (2.0 * span), 0.0), 1.0), abs=1e-3)
    assert not marks(
        laws_html(simulation, None, now._replace(distance=far + 0.01), 150),
        f"dot law{list(LAWS).index(running) + 1}",
    )


def test_every_line_of_the_laws_has_its_own_look() -> None:
    simulation, ghost = played("hold"), played("hold", "barrier_qp")
    ticked = {"strict_switched": 0, "unprotected": 1, "potential_field": 2}
    html = laws_html(simulation, ghost, contact(simulation, simulation.sample()), 150, ticked)
    found = re.findall(
        r'<path class="law(\d+)" d="[^"]*" stroke-width="([\d.]+)"(?: stroke-dasharray="([^"]*)")?', html
    )
    assert [list(LAWS)[int(law) - 1] for law, _, _ in found] == [*ticked, "barrier_qp", "smooth_priority"]
    assert len({(width, dash) for _, width, dash in found}) == 5
    assert laws_legend(simulation) == (), "a legend although numbers name the laws"


def test_a_fourth_tick_takes_the_place_of_the_oldest() -> None:
    laws = TickedLaws(None)
    for name in ("barrier_qp", "lever", "unprotected"):
        laws.tick(name)
    assert laws.places == {"barrier_qp": 0, "lever": 1, "unprotected": 2}
    laws.tick("drawn_curve")
    assert laws.places == {"lever": 1, "unprotected": 2, "drawn_curve": 0}, "another law's look has changed"
    laws.tick("unprotected")
    laws.tick("no such law")
    assert laws.places == {"lever": 1, "drawn_curve": 0}
    again = TickedLaws(None)
    again.restore(laws.saved())
    assert list(again.places) == ["lever", "drawn_curve"]


def test_a_custom_law_is_the_thick_line() -> None:
    simulation = played("hold")
    now = contact(simulation, simulation.sample())

    class Mine(ReplayedLaw):
        def line_rates(self, distances: Array, pull: float, approach: float, square: float) -> Array:
            return np.full(len(distances), 0.1)

    simulation.use(Mine([LawAnswers("mine.py", "0" * 64, np.zeros((1, 8)))], simulation, 0))
    html = laws_html(simulation, None, now, 150, {"smooth_priority": 0})
    own, built_in = paths(html, "law1")[::-1]
    assert np.ptp(own[:, 1]) == 0.0 < np.ptp(built_in[:, 1])
    assert [name for _, _, name in laws_legend(simulation)] == ["mine.py"]


def test_numbers_at_the_charts_have_the_decimal_sign_of_the_language() -> None:
    simulation = played("hold", seconds=4.0)
    sample = simulation.sample()
    now = contact(simulation, sample)
    set_language("de")
    words = text(laws_html(simulation, None, now, 150)) + text(section_html(simulation, sample, now))
    assert len(re.findall(r"\d,\d", words)) > 8 and not re.findall(r"\d\.\d", words)


def test_negative_numbers_on_the_microscopes_axis_have_a_true_minus() -> None:
    assert [text for _, text in ticks_of(-0.03, 0.01)] == ["−0.03", "−0.02", "−0.01", "0.00", "0.01"]


def test_the_axis_of_speeds_does_not_change_with_a_small_pull() -> None:
    """The axis stays the same for pulls below v."""
    simulation = played("hold")
    now = contact(simulation, simulation.sample())
    axes = set[str]()
    for pull in (-0.2, 0.0, 0.1, 0.29):
        html = laws_html(simulation, None, now._replace(pull=pull), 150)
        axes.add(re.findall(r'class="ys">(.*?)</div>', html)[0])
    assert len(axes) == 1


def test_the_strips_show_the_closest_pair_at_each_time() -> None:
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


HAND = np.eye(4)[:3]
"""J_b of a task that uses the first three of four joints."""

FREE, ALONG, BETWEEN = (
    np.array([0.0, 0.0, 0.0, 0.5]),
    np.array([0.5, 0.0, 0.0, 0.0]),
    np.array([0.5, 0.0, 0.0, 0.1]),
)
"""J_d orthogonal to J_b, inside its row space, and in between."""


def at(row: Array, lam: float = 0.7, J_b: Array | None = HAND) -> Analysis:
    return analyse(row, J_b, lam, 2.0, 2.0)


@pytest.mark.parametrize(
    ("analysis", "holds", "why"),
    [
        (at(FREE), True, "avoidance and task are orthogonal."),
        (at(np.array([0.5, 0.0, 0.0, 0.5])), True, "every error makes V fall."),
        (at(ALONG), False, "not every error makes V fall."),
        (at(BETWEEN), False, "not every error makes V fall."),
        (at(ALONG, lam=0.0), True, "nothing disturbs the task."),
        (analyse(ALONG, HAND, 0.0, 2.0, 0.0), False, "not every error makes V fall."),
        (at(np.zeros(4)), False, "no joint moves this point."),
        (at(0.01 * ALONG), False, "no joint moves this point."),
        (at(ALONG, J_b=None), False, "not every error makes V fall."),
    ],
)
def test_the_condition_in_words(analysis: Analysis, holds: bool, why: str) -> None:
    text = condition_text(analysis)
    assert text.startswith(
        f"<b>The paper’s condition {'holds' if holds else 'does not hold'}:</b>"
    ) and text.endswith(why)
    assert analysis.condition_holds is holds


@pytest.mark.parametrize(
    ("analysis", "norm", "rate", "says"),
    [
        (at(BETWEEN), 0.042, -0.013, "The error still shrinks: |e| = 42 mm, −13 mm/s."),
        (at(FREE), 0.042, -0.013, "The error shrinks: |e| = 42 mm, −13 mm/s."),
        (at(BETWEEN), 0.042, 0.013, "The error grows: |e| = 42 mm, +13 mm/s."),
        (at(FREE), 0.042, 0.013, "The error grows even so: |e| = 42 mm, +13 mm/s."),
        (
            at(ALONG),
            0.042,
            0.0002,
            "The error stays as it is: |e| = 42 mm, because avoidance and task are dependent.",
        ),
        (at(FREE), 0.042, 0.0, "The error stays as it is: |e| = 42 mm."),
        (at(FREE), 0.0018, -0.0009, "The error has died out: |e| = 2 mm."),
        (at(BETWEEN), 0.0022, 0.0011, "The error has died out: |e| = 2 mm."),
        (at(BETWEEN), 0.0022, 0.0111, "The error grows: |e| = 2 mm, +11 mm/s."),
        (
            at(ALONG),
            0.0012,
            0.0002,
            "The error stays as it is: |e| = 1 mm, because avoidance and task are dependent.",
        ),
        (at(ALONG), 0.0001, -0.0001, "There is no error to bring down."),
        (at(ALONG), 0.0001, 0.1, "The error grows: |e| = 0 mm, +100 mm/s."),
        (at(ALONG, J_b=None), 0.1, -0.2, "The error still shrinks: |e| = 5.7°, −11.5°/s."),
        (at(ALONG), math.nan, 0.0, "The error is not known."),
    ],
)
def test_the_error_in_words(analysis: Analysis, norm: float, rate: float, says: str) -> None:
    assert HtmlReader(error_text(analysis, norm, rate)).text == says


@pytest.mark.parametrize(
    ("analysis", "says"),
    [
        (at(FREE), "4 = 1 + 3, independent by 90.0°"),
        (at(BETWEEN), "4 = 1 + 3, independent by 11.3°"),
        (at(ALONG), "3 < 1 + 3, dependent"),
        (at(ALONG, J_b=None), "4 < 1 + 4, dependent"),
        (at(np.zeros(4)), "3 = 0 + 3, for Ja = 0"),
    ],
)
def test_the_ranks(analysis: Analysis, says: str) -> None:
    assert HtmlReader(ranks_text(analysis)).text == says


def test_every_number_of_section_three_is_in_the_panel() -> None:
    a = at(BETWEEN, lam=0.5)
    html = stability_html(a, 0.1, -0.02, 0.0123, -0.0045, None)
    text = HtmlReader(html).text.replace("−", "-")
    assert f"sym(M) {a.smallest_eigenvalue:+.2f}, M {a.slowest_mode:+.3f} 1/s" in text
    assert "4 = 1 + 3" in text and "‖JaJb#‖ (16)0.50: not orthogonal" in text
    assert f"1 - λρ²{a.survival:.3f} of the task is left" in text
    assert "V, V̇ (20)0.01230, -0.00450: falls" in text and "W" not in text
    assert html.count("<tr>") == 5


@pytest.mark.parametrize(
    ("rate", "says"),
    [
        (0.01, "+0.01000: rises"),
        (1.26e-6, "+1.3·10⁻⁶: rises"),
        (-2e-7, "−2.0·10⁻⁷: falls"),
        (1e-9, "0.00000"),
        (-1e-9, "0.00000"),
        (-0.00051, "−5.1·10⁻⁴: falls"),
        (-0.01, "−0.01000: falls"),
    ],
)
def test_the_rate_of_v_in_words_has_no_sign_at_a_rounded_zero(rate: float, says: str) -> None:
    """Otherwise numbers around zero would make the panel flicker."""
    text = HtmlReader(stability_html(at(BETWEEN), 0.1, 0.0, 0.01, rate, rate)).text
    assert f"0.01000, {says}" in text and "−0.00000" not in text and "+0.00000" not in text
    assert ("rises" in text, "falls" in text) == ("rises" in says, "falls" in says)


@pytest.mark.parametrize(
    ("distance", "row", "says"),
    [(0.2, ALONG, "W0."), (0.15, ALONG, "W∞: d ≤ dm"), (0.2, 0.1 * ALONG, "Wnot defined: |Jd| is too small")],
)
def test_the_barrier_function(distance: float, row: Array, says: str) -> None:
    W = barrier(np.full(4, 0.1), 2.0, row, distance, 0.15, 2.0, 0.3)
    html = stability_html(at(ALONG, J_b=None), 0.1, 0.0, 0.01, 0.0, W)
    assert says in HtmlReader(html).text
    assert html.count("<tr>") == 6


NUMBERS = st.tuples(*4 * [st.floats()], st.none() | st.floats())


@given(st.integers(0, 1000), st.floats(0.0, 1.0), st.booleans(), NUMBERS)
def test_any_numbers_make_valid_html(seed: int, lam: float, posture: bool, numbers: Any) -> None:
    random = np.random.default_rng(seed)
    J_b = None if posture else random.normal(size=(3, 7))
    html = stability_html(at(random.normal(size=7) * 0.3, lam, J_b), *numbers)
    reader = HtmlReader(html)
    assert reader.tags <= {"div", "p", "b", "br", "table", "tr", "td", "sub", "sup"}
    assert not re.search(r"\b(nan|inf)\b", reader.text)
    assert set(re.findall(r'class="([^"]*)"', html)) <= {"duet duet-stability", "lam", "e"}


@pytest.mark.parametrize("joints", [False, True])
def test_laps_count_from_the_circles_beginning_also_in_a_replay(joints: bool) -> None:
    def gaps(simulation: Simulation) -> list[float]:
        return [
            float(gap) for gap in re.findall(r"lap \d: ([\d.]+)", laps_html(simulation, None, joints, 150))
        ]

    at_once = moved(RunSettings(scene="solo", path="circle", gain=0.0), lambda s: s.time >= 17.0)
    later = Simulation(RunSettings(scene="solo", gain=0.0))
    for end, path in ((5.0, later.settings.path), (22.0, "circle")):
        later.apply(replace(later.settings, path=path))
        while later.time < end:
            later.step(None)
    assert len(gaps(at_once)) == 2 and gaps(later) == pytest.approx(gaps(at_once), abs=0.011)
    # A replay keeps one row per 1/32 s, and may lack the first ones.
    history, rows = at_once.history, at_once.history.table()
    for begin in (0, 40):
        kept = rows[begin::6]
        history._rows[: len(kept)] = kept
        history.count = len(kept)
        assert gaps(at_once) == pytest.approx(gaps(later)[: 1 if begin else 2], abs=0.05)


@pytest.mark.parametrize(
    ("first", "over", "row"),
    [
        ("stops", '<b class="d">h</b> [rad]', "|J<sub>a</sub>|"),
        ("singular", '<b class="d">σ</b> [m/rad]', "m/rad²"),
        ("wall", '<b class="d">d</b> [m]', "m/rad"),
    ],
)
def test_charts_of_another_first_task_have_its_symbol_and_unit(first: str, over: str, row: str) -> None:
    simulation = Simulation(RunSettings(scene="first_task", first=first))
    simulation.step(None)
    run = simulation.settings
    assert over in chart_title("curve", run) and over in chart_title("laws", run)
    assert f"J<sub>a</sub>q̇ [{run.quantity.rate_unit}]" in chart_title("laws", run)
    several = replace(run, first="all")
    assert '<b class="d">h<sub>law</sub></b> [m, rad]' in chart_title("curve", several)
    assert row in laws_html(simulation, None, contact(simulation, simulation.sample()), 150)
    board = activation_axes(0.15, (0.0, 0.4), run.quantity)
    assert board.x.label == f"{run.quantity.symbol} [{run.quantity.page_unit}]"
    assert axes_text(board) == f"λ over {run.quantity.short} {run.quantity.symbol}"
    assert f">{run.quantity.symbol}<tspan" in board_svg(board, ())
