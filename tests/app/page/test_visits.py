"""Visitors who come and go: the ninth is turned away kindly, fifty leave nothing behind, and a closed tab is no news."""

import gc
import os
import threading
import urllib.error
import urllib.request

import pytest
import websockets

from app.bench.blocking_client import BlockingClient
from app.session.session import Session
from app.web.index_page import ROOM_IS_FULL
from tests.app.conftest import HAND, Arrive, OpenHouse, live_sessions
from tests.app.page.helpers import assert_sound


def fetch(url: str) -> tuple[int, str]:
    try:
        with urllib.request.urlopen(url, timeout=60) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def test_the_ninth_visitor_is_turned_away_kindly(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    assert fetch(opened.url)[0] == 200
    guests = [arrive(opened) for _ in range(8)]
    status, text = fetch(opened.url)
    assert status == 503 and "Every place is taken" in text and "8 places" in text
    with BlockingClient(opened.url) as ninth:
        ninth.wait_for(lambda v: v.closed)
        assert ninth.closed is not None and ninth.closed.rcvd is not None and ninth.closed.rcvd.reason == ROOM_IS_FULL
    for guest in guests:
        guest.run_on(0.02)
    guests[0].visitor.close()
    guests[1].wait(lambda _: opened.server.count_clients() == 7)
    assert fetch(opened.url)[0] == 200
    assert arrive(opened).number not in {guest.number for guest in guests}


@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="counts through /proc, which only Linux has")
def test_fifty_visits_leave_nothing_behind(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()

    def visit(number: int) -> None:
        with BlockingClient(opened.url, query=f"seed={number}") as visitor:
            visitor.wait_for(lambda v: HAND in v.mirror.nodes)
            if number % 3 == 0:
                visitor.move_gizmo(HAND, phase="start")

    def count() -> tuple[int, int, int]:
        gc.collect()
        sessions = sum(isinstance(thing, Session) for thing in gc.get_objects())
        return len(os.listdir("/proc/self/fd")), threading.active_count(), sessions

    def alone(_: Session) -> bool:
        return opened.server.count_clients() == 1 and set(live_sessions(opened)) == {witness.number}

    witness = arrive(opened)
    visit(0)
    witness.wait(alone)
    witness.run_on(0.05)
    before = count()
    for number in range(50):
        visit(number)
    witness.wait(alone)
    # Local variables of the frame loop may hold the last one until the next frame.
    witness.run_on(0.1)
    after = count()
    assert after[:2] == before[:2] and after[2] <= before[2] + 1
    assert_sound(witness)


def test_a_message_for_a_closed_tab_is_no_news(house: OpenHouse, arrive: Arrive, caplog: pytest.LogCaptureFixture) -> None:
    opened = house()
    witness = arrive(opened)
    for _ in range(10):
        arrive(opened).visitor.close()
    witness.wait(lambda _: set(live_sessions(opened)) == {witness.number})
    witness.run_on(0.1)
    assert [record.getMessage() for record in caplog.records if record.exc_info] == []
    with pytest.raises(websockets.InvalidStatus):
        BlockingClient(opened.url, origin="https://evil.example")
