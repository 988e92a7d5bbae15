"""Sends once a frame, packed once for all browsers."""

from __future__ import annotations

import contextlib
import operator
import threading
from asyncio import AbstractEventLoop, Event
from collections import deque
from collections.abc import AsyncGenerator, Awaitable, Callable, Generator, Sequence
from itertools import islice
from time import perf_counter
from typing import Any, Final

import msgspec
import zstandard
from websockets.asyncio.server import ServerConnection

from app.web.entries import Entries
from app.web.viser_internals import Message, MessageBuffer, append_aligned_buffers, content_of, stamp_value

STAMP = 0.0
"""Constant time stamp of windows [s]: viser's page would delay a drag by up to 40 ms to even out the
stream."""


class _Compressor(threading.local):
    """One per thread: making one takes four times as long as compressing a frame."""

    def __init__(self) -> None:
        self.compress = zstandard.ZstdCompressor(level=1).compress


_compressor: Final = _Compressor()


def pack(messages: Sequence[Message]) -> bytes:
    """Messages as one websocket message in viser's format: two sizes, zstd-compressed msgpack, raw arrays."""
    arrays: list[memoryview] = []
    content = {
        "messages": tuple(content_of(message, arrays) for message in messages),
        "timestampSec": STAMP,
        "binaryBufferLengths": tuple(array.nbytes for array in arrays),
    }
    inner = msgspec.msgpack.encode(content, enc_hook=_plain_text)
    packed = _compressor.compress(inner)
    parts: list[bytes | memoryview] = [
        len(inner).to_bytes(8, "little"),
        len(packed).to_bytes(8, "little"),
        packed,
    ]
    append_aligned_buffers(parts, arrays, 16 + len(packed))
    return b"".join(parts)


def _plain_text(value: object) -> str:
    """Raises `NotImplementedError` unless the value is a text."""
    if isinstance(value, str):
        return str(value)
    raise NotImplementedError(f"a message cannot hold {type(value)}")


class Packed:
    """Cache for many browsers."""

    def __init__(self) -> None:
        self._last: deque[tuple[Sequence[Message], bytes]] = deque(maxlen=4)

    def get(self, messages: Sequence[Message]) -> bytes:
        for known, data in self._last:
            if len(known) == len(messages) and all(map(operator.is_, known, messages)):
                return data
        data = pack(messages)
        # viser updates the properties in the message that creates an element, so a newcomer may need another
        # one.
        if all(message.lifecycle_phase != "create" for message in messages):
            self._last.append((messages, data))
        return data


async def send_windows(
    connection: ServerConnection,
    buffer: MessageBuffer,
    client_id: int,
    backlog_done_message: Message | None,
    seen: Callable[[], Awaitable[object]],
) -> None:
    """Send one browser the content of a buffer, window by window.

    `seen`: returns once the page is shown; until then a shared buffer keeps the newest of everything.
    """
    windows = buffer.window_generator(client_id, backlog_done_message)
    shared: Packed | None = (
        vars(buffer).setdefault("duet_packed", Packed()) if buffer.persistent_messages else None
    )
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


HOLD: Final = 0.008
"""Longest wait of a sender for others [s]."""


class _Held(threading.local):
    """Senders to wake together, by event loop; None to wake each at once."""

    events: dict[AbstractEventLoop, list[Event]] | None = None
    since = 0.0


_held: Final = _Held()


@contextlib.contextmanager
def waking_together() -> Generator[None]:
    """Context that wakes the senders of flushed buffers together, at the end or every `HOLD`: eight
    separate wake-ups take a tenth of a round of eight sessions."""
    _held.events = {}
    try:
        yield
    finally:
        _wake()
        _held.events = None


def _wake() -> None:
    if _held.events:
        for loop, events in _held.events.items():
            _call(loop, _set_all, events)
        _held.events = {}


def _call(loop: AbstractEventLoop, function: Callable[..., object], *arguments: Any) -> None:
    with contextlib.suppress(RuntimeError):
        loop.call_soon_threadsafe(function, *arguments)


def _set_all(events: list[Event]) -> None:
    for event in events:
        event.set()


class ClientBuffer(MessageBuffer):
    """Keeps the newest message of each kind in the order of the pushes, and wakes its sender once a frame
    (viser: up to three times). An atomic block is sent at its end, anything else within
    `window_duration_sec`."""

    def __init__(self, event_loop: AbstractEventLoop) -> None:
        super().__init__(event_loop, persistent_messages=False)
        self.entries = Entries()
        self._waiting: dict[str, Message] = {}
        self._woken = self._timed = False

    def push(self, message: Message) -> None:
        """Replace a message of the same kind. Dropped if the connection is closed, an entry waits, or the
        message is for other browsers.
        """
        # viser repeats a browser's move for the others; here it would replace our answer to it.
        if self.done or message.excluded_self_client is not None or not stamp_value(message, self.entries):
            return
        key = message.redundancy_key()
        with self.buffer_lock:
            if message.lifecycle_phase == "remove" and message.entity_id_field is not None:
                self._forget((message.entity_type, getattr(message, message.entity_id_field)), adjacent=False)
            self._waiting.pop(key, None)
            self._waiting[key] = message
            if self.atomic_counter or self._timed:
                return
            self._timed = True
        _call(self.event_loop, self.event_loop.call_later, self.window_duration_sec, self.flush_event.set)

    def remove_entity_state_from_buffer(self, entity_type: str, entity_id: str) -> None:
        with self.buffer_lock:
            self._forget((entity_type, entity_id), adjacent=True)

    def _forget(self, entity: tuple[str | None, str], adjacent: bool) -> None:
        """Drop updates of an element, and with `adjacent` also other messages about its name."""
        phases = ("update_dict", "update_simple", None) if adjacent else ("update_dict", "update_simple")
        known = [
            key
            for key, one in self._waiting.items()
            if one.lifecycle_phase in phases and one.entity_state_key() == entity
        ]
        for key in known:
            del self._waiting[key]

    def atomic_end(self) -> None:
        with self.buffer_lock:
            self.atomic_counter -= 1
            ended = not self.atomic_counter
        if ended:
            self.flush()

    def flush(self) -> None:
        with self.buffer_lock:
            if self._woken or not self._waiting:
                return
            self._woken = True
        if _held.events is None:
            _call(self.event_loop, self.flush_event.set)
            return
        now = perf_counter()
        if not _held.events:
            _held.since = now
        _held.events.setdefault(self.event_loop, []).append(self.flush_event)
        if now - _held.since > HOLD:
            _wake()

    async def window_generator(
        self, client_id: int, backlog_done_message: Message | None = None
    ) -> AsyncGenerator[Sequence[Message], None]:
        """The arguments are unused: this buffer has one browser and no backlog."""
        while not self.done:
            await self.flush_event.wait()
            self.flush_event.clear()
            while window := self._take():
                yield window

    def _take(self) -> list[Message]:
        """Oldest waiting messages; empty within an atomic block."""
        with self.buffer_lock:
            self._woken = self._timed = False
            if self.atomic_counter:
                return []
            keys = list(islice(self._waiting, self.max_window_size))
            return [self._waiting.pop(key) for key in keys]
