"""One browser's connection, filtered and limited."""

from __future__ import annotations

import asyncio
import logging
import socket
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import Any, Final, NoReturn, Protocol

import msgspec
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed
from websockets.frames import OP_BINARY, OP_CONT, OP_TEXT, Frame
from websockets.http11 import Response

from app.runtime.throttled_log import ThrottledLog
from app.web.entries import Entries
from app.web.message_gate import Gate, Traffic
from app.web.pages import HELLO, HIDDEN, QUESTION, SHOWN
from app.web.plain_http import RequestHead
from app.web.schemas import Malformed, Refused
from app.web.sending import ClientBuffer, pack, send_windows
from app.web.traffic_limits import TrafficLimits
from app.web.viser_internals import Message, MessageBuffer

log = logging.getLogger("duet.server")

SEND_BUFFER_BYTES: Final = 64 * 1024
READ_BYTES: Final = 16 * 1024
"""Size of one read [bytes]; other browsers wait while its frames are parsed."""

_SMALL_FRAME_BYTES: Final = 1000
_HELLO: Final = msgspec.msgpack.encode({"type": HELLO})
_SIGHT: Final = {msgspec.msgpack.encode({"type": kind}): kind == SHOWN for kind in (HIDDEN, SHOWN)}
"""Message of a tab → True if it is shown."""

_QUESTION: Final = msgspec.msgpack.encode({"type": QUESTION})
_ANSWER: Final = pack(())

BufferChoice = Callable[[ServerConnection, int, MessageBuffer], AbstractContextManager[MessageBuffer]]
"""Buffer of a client id in place of the server's shared one."""


class ConnectionOwner(Protocol):
    """Server of a connection, see `app.web.server.DuetServer`."""

    limits: TrafficLimits
    gate: Gate
    log: ThrottledLog
    is_at_work: Callable[[], bool]
    shared_buffer: BufferChoice

    def client_id(self, connection: ServerConnection) -> int: ...

    async def place(self, connection: ServerConnection) -> str:
        """Give a place; reason for a refusal, or ""."""
        ...

    def explain(self, client_id: int, connection: ServerConnection, refused: Refused) -> None:
        """Explain a refusal that the visitor can act on."""


