"""A lost connection in the middle of a lesson."""

import logging
from collections.abc import Callable
from operator import le

import msgspec
import pytest

from app.features.lessons.bookmark import Phase
from app.start import App
from tests.app.conftest import OpenHouse, ask, live_sessions
from tests.app.features.lessons.helpers import lessons_of
from tests.app.hosting.test_reconnect import WORD, Tab, held, tab
from tests.app.page.helpers import buttons, click

__all__ = ["tab"]

UNFINISHED = {"type": "GuiUpdateMessage", "uuid": "of nothing", "updates": {"value": 1.0}}


def answered_and_seen(one: Tab) -> None:
    """Answer and run a step; then set settings other than the lesson's, and a ghost."""
    click(one.visitor, "2 ")
    one.visitor.wait_for(lambda v: "Run" in buttons(v), 60.0)
    ask(one.session, lambda s: s.change("speed", 2.0))
    click(one.visitor, "Run")
    one.visitor.wait_for(lambda _: lessons_of(one).walk.phase is Phase.OBSERVE, 120.0)
    ask(one.session, lambda s: [s.change("dm", 0.11), s.change("ghost", "frozen"), s.change("dm", 0.12)])


def drop_and_come(opened: App, one: Tab, other: Tab, unfinished: bytes) -> None:
    """Break a connection and reconnect; the session is the same and unchanged."""
    session, before = one.session, one.remembered()
    one.cut(unfinished)
    other.visitor.wait_for(
        lambda _: len(live_sessions(opened)) == 1 and len(opened.context.store.parked) == 1, 60.0
    )
    one.come()
    assert one.session is session and not opened.context.store.parked
    assert one.remembered() == before


@pytest.mark.thorough
def test_four_dropped_connections_lose_nothing(
    house: OpenHouse, tab: Callable[..., Tab], caplog: pytest.LogCaptureFixture
) -> None:
    opened = house()
    other, one = tab(opened, "dm=0.2", WORD[::-1]), tab(opened, "lesson=3&step=2")
    answered_and_seen(one)
    others = ask(other.session, lambda s: s.settings), other.session
    with caplog.at_level(logging.WARNING):
        caplog.clear()
        counts: list[tuple[int, int]] = []
        for turn in range(4):
            if turn == 2:
                click(one.visitor, "Next")
                one.visitor.wait_for(lambda _: lessons_of(one).walk.phase is Phase.EXPLAIN, 60.0)
            if turn == 3:
                ask(one.session, lambda s: s.control.toggle_pause())
            ask(one.session, lambda s: s.control.halt.set("visitor"))
            drop_and_come(opened, one, other, msgspec.msgpack.encode(UNFINISHED) if turn % 2 else b"")
            if turn:
                counts.append(held())
                # Closed connections disappear with a delay.
                other.visitor.wait_for(lambda _: all(map(le, held(), counts[0])), 60.0)
        assert not caplog.records, caplog.text
    assert (ask(other.session, lambda s: s.settings), other.session) == others
    steps = one.session.simulation.steps
    ask(one.session, lambda s: s.control.toggle_pause())
    one.visitor.wait_for(lambda _: one.session.simulation.steps > steps, 60.0)
