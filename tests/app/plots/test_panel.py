"""The panel of plots: what is shown, what if, what it is told and how often."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
import pytest

from app.page.panels.plots_panel import CURTAIN
from app.plots.plot_choice import CHARTS, cells
from app.plots.time_series import POINTS, WINDOW
from app.session.frame import freeze
from app.session.session import Session
from app.settings import PageSettings
from scenes.history import COLUMN
from scenes.rerun import WhatIf
from scenes.settings import SceneName
from tests.app.plots.helpers import DETAILS, SCENES, go_on, panel, session_of


@pytest.mark.parametrize("scene", SCENES)
def test_everything_can_be_shown_in_every_experiment(scene: SceneName) -> None:
    session = session_of(scene, "none", ghost="unprotected")
    plots, gui = panel(session)
    go_on(session, 0.4)
    for i, details in enumerate(DETAILS):
        session.change("plot", details)
        go_on(session, 0.05)
        plots.show(freeze(session, 1.0 * i))
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
        plots.show(freeze(session, 1.0 * i))
    third = gui.plots[2]
    session.change("plot", "laws")
    plots.show(freeze(session, 3.0))
    assert third.visible is False
    told = len(third.told)
    chart = next(block for block in gui.blocks if "duet-laws" in block.content)
    session.change("plot", "none")
    plots.show(freeze(session, 4.0))
    after = len(chart.told)
    for i in range(5, 9):
        go_on(session, 0.2)
        plots.show(freeze(session, 1.0 * i))
    assert len(third.told) == told and len(chart.told) == after and chart.visible is False


def test_ten_refreshes_a_second_at_most() -> None:
    session = session_of("master_slave", "joints")
    plots, gui = panel(session)
    for frame in range(90):
        go_on(session, 0.03)
        plots.show(freeze(session, frame / 30.0))
    refreshes = [sum(name == "data" for name, _ in plot.told) for plot in gui.plots]
    assert all(count <= 3.0 * 10.0 + 2 for count in refreshes) and min(refreshes) >= 10
    # Nothing new, nothing sent.
    plots.show(freeze(session, 9.0))
    before = [len(plot.told) for plot in gui.plots]
    plots.show(freeze(session, 10.0))
    assert [len(plot.told) for plot in gui.plots] == before


def test_a_ghost_costs_nothing_while_there_is_none() -> None:
    session = session_of("hold", "none")
    plots, gui = panel(session)
    go_on(session, 1.0)
    plots.show(freeze(session, 0.0))
    assert [len(line) for line in gui.plots[0].data[4:]] == [0, 0]
    series = list(gui.plots[0].told)
    session.change("ghost", "unprotected")
    go_on(session, 1.0)
    plots.show(freeze(session, 1.0))
    ghost = gui.plots[0].data[4]
    # It was the run itself until then. Without a first value the page would find no range for the axis.
    own = gui.plots[0].data[1]
    assert np.isfinite(ghost).all() and (ghost[:7] == own[:7]).all()
    # The lines stay the ones that they were: a chart that is made anew would flicker.
    assert not any(name == "series" for name, _ in gui.plots[0].told[len(series) :])
    assert sum("ghost" in block.content for block in gui.blocks) == 2
    session.change("ghost", "off")
    plots.show(freeze(session, 2.0))
    assert len(gui.plots[0].data[4]) == 0 and not any("ghost" in block.content for block in gui.blocks)


@dataclass
class _Answer:
    times: np.ndarray
    distance: np.ndarray
    squared_error: np.ndarray


def test_what_if_is_drawn_over_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    session = session_of("hold", "none")
    plots, gui = panel(session)
    go_on(session, 2.0)
    plots.show(freeze(session, 0.0))
    times = session.simulation.history.table()[:200, COLUMN["t"]]
    answer: WhatIf | None = cast(WhatIf, _Answer(times, np.full(200, 0.2), np.full(200, 0.01)))
    monkeypatch.setattr(Session, "what_if", property(lambda _: answer))
    plots.show(freeze(session, 1.0))
    for plot, value in zip(gui.plots, (0.2, 0.01), strict=True):
        line = plot.data[-1]
        inside = plot.data[0] < times[-1] - WINDOW / POINTS
        assert (line[inside] == value).all() and np.isnan(line[-1])
    assert sum("what if" in block.content for block in gui.blocks) == 2
    # The exact answer after the draft: other times, so that nothing can be compared element by element.
    answer = cast(WhatIf, _Answer(times[::2], np.full(100, 0.3), np.full(100, 0.02)))
    plots.show(freeze(session, 2.0))
    assert np.nanmax(gui.plots[0].data[-1]) == 0.3
    answer = None
    plots.show(freeze(session, 3.0))
    assert len(gui.plots[0].data[-1]) == 0 and not any("what if" in block.content for block in gui.blocks)


def test_another_experiment_changes_lines_and_names() -> None:
    session = session_of("hold", "none")
    plots, gui = panel(session)
    go_on(session, 0.5)
    plots.show(freeze(session, 0.0))
    error = gui.plots[1]
    session.change("scene", "imitation")
    go_on(session, 0.5)
    plots.show(freeze(session, 1.0))
    assert len(error.series) == len(error.data) == 5 and any("[rad²]" in block.content for block in gui.blocks)
    session.change("scene", "solo")
    go_on(session, 0.5)
    plots.show(freeze(session, 2.0))
    assert [plot.visible for plot in gui.plots] == [False, False, True, True]
    session.change("scene", "ball")
    go_on(session, 0.5)
    plots.show(freeze(session, 3.0))
    assert [plot.visible for plot in gui.plots] == [True, True, False, False] and len(error.series) == 5
    assert sum(name == "series" for name, _ in error.told) == 1


def test_a_second_arm_that_begins_to_keep_clear_does_not_blank_the_plot() -> None:
    """Its error is a line that begins in the middle; and after a reset that waits, the axes are there all the same."""
    session = session_of("imitation", "none")
    session.change("avoid", "free")
    plots, gui = panel(session)
    go_on(session, 0.6)
    plots.show(freeze(session, 0.0))
    error = gui.plots[1]
    assert [len(line) for line in error.data[2:]] == [0, 0, 0]
    session.change("avoid", "both")
    go_on(session, 0.6)
    plots.show(freeze(session, 1.0))
    first, second = error.data[1:3]
    assert len(second) == len(first) and np.isfinite([first[0], second[0]]).all()
    session.halt.set("visitor")
    session.reset()
    plots.show(freeze(session, 2.0))
    assert error.data[1][0] == 0.0 and np.isnan(error.data[1][1]) and [len(line) for line in error.data[2:]] == [0, 0, 0]


def test_another_theme_dresses_all_plots_anew() -> None:
    session = session_of("hold", "joints")
    plots, gui = panel(session)
    plots.show(freeze(session, 0.0))
    before = [plot.series[1]["stroke"] for plot in gui.plots]
    plots.dress(PageSettings(theme="dark", profile="projector"))
    after = [plot.series[1]["stroke"] for plot in gui.plots]
    assert all(a != b for a, b in zip(before, after, strict=True)) and len(after) == 3
    # What the page makes anew gets no data in that moment, and is begun afresh.
    told = [len(plot.told) for plot in gui.plots]
    go_on(session, 0.3)
    plots.show(freeze(session, 1.0))
    assert [plot.told[n:] for n, plot in zip(told, gui.plots, strict=True)] == [[("visible", False)]] * 3
    plots.show(freeze(session, 1.1))
    assert not any(plot.visible for plot in gui.plots)
    plots.show(freeze(session, 1.1 + CURTAIN))
    for plot in gui.plots:
        assert plot.visible and plot.told[-1][0] == "data"
