"""A tab that is out of sight, or on which nothing happens, costs next to nothing, and is whole again at once."""

from typing import Any

import pytest

from app.hosting.frame_loop import LIVELY, RESTING, UNSEEN, Attention
from app.session.actions import Pause, SetSetting
from app.settings import Settings
from app.web.pages import HIDDEN, SHOWN
from scenes.settings import specs
from tests.app.conftest import FRAME, ByHand, Made, visitor_of
from tests.app.runtime.processes import until
from tests.blocking_client import BlockingClient


def frames(attention: Attention, seconds: float, begin: float, state: Any = 0, **kind: bool) -> int:
    """Number of frames of a page in `seconds`, at 32 rounds a second."""
    given = {"hidden": False, "paused": True, "dirty": False} | kind
    count = 0
    for number in range(round(32 * seconds)):
        now = begin + number * FRAME
        if attention.due(now, given["hidden"], given["paused"], given["dirty"]):
            count += 1
            attention.note(now, state)
    return count


def test_a_page_has_every_frame_while_anything_happens_and_few_while_it_rests() -> None:
    attention = Attention()
    assert frames(attention, 10.0, 0.0, paused=False) == 320, "a run that goes on is not at rest"
    # It is drawn for a while after the pause, because a camera may still be on its way.
    assert frames(attention, LIVELY, 10.0) == 32 * LIVELY
    assert frames(attention, 20.0, 20.0) == pytest.approx(20.0 / RESTING, abs=2)
    assert frames(attention, 1.0, 40.0, dirty=True) == 32
    assert frames(attention, 1.0, 45.0, state=1) >= 31, "something has changed by itself"
    assert frames(attention, 1.0, 50.0, paused=False) == 32, (
        "it goes on in the very round in which the pause ends"
    )


@pytest.mark.parametrize("paused", [True, False])
def test_a_page_out_of_sight_has_hardly_a_frame_and_one_at_once_when_it_is_back(paused: bool) -> None:
    attention = Attention()
    frames(attention, 1.0, 0.0, paused=paused)
    assert frames(attention, 20.0, 1.0, hidden=True, paused=True, dirty=True) == pytest.approx(
        20.0 / UNSEEN, abs=1
    )
    assert frames(attention, 1.0, 21.0, paused=paused) == 32


def drawn(opened: ByHand, seconds: float) -> int:
    """Number of frames of the one visitor in `seconds`."""
    count = 0
    for _ in range(round(seconds / FRAME)):
        opened.frame()
        count += opened.house.context.workload.sessions
    return count


def say(opened: ByHand, visitor: BlockingClient, kind: str) -> None:
    """The page says that it is out of sight, or back, and the server knows."""
    server = opened.house.server
    visitor.send({"type": kind})
    until(
        lambda: any(
            (page := server.page_of(number)) and page.hidden == (kind == HIDDEN)
            for number in server.get_clients()
        )
    )


def test_a_hidden_tab_is_neither_stepped_nor_drawn_and_goes_on_where_it_was(by_hand: Made) -> None:
    opened = by_hand(sessions=3)
    visitor = opened.let_in()
    session = visitor_of(opened).session
    assert drawn(opened, 1.0) == 32 and session.simulation.steps > 0
    say(opened, visitor, HIDDEN)
    opened.frame()
    steps, before = session.simulation.steps, len(session.posts)
    assert drawn(opened, 20.0) <= 20.0 / UNSEEN + 1 and session.simulation.steps == steps and session.paused
    # What it was asked for before is done meanwhile.
    session.post(SetSetting("dm", 0.2))
    drawn(opened, 1.1 * UNSEEN)
    assert len(session.posts) == before == 0 and session.settings.run.law.critical_distance == 0.2
    say(opened, visitor, SHOWN)
    opened.frame()
    assert not session.paused and 0 < session.simulation.steps - steps <= 8, "no step is made up for"
    assert drawn(opened, 1.0) == 32


def test_a_tab_that_is_closed_out_of_sight_comes_back_alive(by_hand: Made) -> None:
    opened = by_hand(sessions=3)
    tab = f"resume={'0123456789abcdef' * 2}"
    visitor = opened.let_in(tab)
    session = visitor_of(opened).session
    say(opened, visitor, HIDDEN)
    opened.frame()
    opened.leave(visitor)
    opened.frame()
    assert not session.paused
    opened.let_in(tab)
    assert visitor_of(opened).session is session and drawn(opened, 1.0) == 32


def test_a_paused_page_rests_until_its_visitor_does_anything(by_hand: Made) -> None:
    opened = by_hand(sessions=3)
    visitor = opened.let_in()
    session = visitor_of(opened).session
    assert drawn(opened, 2.0 * LIVELY) == 64 * LIVELY, "the autopilot plays"
    session.post(Pause())
    drawn(opened, 2.0 * LIVELY)
    assert drawn(opened, 10.0) <= 10.0 / RESTING + 1
    page = opened.house.server.page_of(next(iter(opened.house.server.get_clients())))
    assert page is not None
    heard = page.heard
    visitor.set_value(specs(Settings)["dm"].title(), 200.0)
    until(lambda: page.heard > heard and len(session.posts))
    opened.frame()
    assert session.settings.run.law.critical_distance == 0.2
    assert drawn(opened, 1.0) == 32
    drawn(opened, 2.0 * LIVELY)
    steps = session.simulation.steps
    session.post(Pause())
    assert drawn(opened, 1.0) == 32 and session.simulation.steps > steps
