"""What the server sends: viser's messages in viser's format, packed once for all browsers that are sent the same."""

from __future__ import annotations

import operator
from collections import deque
from collections.abc import Awaitable, Callable, Sequence

import msgspec
import zstandard
from websockets.asyncio.server import ServerConnection

from app.web.viser_internals import Message, MessageBuffer, append_aligned_buffers, content_of

STAMP = 0.0
"""When a window is sent, as the page reads it [s]. viser's page goes by this clock and holds back what comes early, to even out a
stream; at our rate a drag would wait for up to 40 ms. A clock that stands still lets everything through at once."""


def pack(messages: Sequence[Message]) -> bytes:
    """Return messages as one websocket message, in viser's format: two sizes, zstd-compressed msgpack, raw arrays."""
    arrays: list[memoryview] = []
    content = {
        "messages": tuple(content_of(message, arrays) for message in messages),
        "timestampSec": STAMP,
        "binaryBufferLengths": tuple(array.nbytes for array in arrays),
    }
    inner = msgspec.msgpack.encode(content)
    packed = zstandard.ZstdCompressor(level=1).compress(inner)
    parts: list[bytes | memoryview] = [len(inner).to_bytes(8, "little"), len(packed).to_bytes(8, "little"), packed]
    append_aligned_buffers(parts, arrays, 16 + len(packed))
    return b"".join(parts)


class Packed:
    """A memory of what was packed last, so that what many browsers are sent is packed once."""

    def __init__(self) -> None:
        self._last: deque[tuple[Sequence[Message], bytes]] = deque(maxlen=4)

    def get(self, messages: Sequence[Message]) -> bytes:
        """Return `pack(messages)`."""
        for known, data in self._last:
            if len(known) == len(messages) and all(map(operator.is_, known, messages)):
                return data
        data = pack(messages)
        # The message that creates an element keeps its properties up to date afterwards, so a newcomer may have to be sent another one.
        if all(message.lifecycle_phase != "create" for message in messages):
            self._last.append((messages, data))
        return data


async def _at_once() -> None:
    """Return at once."""


async def send_windows(
    connection: ServerConnection,
    buffer: MessageBuffer,
    client_id: int,
    backlog_done_message: Message | None = None,
    seen: Callable[[], Awaitable[object]] = _at_once,
) -> None:
    """Send one browser what a buffer holds for it, window by window.

    Args:
        seen: returns when the page is in sight. Until then it is sent nothing of a shared buffer, which keeps the newest of everything.
    """
    windows = buffer.window_generator(client_id, backlog_done_message)
    shared: Packed | None = vars(buffer).setdefault("duet_packed", Packed()) if buffer.persistent_messages else None
    try:
        while not buffer.done:
            if shared is not None:
                await seen()
            try:
                messages = await anext(windows)
            except StopAsyncIteration:
                return
            await connection.send(pack(messages) if shared is None else shared.get(messages))
    finally:
        # Its own clean-up must not wait for the garbage collector.
        await windows.aclose()
