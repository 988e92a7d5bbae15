"""Connections that send too much, read too little, are silent or too many; and uploaded files."""

import itertools
import random
import socket
from contextlib import ExitStack
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest
from websockets.frames import OP_BINARY, Frame

from app.web import traffic_limits
from app.web.connection import FilteredConnection
from app.web.headless_client import CAMERA, HeadlessClient
from app.web.message_gate import Traffic
from app.web.pages import HELLO, OPEN_TOO_OFTEN, ROOM_IS_FULL
from app.web.traffic_limits import Allowance, BoundedQueue, TrafficLimits
from tests.app.page.helpers import notes
from tests.app.viser_private import component_id, live_connections, uploads
from tests.app.web.conftest import Join, Room, Start, ended, get, roundtrip, visiting, write
from tests.blocking_client import BlockingClient

pytestmark = pytest.mark.slow


def test_a_flood_is_slowed_down(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(traffic_limits, "time", SimpleNamespace(monotonic=lambda: 10.0))
    allowance = Allowance(100.0, 50.0)
    pauses = [allowance.spend(1.0, now=10.0) for _ in range(60)]
    assert pauses[:50] == [0.0] * 50 and pauses[50:] == pytest.approx([0.01 * k for k in range(1, 11)])
    assert allowance.spend(1.0, now=20.0) == 0.0
    # The size of messages counts, too.
    limits = TrafficLimits(messages_per_second=100.0, bytes_per_second=1e6)
    small, large = Traffic(limits), Traffic(limits)
    assert [small.pause(10) for _ in range(50)] == [0.0] * 50 and small.pause(10) > 0.0
    assert large.pause(490_000) == 0.0 and large.pause(1_000_000) == pytest.approx(0.99)


def test_the_send_buffer_is_capped_and_a_stalled_reader_is_dropped(start: Start) -> None:
    # Long enough for the client that reads, also on a busy machine.
    server = start(limits=TrafficLimits(stall_seconds=4.0))
    picture = server.gui.add_html("")
    with visiting(server) as witness:
        (live,) = live_connections(server)
        size = live.transport.get_extra_info("socket").getsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF)
        assert size <= 2 * 64 * 1024  # Linux doubles what is asked for
        with BlockingClient(server.url, decode=False) as sleeper:
            sleeper.fall_asleep()
            witness.wait_for(lambda v: server.count_clients() == 2)
            connections = [one for one in server.placed if isinstance(one, FilteredConnection)]
            noise = random.Random(1)
            texts = (noise.randbytes(200_000).hex() for _ in itertools.count())

            def gone(v: HeadlessClient) -> bool:
                # Send until the sleeper's buffers are full.
                if not any(one.stalled for one in connections):
                    picture.content = next(texts)
                return server.count_clients() == 1

            witness.wait_for(gone)
            # A closing handshake would never be answered, as the sleeper reads nothing.
            sleeper.break_off()
        assert witness.closed is None


def test_a_silent_connection_is_closed_unless_it_has_sent_a_message(start: Start) -> None:
    room = Room(start())
    with visiting(room.server) as quiet:
        # It sends a message first; only then is the limit for newcomers lowered.
        roundtrip(quiet, room)
        room.server.limits = TrafficLimits(first_message_seconds=0.3)
        roundtrip(quiet, room)
        with BlockingClient(room.server.url, camera=False) as mute:
            assert ended(mute) == (1008, "nothing said")
        quiet.wait_for(lambda _: room.server.count_clients() == 1)
        roundtrip(quiet, room)


def test_a_place_is_taken_with_the_first_message(start: Start) -> None:
    server = start(max_clients=1, limits=TrafficLimits(silent=3, first_message_seconds=120.0))
    with ExitStack() as opened:

        def silent(number: int) -> BlockingClient:
            return opened.enter_context(
                BlockingClient(server.url, camera=False, query=f"resume={number:032d}")
            )

        first, second, third = map(silent, range(3))
        third.wait_for(lambda _: len(server.holders) == 3)
        assert server.count_clients() == 0 and get(server.url)[0] == 200
        # The oldest silent connection of the address is closed.
        opened.enter_context(visiting(server))
        first.wait_for(lambda v: v.closed)
        third.wait_for(lambda _: server.count_clients() == 1)
        assert get(server.url)[0] == 503
        second.send({"type": HELLO})
        second.send(CAMERA)
        assert ended(second) == (1013, ROOM_IS_FULL) and third.closed is None
        assert server.count_clients() == 1


@pytest.mark.parametrize("query", ["resume=0123456789abcdef", ""], ids=["one tab", "one address"])
def test_connections_are_limited_per_tab_and_per_address(room: Room, join: Join, query: str) -> None:
    eight = [join(query=query) for _ in range(8)]
    with BlockingClient(room.server.url, query=query) as ninth:
        assert ended(ninth) == (1013, OPEN_TOO_OFTEN)
    # A class behind one address is admitted: every page names its own tab.
    pages = [join(query=f"resume=fedcba987654321{number}") for number in range(9)]
    eight[0].wait_for(lambda _: room.server.count_clients() == 17)
    eight.pop().close()
    eight[0].wait_for(lambda _: room.server.count_clients() == 16)
    eight.append(join(query=query))
    assert all(one.closed is None for one in (*eight, *pages))


