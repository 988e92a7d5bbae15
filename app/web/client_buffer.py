"""What one browser alone is sent, from when it is drawn until it is sent."""

from __future__ import annotations

import contextlib
import threading
from asyncio import AbstractEventLoop, Event
from collections.abc import AsyncGenerator, Callable, Generator, Sequence
from itertools import islice
from time import perf_counter
from typing import Final

from app.web.viser_internals import Message, MessageBuffer

HOLD: Final = 0.004
"""How long a sender may wait for others that are woken with it [s]."""


class _Held(threading.local):
    """Senders that a thread wakes together, by event loop; None while it wakes each at once."""

    events: dict[AbstractEventLoop, list[Event]] | None = None
    since = 0.0


_held: Final = _Held()


@contextlib.contextmanager
def waking_together() -> Generator[None]:
    """While open, the senders of the buffers that this thread flushes are woken together, at its end or every `HOLD`.

    A wake-up is a system call, and the event loop then asks for the interpreter's lock: eight of them take a tenth of a round of eight
    sessions.
    """
    _held.events = {}
    try:
        yield
    finally:
        _wake()
        _held.events = None


def _wake() -> None:
    """Wake the senders that are held."""
    if _held.events:
        for loop, events in _held.events.items():
            # The loop may be closed already, when nothing is sent any more.
            with contextlib.suppress(RuntimeError):
                loop.call_soon_threadsafe(_set_all, events)
        _held.events = {}


def _set_all(events: list[Event]) -> None:
    for event in events:
        event.set()


class ClientBuffer(MessageBuffer):
    """Keeps the newest message of each kind, in the order in which they were pushed, and wakes its sender once a frame.

    viser's own buffer numbers and indexes messages for readers who come later, and wakes its sender up to three times a frame; a
    browser's own buffer has one reader. What is pushed in an atomic block is sent at its end, anything else within
    `window_duration_sec`.

    Args:
        event_loop: of the server.
    """

    def __init__(self, event_loop: AbstractEventLoop) -> None:
        super().__init__(event_loop, persistent_messages=False)
        self._waiting: dict[str, Message] = {}
        self._woken = self._timed = False

    def push(self, message: Message) -> None:
        """Take in a message in place of an older one of the same kind; a connection that is closed takes none."""
        if self.done:
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
        self._call(lambda: self.event_loop.call_later(self.window_duration_sec, self.flush_event.set))

    def remove_entity_state_from_buffer(self, entity_type: str, entity_id: str) -> None:
        """Drop what waits about an element that is about to be replaced."""
        with self.buffer_lock:
            self._forget((entity_type, entity_id), adjacent=True)

    def _forget(self, entity: tuple[str | None, str], adjacent: bool) -> None:
        """Drop updates of an element, and with `adjacent` also what else is said about its name."""
        phases = ("update_dict", "update_simple", None) if adjacent else ("update_dict", "update_simple")
        known = [key for key, one in self._waiting.items() if one.lifecycle_phase in phases and one.entity_state_key() == entity]
        for key in known:
            del self._waiting[key]

    def atomic_end(self) -> None:
        """End an atomic block, and send what was pushed."""
        with self.buffer_lock:
            self.atomic_counter -= 1
            ended = not self.atomic_counter
        if ended:
            self.flush()

    def flush(self) -> None:
        """Wake the sender, unless there is nothing to send or it is awake."""
        with self.buffer_lock:
            if self._woken or not self._waiting:
                return
            self._woken = True
        if _held.events is None:
            self._call(self.flush_event.set)
            return
        now = perf_counter()
        if not _held.events:
            _held.since = now
        _held.events.setdefault(self.event_loop, []).append(self.flush_event)
        if now - _held.since > HOLD:
            _wake()

    def _call(self, function: Callable[[], object]) -> None:
        # The loop may be closed already, when nothing is sent any more.
        with contextlib.suppress(RuntimeError):
            self.event_loop.call_soon_threadsafe(function)

    def window_generator(
        self, client_id: int, backlog_done_message: Message | None = None
    ) -> AsyncGenerator[Sequence[Message], None]:
        """Return what is to be sent, window by window; `backlog_done_message` belongs to buffers with a backlog, which this has not."""
        del backlog_done_message
        return self._windows(client_id)

    async def _windows(self, client_id: int) -> AsyncGenerator[Sequence[Message], None]:
        while not self.done:
            await self.flush_event.wait()
            self.flush_event.clear()
            while window := self._take():
                if found := [message for message in window if message.excluded_self_client != client_id]:
                    yield found

    def _take(self) -> list[Message]:
        """Return the oldest messages that wait; none within an atomic block, which wakes the sender at its end."""
        with self.buffer_lock:
            self._woken = self._timed = False
            if self.atomic_counter:
                return []
            keys = list(islice(self._waiting, self.max_window_size))
            return [self._waiting.pop(key) for key in keys]
