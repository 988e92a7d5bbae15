"""A visitor's plots through other looks and pauses, and how much a page is sent for them."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest

from app.bench.blocking_client import BlockingClient
from tests.app.conftest import Arrive, OpenHouse
from tests.app.page.helpers import bodies, page_label, press


def plots(visitor: BlockingClient) -> list[tuple[np.ndarray, ...]]:
    """The data of every plot, in order."""
    return [tuple(np.array(row) for row in element["data"]) for element in bodies(visitor, "GuiUplotMessage")]


def looks(visitor: BlockingClient) -> list[tuple[Any, ...]]:
    """Colour and width of the first line of every plot, in order."""
    return [(element["series"][1]["stroke"], element["series"][1]["width"]) for element in bodies(visitor, "GuiUplotMessage")]


@pytest.mark.parametrize("change", [("colours", "Dark"), ("text", "Projector"), ("more plots", "q")])
def test_plots_of_another_look_or_made_while_paused_are_not_empty(
    house: OpenHouse, arrive: Arrive, change: tuple[str, str]
) -> None:
    """They hold the whole run; and each single step is on the plot."""
    one = arrive(house(), "dt=0.02")
    one.run_on(2.0)
    press(one, "pause")
    old = looks(one.visitor)
    one.visitor.set_value(*change)
    one.visitor.wait_for(lambda _: looks(one.visitor) != old)
    count = 3 if change[0] == "more plots" else 2
    one.visitor.wait_for(lambda _: len(plots(one.visitor)) == count and all(len(plot[0]) > 12 for plot in plots(one.visitor)))
    for times, *lines in plots(one.visitor):
        assert times[0] < 0.2 and np.isfinite(lines[0]).all()
    press(one, "step")
    newest = one.ask(lambda s: s.simulation.sample().time)
    one.visitor.wait_for(lambda _: abs(plots(one.visitor)[0][0][-1] - newest) < 1e-9)


def test_what_the_ghost_does_and_what_would_have_been_are_on_the_plots(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house(), "whatif=1")
    one.run_on(1.0)
    own = len([row for row in plots(one.visitor)[0][1:] if len(row)])
    press(one, "ghost")
    one.run_on(0.5)
    # The ghost has a line beside that of the run, the same one as long as nothing was changed.
    one.visitor.wait_for(lambda _: len([row for row in plots(one.visitor)[0][1:] if len(row)]) == own + 1)
    times, distance, *_, ghost, _ = plots(one.visitor)[0]
    assert len(ghost) == len(times) > 9 and np.isfinite(ghost[:-1]).all() and np.allclose(ghost[:-1], distance[:-1])
    # A line whose first value is missing would leave the page without a range for its axis.
    assert all(np.isfinite(row[0]) for plot in plots(one.visitor) for row in plot if len(row))
    one.visitor.set_value(page_label("dm"), 250.0)
    one.visitor.wait_for(lambda _: len([row for row in plots(one.visitor)[0][1:] if len(row)]) == own + 2)


def test_traffic_of_the_default_page(house: OpenHouse, arrive: Arrive, monkeypatch: pytest.MonkeyPatch) -> None:
    one = arrive(house())
    one.run_on(1.0)
    refreshes, payloads = [0], list[int]()
    take = one.visitor.mirror.take

    def count(message: dict[str, Any]) -> None:
        if message["type"] == "GuiUpdateMessage" and "data" in message["updates"]:
            refreshes[0] += 1
            payloads.append(len(message["updates"]["data"][0]))
        take(message)

    monkeypatch.setattr(one.visitor.mirror, "take", count)
    received = one.visitor.received
    frames, size, begin, clock = received.frames, received.bytes, one.session.simulation.time, time.perf_counter()
    one.run_on(3.0)
    simulated, wall = one.session.simulation.time - begin, time.perf_counter() - clock
    frames, size = received.frames - frames, received.bytes - size
    print(f"{frames / simulated:.0f} frames and {size / simulated / 1000:.0f} kB per simulated second, {simulated / wall:.2f}×")
    assert size / simulated <= 150_000
    # A frame simulates a tenth of a second at most; on a machine at leisure there are about 30 a second.
    assert frames / simulated >= 10
    assert 2 * 2 < refreshes[0] <= 2 * (10.0 * wall + 2.0)
    assert max(payloads) <= 200
