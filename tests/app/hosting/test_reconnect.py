"""Broken connections: a reconnected tab has its former state, and other tabs are not affected."""

import gc
import os
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import pytest

from app.session.session import Session
from app.settings import Settings
from app.start import App
from scenes.settings import changed
from tests.app.conftest import Made, OpenHouse, ask, live_sessions, private_of
from tests.app.page.helpers import page_label
from tests.blocking_client import BlockingClient

WORD = "0123456789abcdef0123456789abcdef"


class Tab:
    def __init__(self, opened: App, link: str, word: str = WORD) -> None:
        self.opened, self.query, self.number = opened, f"{link}&resume={word}", -1
        self.visitor: BlockingClient = self.come()

    def come(self) -> BlockingClient:
        before = set(live_sessions(self.opened))
        visitor = self.visitor = BlockingClient(self.opened.url, query=self.query)
        visitor.wait_for(lambda _: set(live_sessions(self.opened)) - before, 60.0)
        (self.number,) = set(live_sessions(self.opened)) - before
        visitor.wait_for(
            lambda v: len(v.mirror.commands) >= 14 and any(n.endswith("/base") for n in list(v.mirror.nodes)),
            60.0,
        )
        return visitor

    @property
    def session(self) -> Session:
        return live_sessions(self.opened)[self.number]

    def cut(self, unfinished: bytes = b"") -> None:
        """Break the connection without a closing handshake, also within a message."""
        self.visitor.break_off(unfinished)
        with suppress(Exception):
            self.visitor.close()

    def remembered(self) -> dict[str, Any]:
        def look(session: Session) -> dict[str, Any]:
            now, ghost = session.simulation, session.ghost
            return {
                "settings": (session.settings, session.paused),
                "parts": session.parts.saved(),
                "state": (now.steps, now.time, now.positions.tobytes(), now.velocities.tobytes()),
                "history": now.history.table().tobytes(),
                "ghost": None if ghost is None else (ghost.settings, ghost.steps, ghost.positions.tobytes()),
            }

        return ask(self.session, look)


@pytest.fixture
def tab(request: pytest.FixtureRequest) -> Callable[..., Tab]:
    def make(opened: App, link: str = "", word: str = WORD) -> Tab:
        one = Tab(opened, link, word)
        request.addfinalizer(lambda: one.visitor.close())
        return one

    return make


def held() -> tuple[int, int]:
    """Numbers of this process's open files and threads."""
    gc.collect()
    return len(os.listdir("/proc/self/fd")) if os.path.isdir("/proc/self/fd") else 0, threading.active_count()


def test_a_reconnected_tab_without_lessons_has_its_settings_and_run(
    house: OpenHouse, tab: Callable[..., Tab]
) -> None:
    opened = house()
    one = tab(opened, "n=8")
    one.visitor.set_value(page_label("dm"), 210.0)
    one.visitor.wait_for(
        lambda _: one.session.settings.run.law.critical_distance == pytest.approx(0.21), 60.0
    )
    begin = one.session.simulation.time
    one.visitor.wait_for(lambda _: one.session.simulation.time > begin + 1.0, 60.0)
    session, time = one.session, one.session.simulation.time
    one.visitor.pull(max(one.visitor.mirror.grabbable, key=len), "start", [0.3, 0.0, 1.0], [0.3, 0.0, 1.1])
    one.visitor.wait_for(lambda _: session.held is not None, 60.0)
    one.cut()
    one.come()
    assert one.session is session and session.held is None
    # Taking hold of the hand switches the autopilot off.
    expected = changed(changed(changed(Settings(), "n", 8.0), "dm", 0.21), "autopilot", False)
    assert session.simulation.time >= time and session.settings == expected
    slider = page_label("dm"), "GuiSliderMessage"
    one.visitor.wait_for(lambda v: v.mirror.labelled(*slider)["value"] == pytest.approx(210.0), 60.0)
    # Another link in the same tab starts a new session.
    one.query = f"n=9&resume={WORD}"
    one.cut()
    one.come()
    assert one.session is not session and one.session.settings == changed(Settings(), "n", 9.0)
    assert not opened.context.store.parked


def test_a_tab_that_reconnects_early_continues_from_the_live_state(
    house: OpenHouse, tab: Callable[..., Tab]
) -> None:
    opened = house()
    one = tab(opened, "n=8")
    session = one.session
    ask(session, lambda s: [s.change("ghost", "frozen"), s.change("dm", 0.2)])
    one.visitor.wait_for(lambda _: session.simulation.time > 0.5, 60.0)
    ask(session, lambda s: s.control.toggle_pause())
    before, old = one.remembered(), one.visitor
    one.come()
    assert one.session is not session
    after = one.remembered()
    assert all(after[key] == before[key] for key in ("settings", "state", "ghost"))
    old.close()
    one.visitor.wait_for(lambda _: len(live_sessions(opened)) == 1, 60.0)
    assert not opened.context.store.parked  # the new session has taken over its state
    one.cut()
    one.come()
    assert one.remembered() == after


def test_a_doubled_tab_does_not_undo_the_later_ones_changes(by_hand: Made) -> None:
    opened = by_hand(sessions=8)
    host, link = private_of(opened), f"n=8&resume={WORD}"
    opened.let_in(link)
    second = opened.let_in(link)
    first, session = (one.session for one in host.visitors.values())
    session.change("dm", 0.2)
    session.reset()
    settings, steps = session.settings, first.simulation.steps
    assert steps > 0
    opened.leave(second)
    opened.let_in(link)
    assert [one.session for one in host.visitors.values()] == [
        first,
        session,
    ] and session.settings == settings
    assert session.simulation.steps < steps
