"""Who may hold how many connections, and for how long without a word."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from app.bench.blocking_client import BlockingClient
from app.web.index_page import OPEN_TOO_OFTEN
from app.web.server import DuetServer
from app.web.traffic_limits import TrafficLimits
from tests.app.web.conftest import Room, furnish, roundtrip


def ended(visitor: BlockingClient) -> tuple[int, str]:
    """Code and reason of the server's closing."""
    visitor.wait_for(lambda v: v.closed)
    assert visitor.closed is not None and visitor.closed.rcvd is not None
    return visitor.closed.rcvd.code, visitor.closed.rcvd.reason


def test_a_connection_that_says_nothing_is_closed_and_one_that_falls_silent_is_not(start: Callable[..., DuetServer]) -> None:
    room = furnish(start(limits=TrafficLimits(first_message_seconds=0.3)))
    with BlockingClient(room.server.url) as quiet:
        quiet.wait_for(lambda v: v.mirror.replayed)
        with BlockingClient(room.server.url, camera=False) as mute:
            assert ended(mute) == (1008, "nothing said")
        quiet.wait_for(lambda _: room.server.count_clients() == 1)
        roundtrip(quiet, room)


@pytest.mark.parametrize("query", ["resume=0123456789abcdef", ""], ids=["one tab", "one address"])
def test_a_tab_has_so_many_connections_and_an_address_for_programs(
    room: Room, join: Callable[..., BlockingClient], query: str
) -> None:
    eight = [join(query=query) for _ in range(8)]
    with BlockingClient(room.server.url, query=query) as ninth:
        assert ended(ninth) == (1013, OPEN_TOO_OFTEN)
    # A class behind one address is let in: every page names its own tab.
    pages = [join(query=f"resume=fedcba987654321{number}") for number in range(9)]
    eight.pop().close()
    eight[0].wait_for(lambda _: room.server.count_clients() == 16)
    eight.append(join(query=query))
    assert all(one.closed is None for one in (*eight, *pages))