def parts_of(
    visitor: BlockingClient, size: int, pieces: dict[int, int], parts: int, transfer: str = "t"
) -> list[dict[str, Any]]:
    """Messages of an upload of `size` bytes in `parts` parts. `pieces`: part number → bytes sent."""
    file = {"source_component_uuid": visitor.mirror.labelled("file")["uuid"], "transfer_uuid": transfer}
    announced = {"filename": "a.bvh", "mime_type": "", "part_count": parts, "size_bytes": size}
    sent = [{"part_index": index, "content": b"x" * piece} for index, piece in pieces.items()]
    return [
        {"type": "FileTransferStartUpload", **file, **announced},
        *({"type": "FileTransferPart", **file, **one} for one in sent),
    ]


def upload(
    visitor: BlockingClient, size: int, pieces: dict[int, int], parts: int, transfer: str = "t"
) -> None:
    for message in parts_of(visitor, size, pieces, parts, transfer):
        visitor.send(message)


def test_files_up_to_the_cap_arrive(start: Start) -> None:
    room = Room(start(limits=TrafficLimits(upload_bytes=2_000_000)))
    with visiting(room.server) as visitor:
        upload(visitor, 1_000_000, {0: 524_288, 1: 475_712}, parts=2)
        visitor.wait_for(lambda v: room.values("file") == [1_000_000])
        upload(visitor, 0, {}, parts=0, transfer="empty")
        visitor.wait_for(lambda v: room.values("file") == [1_000_000, 0])
        upload(visitor, 2_000_001, {0: 524_288}, parts=4, transfer="too large")
        visitor.wait_for(lambda v: v.received.messages["NotificationShowMessage"] == 1)
        roundtrip(visitor, room)
        assert uploads(room.server) == {}


@pytest.mark.parametrize(
    ("query", "said"), [("", "up to 2 MB"), ("lang=de", "bis 2 MB"), ("lang=sl", "do 2 MB")]
)
def test_a_file_that_is_too_large_is_refused_in_the_language_of_the_page(
    start: Start, query: str, said: str
) -> None:
    room = Room(start(limits=TrafficLimits(upload_bytes=2_000_000)))
    with visiting(room.server, query=query, camera=False) as visitor:
        # Sent together with the first message: on a busy server both wait at the same time.
        messages = (CAMERA, *parts_of(visitor, 2_000_001, {}, 4))
        write(
            visitor,
            b"".join(Frame(OP_BINARY, msgspec.msgpack.encode(one)).serialize(mask=True) for one in messages),
        )
        visitor.wait_for(lambda _: len(notes(visitor)) == 1)
        assert said in notes(visitor)[0]


def test_unfinished_files_count_and_belong_to_their_sender(start: Start) -> None:
    room = Room(start(limits=TrafficLimits(upload_bytes=2_000_000)))
    buffers, open_uploads = uploads(room.server), room.server.gate._open_uploads
    with visiting(room.server) as visitor, visiting(room.server) as other:
        upload(visitor, 1_500_000, {0: 500_000}, parts=3, transfer="open")
        upload(visitor, 600_000, {0: 500_000}, parts=2, transfer="above the cap together")
        upload(visitor, 100, {0: 200}, parts=1, transfer="more than said")
        roundtrip(visitor, room)
        assert set(buffers) == {"open", "more than said"} and buffers["more than said"]["parts"] == {}
        # A repeated part must not count again, or the counted and the stored parts would differ.
        file = {"source_component_uuid": component_id(room.upload), "transfer_uuid": "open"}
        for index in (0, 0, 7):
            visitor.send({"type": "FileTransferPart", **file, "part_index": index, "content": b"x" * 300_000})
        roundtrip(visitor, room)
        assert "open" in open_uploads and set(buffers["open"]["parts"]) == {0}
        other.send({"type": "FileTransferPart", **file, "part_index": 1, "content": b"spoilt"})
        upload(other, 100, {0: 100}, parts=1, transfer="open")
        roundtrip(other, room)
        assert buffers["open"]["total_bytes"] == 1_500_000 and set(buffers["open"]["parts"]) == {0}
        assert room.values("file") == []
        for number in range(6):
            upload(other, 100_000, {}, parts=1, transfer=f"many {number}")
        roundtrip(other, room)
        assert sum(name.startswith("many") for name in buffers) == 4
        for index in (1, 2):
            visitor.send({"type": "FileTransferPart", **file, "part_index": index, "content": b"x" * 500_000})
        visitor.wait_for(lambda v: room.values("file") == [1_500_000])
    with BlockingClient(room.server.url) as late:
        late.wait_for(lambda v: room.server.count_clients() == 1 and not buffers and not open_uploads)


def test_frequent_connections_leave_room_for_all_others() -> None:
    room = BoundedQueue[int](most=8, of_address=4, of_tab=2)
    assert [room.enter(one, "a", "tab") for one in range(4)] == [None, None, 0, 1], "limit of a tab"
    assert [room.enter(one, "a") for one in range(4, 8)] == [None, None, 2, 3], "limit of an address"
    assert [room.enter(one, f"b{one}") for one in range(8, 13)] == [None, None, None, None, 4], "total limit"
    # A tab may be named later, also by its oldest connection.
    assert (
        room.enter(5, "a", "late") is None
        and room.enter(8, "b8", "late") is None
        and room.enter(6, "a", "late") == 5
    )
    room.leave(8)
    room.leave(8)
    assert list(room) == [6, 7, 9, 10, 11, 12] and len(room) == 6
