"""A lost connection in the middle of a lesson."""

import logging
from operator import le

import msgspec
import pytest

from app.features.lessons.bookmark import Phase
from app.start import App
from tests.app.conftest import OpenHouse, ask, live_sessions
from tests.app.features.lessons.helpers import lessons_of
from tests.app.hosting.test_reconnect import WORD, Tab, held
from tests.app.page.helpers import buttons, click


@pytest.mark.thorough
def test_four_dropped_connections_lose_nothing(
    house: OpenHouse, request: pytest.FixtureRequest, caplog: pytest.LogCaptureFixture
) -> None:
    def tab(opened: App, link: str, word: str = WORD) -> Tab:
        one = Tab(opened, link, word)
        request.addfinalizer(lambda: one.visitor.close())
        return one

    opened = house()
    other = tab(opened, "dm=0.2", WORD[::-1])
    one = tab(opened, "lesson=3&step=2")
    # An answer, a run that has been seen, settings that are not the lesson's, and a ghost.
    click(one.visitor, "2 ")
    one.visitor.wait_for(lambda v: "Run" in buttons(v), 60.0)
    ask(one.session, lambda s: s.change("speed", 2.0))
    click(one.visitor, "Run")
    one.visitor.wait_for(lambda _: lessons_of(one).walk.phase is Phase.OBSERVE, 120.0)
    ask(one.session, lambda s: [s.change("dm", 0.11), s.change("ghost", "frozen"), s.change("dm", 0.12)])
    others = ask(other.session, lambda s: s.settings), other.session
    with caplog.at_level(logging.WARNING):
        caplog.clear()
        counts: list[tuple[int, int]] = []
        for turn in range(4):
            session = one.session
            if turn == 2:
                click(one.visitor, "Next")
                one.visitor.wait_for(lambda _: lessons_of(one).walk.phase is Phase.EXPLAIN, 60.0)
            if turn == 3:
                ask(session, lambda s: s.control.toggle_pause())
            ask(session, lambda s: s.control.halt.set("visitor"))
            before = one.remembered()
            message = msgspec.msgpack.encode(
                {"type": "GuiUpdateMessage", "uuid": "of nothing", "updates": {"value": 1.0}}
            )
            one.cut(message if turn % 2 else b"")
            other.visitor.wait_for(
                lambda _: len(live_sessions(opened)) == 1 and len(opened.context.store.parked) == 1, 60.0
            )
            one.come()
            assert one.session is session and not opened.context.store.parked
            assert one.remembered() == before
            if turn:
                counts.append(held())
                # What is closed is gone a moment later.
                other.visitor.wait_for(lambda _: all(map(le, held(), counts[0])), 60.0)
        assert not caplog.records, caplog.text
    assert (ask(other.session, lambda s: s.settings), other.session) == others
    steps = one.session.simulation.steps
    ask(one.session, lambda s: s.control.toggle_pause())
    one.visitor.wait_for(lambda _: one.session.simulation.steps > steps, 60.0)
