"""Files from a page: up to the cap they arrive, and unfinished ones count and belong to their sender."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import pytest
from websockets.frames import OP_BINARY, Frame

from app.bench.blocking_client import BlockingClient
from app.bench.headless_client import CAMERA
from app.web.server import DuetServer
from app.web.traffic_limits import TrafficLimits
from tests.app.page.helpers import notes
from tests.app.web.conftest import Room, roundtrip, visiting, write


def announcement(visitor: BlockingClient, size: int, *, parts: int, transfer: str = "t") -> dict[str, Any]:
    """The message before a file of `size` bytes in `parts` parts."""
    file = {"source_component_uuid": visitor.mirror.labelled("file")["uuid"], "transfer_uuid": transfer}
    announced = {"filename": "a.bvh", "mime_type": "", "part_count": parts, "size_bytes": size}
    return {"type": "FileTransferStartUpload", **file, **announced}


def upload(visitor: BlockingClient, size: int, pieces: dict[int, int], *, parts: int, transfer: str = "t") -> None:
    """Announce a file of `size` bytes in `parts` parts, then send the pieces, part number → number of bytes."""
    visitor.send(announcement(visitor, size, parts=parts, transfer=transfer))
    file = {"source_component_uuid": visitor.mirror.labelled("file")["uuid"], "transfer_uuid": transfer}
    for index, piece in pieces.items():
        visitor.send({"type": "FileTransferPart", **file, "part_index": index, "content": b"x" * piece})


def test_files_up_to_the_cap_arrive(start: Callable[..., DuetServer]) -> None:
    room = Room(start(limits=TrafficLimits(upload_bytes=2_000_000)))
    with visiting(room.server) as visitor:
        upload(visitor, 1_000_000, {0: 524_288, 1: 475_712}, parts=2)
        visitor.wait_for(lambda v: room.values("file") == [1_000_000])
        upload(visitor, 0, {}, parts=0, transfer="empty")
        visitor.wait_for(lambda v: room.values("file") == [1_000_000, 0])
        upload(visitor, 2_000_001, {0: 524_288}, parts=4, transfer="too large")
        visitor.wait_for(lambda v: v.received.messages["NotificationShowMessage"] == 1)
        roundtrip(visitor, room)
        assert room.server.gui._current_file_upload_states == {}


@pytest.mark.parametrize(("query", "said"), [("", "up to 2 MB"), ("lang=de", "bis 2 MB"), ("lang=sl", "do 2 MB")])
def test_a_file_that_is_too_large_is_refused_in_the_language_of_the_page(
    start: Callable[..., DuetServer], query: str, said: str
) -> None:
    room = Room(start(limits=TrafficLimits(upload_bytes=2_000_000)))
    with visiting(room.server, query=query, camera=False) as visitor:
        # In one piece with the first message: on a busy server they wait side by side.
        messages = (CAMERA, announcement(visitor, 2_000_001, parts=4))
        write(visitor, b"".join(Frame(OP_BINARY, msgspec.msgpack.encode(one)).serialize(mask=True) for one in messages))
        visitor.wait_for(lambda _: len(notes(visitor)) == 1)
        assert said in notes(visitor)[0]


def test_unfinished_files_count_and_belong_to_their_sender(start: Callable[..., DuetServer]) -> None:
    room = Room(start(limits=TrafficLimits(upload_bytes=2_000_000)))
    buffers = room.server.gui._current_file_upload_states
    with visiting(room.server) as visitor, visiting(room.server) as other:
        upload(visitor, 1_500_000, {0: 500_000}, parts=3, transfer="open")
        upload(visitor, 600_000, {0: 500_000}, parts=2, transfer="above the cap together")
        upload(visitor, 100, {0: 200}, parts=1, transfer="more than said")
        roundtrip(visitor, room)
        assert set(buffers) == {"open", "more than said"} and buffers["more than said"]["parts"] == {}
        # The same part again must not count as another one, or what is counted and what is stored would differ.
        file = {"source_component_uuid": room.upload._impl.uuid, "transfer_uuid": "open"}
        for index in (0, 0, 7):
            visitor.send({"type": "FileTransferPart", **file, "part_index": index, "content": b"x" * 300_000})
        roundtrip(visitor, room)
        assert "open" in room.server.gate._open_uploads and set(buffers["open"]["parts"]) == {0}
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
        late.wait_for(lambda v: room.server.count_clients() == 1 and not buffers and not room.server.gate._open_uploads)
