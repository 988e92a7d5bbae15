"""Visitors who send too much, read too little, or come and go: the server slows them down, lets them go, and keeps nothing."""

from __future__ import annotations

import gc
import itertools
import os
import random
import socket
import threading
import weakref
from collections.abc import Callable

import pytest
import viser

from app.bench.blocking_client import BlockingClient
from app.bench.headless_client import HeadlessClient
from app.web.allowance import Allowance
from app.web.message_gate import Traffic
from app.web.server import DuetServer
from app.web.traffic_limits import TrafficLimits
from tests.app.web.conftest import Room, roundtrip


def test_a_flood_is_slowed_down() -> None:
    allowance = Allowance(100.0, 50.0)
    pauses = [allowance.spend(1.0, now=10.0) for _ in range(60)]
    assert pauses[:50] == [0.0] * 50 and pauses[50:] == pytest.approx([0.01 * k for k in range(1, 11)])
    assert allowance.spend(1.0, now=20.0) == 0.0


def test_messages_count_by_their_size_too() -> None:
    limits = TrafficLimits(messages_per_second=100.0, bytes_per_second=1e6)
    small, large = Traffic(limits), Traffic(limits)
    assert [small.pause(10) for _ in range(50)] == [0.0] * 50 and small.pause(10) > 0.0
    assert large.pause(490_000) == 0.0 and large.pause(1_000_000) == pytest.approx(0.99, abs=0.05)


def test_send_buffer_is_capped_and_a_stalled_reader_is_let_go(start: Callable[..., DuetServer]) -> None:
    server = start(limits=TrafficLimits(stall_seconds=0.5))
    picture = server.gui.add_html("")
    with BlockingClient(server.url) as witness:
        witness.wait_for(lambda v: v.mirror.replayed)
        (live,) = server._websock_server._live_connections.values()
        size = live.transport.get_extra_info("socket").getsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF)
        assert size <= 2 * 64 * 1024  # Linux doubles what is asked for
        with BlockingClient(server.url, decode=False, read_pause=1000.0) as sleeper:
            witness.wait_for(lambda v: server.count_clients() == 2)
            noise = random.Random(1)
            texts = (noise.randbytes(200_000).hex() for _ in itertools.count())

            def gone(v: HeadlessClient) -> bool:
                picture.content = next(texts)
                return server.count_clients() == 1

            witness.wait_for(gone)
            assert sleeper.visitor._socket is not None
        assert witness.closed is None


@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="counts through /proc, which only Linux has")
def test_fifty_visits_leave_nothing_behind(room: Room, join: Callable[..., BlockingClient]) -> None:
    handles: weakref.WeakSet[viser.ClientHandle] = weakref.WeakSet()

    @room.server.on_client_connect
    async def _(client: viser.ClientHandle) -> None:
        client.gui.add_slider("mine", min=0.0, max=1.0, step=0.1, initial_value=0.0)
        client.scene.add_frame("/mine")
        handles.add(client)

    def visit() -> None:
        with BlockingClient(room.server.url) as visitor:
            visitor.wait_for(lambda v: "/mine" in v.mirror.nodes)

    def count() -> tuple[int, int, int]:
        gc.collect()
        return len(os.listdir("/proc/self/fd")), threading.active_count(), len(room.server._websock_server._live_connections)

    witness = join()
    visit()
    witness.wait_for(lambda v: room.server.count_clients() == 1)
    before = count()
    for _visit in range(50):
        visit()
    witness.wait_for(lambda v: room.server.count_clients() == 1)
    roundtrip(witness, room)
    assert count() == before
    assert len(handles) <= 2  # the witness, and one that a local variable of the loop may still hold
    assert len(room.server.get_clients()) == 1
    assert len(room.server.scene._active_transform_drag_handles) == 0
