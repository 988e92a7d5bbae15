"""What the server sends: viser's messages in viser's format, packed once for everybody who is sent the same."""

from __future__ import annotations

import operator
from collections import deque
from collections.abc import Sequence

import msgspec
import viser.infra._infra as viser_infra
import zstandard
from viser.infra._async_message_buffer import AsyncMessageBuffer
from viser.infra._messages import Message
from websockets.asyncio.server import ServerConnection

STAMP = 0.0
"""When everything is sent, as far as the page is told [s]. viser's page goes by this clock and holds back what comes early, to even out
a stream; at our beat that makes what a hand does wait for up to 40 ms. A clock that stands still lets everything through at once."""


def pack(messages: Sequence[Message]) -> bytes:
    """Return messages as one websocket message, in viser's format: two sizes, zstd-compressed msgpack, raw arrays."""
    arrays: list[memoryview] = []
    content = {
        "messages": tuple(message.as_serializable_dict(arrays) for message in messages),
        "timestampSec": STAMP,
        "binaryBufferLengths": tuple(array.nbytes for array in arrays),
    }
    inner = msgspec.msgpack.encode(content)
    packed = zstandard.ZstdCompressor(level=1).compress(inner)
    parts: list[bytes | memoryview] = [len(inner).to_bytes(8, "little"), len(packed).to_bytes(8, "little"), packed]
    viser_infra._append_aligned_buffers(parts, arrays, 16 + len(packed))
    return b"".join(parts)


class Packed:
    """What was packed last, so that what everybody is sent is packed once, and not once for everybody."""

    def __init__(self) -> None:
        self._last: deque[tuple[Sequence[Message], bytes]] = deque(maxlen=4)

    def get(self, messages: Sequence[Message]) -> bytes:
        """Return `pack(messages)`."""
        for known, data in self._last:
            if len(known) == len(messages) and all(map(operator.is_, known, messages)):
                return data
        data = pack(messages)
        # What makes an element keeps its properties up to date afterwards, so that it may read otherwise for whoever comes later.
        if all(message.lifecycle_phase != "create" for message in messages):
            self._last.append((messages, data))
        return data


async def produce(
    connection: ServerConnection, buffer: AsyncMessageBuffer, client_id: int, backlog_done_message: Message | None = None
) -> None:
    """Send one browser what a buffer holds for it, window by window; stands in for viser's `_message_producer`."""
    windows = buffer.window_generator(client_id, backlog_done_message)
    shared: Packed | None = vars(buffer).setdefault("duet_packed", Packed()) if buffer.persistent_messages else None
    try:
        while not buffer.done:
            try:
                messages = await anext(windows)
            except StopAsyncIteration:
                return
            await connection.send(pack(messages) if shared is None else shared.get(messages))
    finally:
        # Its own clean-up must not wait for the garbage collector.
        await windows.aclose()
