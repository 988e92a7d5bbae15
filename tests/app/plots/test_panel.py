"""The panel of plots: shown plots, "what if", and sent updates."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from app.page.panels.choice_buttons import MARK
from app.page.panels.law_ticks import NOT_DRAWN
from app.page.panels.plots_panel import CURTAIN
from app.plots.bins import POINTS, WINDOW
from app.plots.plot_choice import cells, is_chart
from app.plots.ticked_laws import TickedLaws
from app.session.parts import SessionPart
from app.settings import PageSettings
from scenes.history import COLUMN
from scenes.laws import LAWS
from tests.app.conftest import Arrive, OpenHouse
from tests.app.page.helpers import bodies, press
from tests.app.plots.helpers import DETAILS, SCENES, ShownPanel, go_on
from tests.blocking_client import BlockingClient


@pytest.mark.parametrize("scene", SCENES)
def test_every_plot_can_be_shown_in_every_experiment(scene: str) -> None:
    shown = ShownPanel(scene, ghost="unprotected")
    go_on(shown.session, 0.4)
    for details in DETAILS:
        visible = [plot for plot in shown.show(0.05, plot=details) if plot.visible]
        meant = cells(shown.session.settings.run, details)
        assert len(visible) == len([name for name in meant if not is_chart(name)])
        for plot in visible:
            assert len(plot.data) == len(plot.series)
            assert {len(line) for line in plot.data} <= {len(plot.data[0]), 0} and len(plot.data[0]) <= 200
            assert plot.data[0][-1] == pytest.approx(shown.session.simulation.sample().time)
        captions = [block for block in shown.gui.blocks if block.visible and "duet-title" in block.content]
        assert len(captions) == len(meant)
        # On a phone each caption is directly above its plot.
        orders = [block.order for block in (*captions, *visible)]
        assert len(set(orders)) == len(orders)


def test_nothing_is_sent_to_hidden_plots() -> None:
    shown = ShownPanel("hold", "lambda")
    third = [shown.show(0.2) for _ in range(3)][-1][2]
    shown.show(plot="laws")
    assert third.visible is False
    chart = next(block for block in shown.gui.blocks if "duet-few-laws" in block.content)
    shown.show(plot="none")
    sent = len(third.sent), len(chart.sent)
    for _ in range(4):
        shown.show(0.2)
    assert (len(third.sent), len(chart.sent)) == sent and chart.visible is False


def test_a_tick_draws_its_law_at_once() -> None:
    shown = ShownPanel("hold")
    shown.show(0.2, plot="laws")
    chart = next(block for block in shown.gui.blocks if "duet-few-laws" in block.content)
    line = f'class="law{list(LAWS).index("unprotected") + 1}"'
    for drawn in (True, False):
        assert (line in chart.content) is not drawn
        shown.session.parts.of(TickedLaws).tick("unprotected")
        shown.show(wait=0.03)
        assert (line in chart.content) is drawn


def test_a_visitor_ticks_laws_below_their_plot(house: OpenHouse, arrive: Arrive) -> None:
    guest = arrive(house(), "plot=laws")

    def row() -> tuple[str, ...]:
        (options,) = [
            one["options"]
            for one in bodies(guest.visitor, "GuiDropdownMessage")
            if one["label"] == "also draw"
        ]
        return tuple(options)

    def drawn() -> set[str]:
        return {said.removeprefix(MARK) for said in row() if said.startswith(MARK)}

    def said() -> object:
        return guest.visitor.mirror.labelled("also draw")["value"]

    guest.visitor.wait_for(lambda _: drawn() == {"1 Smooth priority"})
    assert said() == row()[0] == "up to three laws" and len(row()) == 1 + len(LAWS)
    for place, law in (
        (3, "Strict, switched"),
        (6, "Barrier QP"),
        (15, "Unprotected"),
        (5, "Potential field"),
    ):
        guest.visitor.set_value("also draw", f"{NOT_DRAWN}{place} {law}")
        guest.visitor.wait_for(lambda _, law=f"{place} {law}": law in drawn())
    assert drawn() == {"1 Smooth priority", "6 Barrier QP", "15 Unprotected", "5 Potential field"}
    # The row shows the ticked laws, not the last choice.
    guest.visitor.wait_for(lambda _: said() == row()[0] == "6 Barrier QP, 15 Unprotected, 5 Potential field")
    guest.visitor.set_value("also draw", row()[0])
    guest.visitor.set_value("also draw", f"{MARK}6 Barrier QP")
    guest.visitor.wait_for(lambda _: said() == "15 Unprotected, 5 Potential field")
    assert drawn() == {"1 Smooth priority", "15 Unprotected", "5 Potential field"}


def test_at_most_ten_refreshes_a_second() -> None:
    shown = ShownPanel("master_slave", "joints")
    for _ in range(90):
        shown.show(0.03, wait=1.0 / 30.0)
    refreshes = [sum(name == "data" for name, _ in plot.sent) for plot in shown.gui.plots]
    assert all(count <= 3.0 * 10.0 + 2 for count in refreshes) and min(refreshes) >= 10
    before = [len(plot.sent) for plot in shown.show()]
    assert [len(plot.sent) for plot in shown.show()] == before


def test_a_missing_ghost_costs_nothing() -> None:
    shown = ShownPanel("hold")
    distance = shown.show(1.0)[0]
    assert [len(line) for line in distance.data[4:]] == [0, 0]
    sent = len(distance.sent)
    shown.show(1.0, ghost="unprotected")
    # Before, the ghost equals the run. Without a first value the page would find no range for the axis.
    own, ghost = distance.data[1], distance.data[4]
    assert np.isfinite(ghost).all() and (ghost[:7] == own[:7]).all()
    # The series are not replaced: a rebuilt chart would flicker.
    assert not any(name == "series" for name, _ in distance.sent[sent:])
    assert shown.says("ghost") == 2
    shown.show(ghost="off")
    assert len(distance.data[4]) == 0 and not shown.says("ghost")


def test_what_if_is_drawn_over_the_run() -> None:
    shown = ShownPanel("hold")
    shown.show(2.0)
    times = shown.session.simulation.history.table()[:200, COLUMN["t"]]
    answer: Any = SimpleNamespace(times=times, distance=np.full(200, 0.2), squared_error=np.full(200, 0.01))

    class Answering(SessionPart):
        def curves(self) -> Any:
            return answer

    shown.session.parts.of(Answering)
    for plot, value in zip(shown.show(), (0.2, 0.01), strict=True):
        line = plot.data[-1]
        inside = plot.data[0] < times[-1] - WINDOW / POINTS
        assert (line[inside] == value).all() and np.isnan(line[-1])
    assert shown.says("what if") == 2
    # An answer with other times, which cannot be compared element by element with the first one.
    answer = SimpleNamespace(times=times[::2], distance=np.full(100, 0.3), squared_error=np.full(100, 0.02))
    assert np.nanmax(shown.show()[0].data[-1]) == 0.3
    assert shown.says("what if") == 2
    answer = None
    assert len(shown.show()[0].data[-1]) == 0 and not shown.says("what if")


def test_another_experiment_changes_lines_and_names() -> None:
    shown = ShownPanel("hold")
    error = shown.show(0.5)[1]
    shown.show(0.5, scene="imitation")
    assert len(error.series) == len(error.data) == 5 and shown.says("[rad²]")
    assert [plot.visible for plot in shown.show(0.5, scene="solo")] == [False, False, True, True]
    assert [plot.visible for plot in shown.show(0.5, scene="ball")] == [True, True, False, False] and len(
        error.series
    ) == 5
    assert sum(name == "series" for name, _ in error.sent) == 1


def test_a_second_avoiding_arm_does_not_blank_the_plot() -> None:
    shown = ShownPanel("imitation")
    error = shown.show(0.6, avoid="free")[1]
    assert [len(line) for line in error.data[2:]] == [0, 0, 0]
    shown.show(0.6, avoid="both")
    first, second = error.data[1:3]
    assert len(second) == len(first) and np.isfinite([first[0], second[0]]).all()
    shown.session.control.halt.set("visitor")
    shown.session.reset()
    shown.show()
    assert (
        error.data[1][0] == 0.0
        and np.isnan(error.data[1][1])
        and [len(line) for line in error.data[2:]] == [0, 0, 0]
    )


def test_another_theme_restyles_all_plots() -> None:
    shown = ShownPanel("hold", "joints")
    before = [plot.series[1]["stroke"] for plot in shown.show()]
    shown.panel.dress(PageSettings(theme="dark", profile="projector"), 200)
    plots = shown.gui.plots
    assert len(plots) == 3 and all(
        plot.series[1]["stroke"] != old for plot, old in zip(plots, before, strict=True)
    )
    # A plot that the page rebuilds gets no data at that moment, and is filled later.
    sent = [len(plot.sent) for plot in plots]
    shown.show(0.3)
    assert [plot.sent[n:] for n, plot in zip(sent, plots, strict=True)] == [[("visible", False)]] * 3
    assert not any(plot.visible for plot in shown.show(wait=0.1))
    for plot in shown.show(wait=CURTAIN):
        assert plot.visible and plot.sent[-1][0] == "data"


def plots(visitor: BlockingClient) -> list[tuple[np.ndarray, ...]]:
    return [tuple(np.array(row) for row in element["data"]) for element in bodies(visitor, "GuiUplotMessage")]


def looks(visitor: BlockingClient) -> list[tuple[Any, ...]]:
    return [
        (element["series"][1]["stroke"], element["series"][1]["width"])
        for element in bodies(visitor, "GuiUplotMessage")
    ]


def test_restyled_plots_and_plots_added_in_a_pause_are_complete(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house(), "dt=0.02")
    one.run_on(2.0)
    press(one, "pause")
    for change in (("colours", "Dark"), ("text", "Projector"), ("more plots", "q")):
        old = looks(one.visitor)
        one.visitor.set_value(*change)
        one.visitor.wait_for(lambda _, old=old: looks(one.visitor) != old)
        count = 3 if change[0] == "more plots" else 2
        one.visitor.wait_for(
            lambda _, count=count: (
                len(plots(one.visitor)) == count and all(np.ptp(plot[0]) > 1.5 for plot in plots(one.visitor))
            )
        )
        for times, *lines in plots(one.visitor):
            assert times[0] < 0.2 and np.isfinite(lines[0]).all()
        press(one, "step")
        newest = one.ask(lambda s: s.simulation.sample().time)
        one.visitor.wait_for(lambda _, newest=newest: abs(plots(one.visitor)[0][0][-1] - newest) < 1e-9)


def test_traffic_of_the_default_page(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house())
    one.run_on(1.0)
    received = one.visitor.received
    frames, size, begin = received.frames, received.bytes, one.session.simulation.time
    one.run_on(3.0)
    # The waiting messages arrive while the run is paused.
    simulated = one.ask(lambda s: (s.control.toggle_pause(), s.simulation.time)[1]) - begin
    # A frame simulates at most 0.1 s; on an idle machine there are about 30 frames per second.
    one.visitor.wait_for(lambda _: received.frames - frames >= 10 * simulated)
    assert (received.bytes - size) / simulated <= 150_000
