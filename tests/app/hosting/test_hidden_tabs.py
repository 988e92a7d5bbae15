"""A hidden or idle tab costs almost nothing, and is up to date at once when it is shown."""

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
    """Number of a page's frames in `seconds`, at 32 rounds per second."""
    given = {"hidden": False, "paused": True, "dirty": False} | kind
    count = 0
    for number in range(round(32 * seconds)):
        now = begin + number * FRAME
        if attention.due(now, given["hidden"], given["paused"], given["dirty"]):
            count += 1
            attention.note(now, state)
    return count


def test_an_active_page_gets_every_frame_and_a_resting_one_few() -> None:
    attention = Attention()
    assert frames(attention, 10.0, 0.0, paused=False) == 320, "a moving run lost frames"
    # It is drawn for some seconds after the pause, because a camera may still move.
    assert frames(attention, LIVELY, 10.0) == 32 * LIVELY
    assert frames(attention, 20.0, 20.0) == pytest.approx(20.0 / RESTING, abs=2)
    assert frames(attention, 1.0, 40.0, dirty=True) == 32
    assert frames(attention, 1.0, 45.0, state=1) >= 31, "a changed state was not drawn"
    assert frames(attention, 1.0, 50.0, paused=False) == 32, "the first frame after a pause was late"


@pytest.mark.parametrize("paused", [True, False])
def test_a_hidden_page_gets_few_frames_and_one_at_once_when_shown(paused: bool) -> None:
    attention = Attention()
    frames(attention, 1.0, 0.0, paused=paused)
    assert frames(attention, 20.0, 1.0, hidden=True, paused=True, dirty=True) == pytest.approx(
        20.0 / UNSEEN, abs=1
    )
    assert frames(attention, 1.0, 21.0, paused=paused) == 32


def drawn(opened: ByHand, seconds: float) -> int:
    """Number of frames of the only visitor in `seconds`."""
    count = 0
    for _ in range(round(seconds / FRAME)):
        opened.frame()
        count += opened.house.context.workload.sessions
    return count


def say(opened: ByHand, visitor: BlockingClient, kind: str) -> None:
    """Send HIDDEN or SHOWN from the page, and wait until the server knows it."""
    server = opened.house.server
    visitor.send({"type": kind})
    until(
        lambda: any(
            (page := server.page_of(number)) and page.hidden == (kind == HIDDEN)
            for number in server.get_clients()
        )
    )


def test_a_hidden_tab_is_not_stepped_or_drawn_and_continues_later(by_hand: Made) -> None:
    opened = by_hand(sessions=3)
    visitor = opened.let_in()
    session = visitor_of(opened).session
    assert drawn(opened, 1.0) == 32 and session.simulation.steps > 0
    say(opened, visitor, HIDDEN)
    opened.frame()
    steps, before = session.simulation.steps, len(session.posts)
    assert drawn(opened, 20.0) <= 20.0 / UNSEEN + 1 and session.simulation.steps == steps and session.paused
    # Queued actions are still done.
    session.post(SetSetting("dm", 0.2))
    drawn(opened, 1.1 * UNSEEN)
    assert len(session.posts) == before == 0 and session.settings.run.law.critical_distance == 0.2
    say(opened, visitor, SHOWN)
    opened.frame()
    assert not session.paused and 0 < session.simulation.steps - steps <= 8, "missed steps were made up"
    assert drawn(opened, 1.0) == 32


def test_a_tab_closed_while_hidden_reconnects_to_a_moving_session(by_hand: Made) -> None:
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


def test_a_paused_page_rests_until_its_visitor_acts(by_hand: Made) -> None:
    opened = by_hand(sessions=3)
    visitor = opened.let_in()
    session = visitor_of(opened).session
    assert drawn(opened, 2.0 * LIVELY) == 64 * LIVELY, "the autopilot's run lost frames"
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