class FilteredConnection(ServerConnection):
    """Connection that passes on what the gate admits, and drops slow readers.

    Attributes:
        received, heard: numbers of messages received, and passed on.
        is_page: True once it has identified itself as our page; a program need not.
    """

    def __init__(self, owner: ConnectionOwner, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.duet = owner
        self.traffic = Traffic(owner.limits)
        self.head = RequestHead()
        self.is_page = self._said_all = False
        self.heard = 0
        self.received, self._entries = 0, Entries()
        self._seen = asyncio.Event()
        self._seen.set()
        self._client_id: int | None = None
        self._ending: asyncio.Task[None] | None = None
        self.stalled: asyncio.TimerHandle | None = None
        self._head_timer: asyncio.TimerHandle | None = None

    @property
    def hidden(self) -> bool:
        """From any thread."""
        return not self._seen.is_set()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        # Data in the system's buffer is stale by the time it is drawn.
        transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER_BYTES)
        setattr(transport, "max_size", READ_BYTES)  # noqa: B010  (of asyncio's transports over sockets; type checkers don't know it)
        super().connection_made(transport)
        self._head_timer = self.loop.call_later(self.duet.limits.head_seconds, self.transport.abort)

    def connection_lost(self, exc: Exception | None) -> None:
        self._end_stall()
        self._end_head_timer()
        self.duet.gate.forget(self.traffic)
        super().connection_lost(exc)

    def pause_writing(self) -> None:
        # Pings queue behind unread data, so the library's keep-alive never notices a closed laptop.
        self.stalled = self.loop.call_later(self.duet.limits.stall_seconds, self.transport.abort)
        super().pause_writing()

    def resume_writing(self) -> None:
        self._end_stall()
        super().resume_writing()

    def _end_stall(self) -> None:
        if self.stalled is not None:
            self.stalled.cancel()
            self.stalled = None

    def _end_head_timer(self) -> None:
        if self._head_timer is not None:
            self._head_timer.cancel()
            self._head_timer = None

    @property
    def address(self) -> str:
        """Address of the browser; "" if unknown."""
        peer = self.remote_address
        return str(peer[0]) if peer else ""

    @property
    def _who(self) -> str:
        return f"client {self._client_id} from {self.address or 'unknown'}"

    def data_received(self, data: bytes) -> None:
        if not self.head.complete:
            data = self.head.take(data)
            if self.head.complete:
                self._end_head_timer()
        elif self.response is None:
            # The rest of a request that is not answered yet, such as its body.
            return
        super().data_received(data)

    def eof_received(self) -> bool | None:  # type: ignore[override]
        if not self.head.complete or self.response is not None:
            return super().eof_received()
        self._said_all = True
        return True

    def answer(self, response: Response) -> Response:
        """Response to send, also to a program that has closed its end."""
        if self._said_all:
            self.loop.call_soon(self.transport.close)
        return self.head.answer(response)

    def process_event(self, event: Any) -> None:
        super().process_event(event)
        if not isinstance(event, Frame) or len(event.data) >= _SMALL_FRAME_BYTES:
            return
        if event.fin and event.opcode in (OP_TEXT, OP_BINARY, OP_CONT):
            return
        # The library answers pings by itself, and bounds the bytes of a message but not the number of its
        # pieces.
        if self._ending is None and not self.traffic.takes_small_frame():
            self.duet.log.warning("connection closed", f"{self._who} sends too many small frames")
            self._ending = self.loop.create_task(self.close(1008, "too many small frames"))

    async def recv(self, decode: bool | None = None) -> Any:
        duet = self.duet
        while True:
            # viser handles a message in a task that began before this.
            self.loop.call_soon(self._entries.deal, self.received)
            try:
                # A connection that is only held open is closed.
                async with asyncio.timeout(None if self.received else duet.limits.first_message_seconds):
                    raw = await super().recv(decode)
            except TimeoutError:
                await self._end("nothing said")
            self.received += 1
            pause = self.traffic.pause(len(raw))
            if pause > 0.0:
                duet.log.warning("slowed down", f"{self._who} sends too fast")
                await asyncio.sleep(pause)
            if raw == _QUESTION:
                if duet.is_at_work():
                    await self.send(_ANSWER)
                continue
            if raw == _HELLO:
                self.is_page = True
                continue
            if isinstance(raw, bytes) and raw in _SIGHT:
                if _SIGHT[raw]:
                    self._seen.set()
                else:
                    self._seen.clear()
                continue
            if self._client_id is None:
                self._client_id = duet.client_id(self)
            try:
                duet.gate.check(self._client_id, self.traffic, raw)
                reason = "" if self.heard else await duet.place(self)
                if reason:
                    await self._end(reason, 1013)
                self.heard += 1
                return raw
            except Refused as refused:
                duet.log.warning(f"message dropped ({refused.kind})", self._who)
                # After viser has handled the earlier messages: it does not know a browser before its first
                # one.
                self.loop.call_soon(duet.explain, self._client_id, self, refused)
            except Malformed as malformed:
                await self._end(f"malformed message ({malformed})")

    async def _end(self, reason: str, code: int = 1008) -> NoReturn:
        self.duet.log.warning("connection closed", f"{self._who}: {reason}")
        await self.close(code, reason)
        raise self.protocol.close_exc from None

    async def send_windows(
        self, buffer: MessageBuffer, client_id: int, backlog_done_message: Message | None
    ) -> None:
        """See `app.web.viser_internals.adapt_viser`."""
        if isinstance(buffer, ClientBuffer):
            self._entries = buffer.entries
        chosen = (
            self.duet.shared_buffer(self, client_id, buffer)
            if buffer.persistent_messages
            else nullcontext(buffer)
        )
        with chosen as own:
            await send_windows(self, own, client_id, backlog_done_message, self._seen.wait)


class Forwarder(logging.Handler):
    """Turns the library's tracebacks into short lines of a throttled log."""

    def __init__(self, log: ThrottledLog) -> None:
        super().__init__()
        self._log = log

    def emit(self, record: logging.LogRecord) -> None:
        error = record.exc_info[1] if record.exc_info else None
        if not isinstance(error, ConnectionClosed) and not isinstance(
            getattr(error, "__cause__", None), EOFError
        ):
            # A peer that hangs up, such as a health check, is not logged.
            connection = getattr(record, "websocket", None)
            address = connection.address if isinstance(connection, FilteredConnection) else ""
            what = f"{type(error).__name__}: {error!s:.200}" if error else record.levelname.lower()
            self._log.warning(record.getMessage()[:120], f"{what} (from {address or 'unknown'})")
        log.debug(record.getMessage(), exc_info=record.exc_info)
