"""One browser's connection: filtered, slowed down where it sends too fast, and given up where nobody reads."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import socket
import types
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, Final

import msgspec
import viser.infra._infra as viser_infra
import websockets
import websockets.asyncio.server
from websockets.asyncio.server import ServerConnection
from websockets.frames import OP_BINARY, OP_CONT, OP_TEXT, Frame
from websockets.http11 import Response

from app.runtime.reporter import Forwarder
from app.web.http_methods import FirstLine
from app.web.index_page import HELLO, QUESTION
from app.web.message_gate import Traffic
from app.web.refusal import Malformed, Refused
from app.web.sending import pack

if TYPE_CHECKING:
    from app.web.server import DuetServer

SEND_BUFFER_BYTES: Final = 64 * 1024
READ_BYTES: Final = 16 * 1024
"""What comes in one read is taken apart in one go, for which everybody else waits."""

_SCRAP_BYTES: Final = 1000
_HELLO: Final = msgspec.msgpack.encode({"type": HELLO})

_QUESTION: Final = msgspec.msgpack.encode({"type": QUESTION})
_ANSWER: Final = pack(())
"""A window without messages: word from the server that changes nothing on the page."""


class FilteredConnection(ServerConnection):
    """A connection that hands on only what the gate lets through, and that doesn't let a slow reader fall behind by much."""

    duet: DuetServer  # set on a subclass, one per server

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.traffic = Traffic(self.duet.limits)
        self.first_line = FirstLine()
        self.introduced = False
        self._client_id: int | None = None
        self._ending: asyncio.Task[None] | None = None
        self._stalled: asyncio.TimerHandle | None = None
        # What waits in the system's buffer is stale by the time it is drawn.
        transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER_BYTES)
        setattr(transport, "max_size", READ_BYTES)  # noqa: B010  (of asyncio's transports over sockets; type checkers don't know it)
        super().connection_made(transport)

    def connection_lost(self, exc: Exception | None) -> None:
        self._end_stall()
        self.duet.gate.forget(self.traffic)
        super().connection_lost(exc)

    def pause_writing(self) -> None:
        # Pings queue up behind the unread data, so the library's keep-alive never notices; a closed laptop would keep its place.
        self._stalled = self.loop.call_later(self.duet.limits.stall_seconds, self.transport.abort)
        super().pause_writing()

    def resume_writing(self) -> None:
        self._end_stall()
        super().resume_writing()

    def _end_stall(self) -> None:
        if self._stalled is not None:
            self._stalled.cancel()
            self._stalled = None

    def data_received(self, data: bytes) -> None:
        super().data_received(self.first_line.take(data))

    def process_event(self, event: Any) -> None:
        super().process_event(event)
        if not isinstance(event, Frame) or len(event.data) >= _SCRAP_BYTES:
            return
        if event.fin and event.opcode in (OP_TEXT, OP_BINARY, OP_CONT):
            return
        # The library answers pings by itself, and bounds the bytes of a message but not into how many pieces it is cut.
        if self._ending is None and not self.traffic.takes_scrap():
            self.duet.report("connection closed", f"client {self._client_id} sends too many small frames")
            self._ending = self.loop.create_task(self.close(1008, "too many small frames"))

    async def _first(self, decode: bool | None) -> Any:
        """Return the first message; a connection that is only held open is closed."""
        seconds = self.duet.limits.first_message_seconds
        try:
            async with asyncio.timeout(seconds):
                raw = await super().recv(decode)
        except TimeoutError:
            self.duet.report("connection closed", f"nothing said within {seconds:g} s")
            await self.close(1008, "nothing said")
            raise self.protocol.close_exc from None
        self.introduced = True
        return raw

    async def recv(self, decode: bool | None = None) -> Any:
        while True:
            raw = await (super().recv(decode) if self.introduced else self._first(decode))
            pause = self.traffic.pause(len(raw))
            if pause > 0.0:
                self.duet.report("slowed down", f"client {self._client_id} sends too fast")
                await asyncio.sleep(pause)
            if raw == _QUESTION:
                if self.duet.is_at_work():
                    await self.send(_ANSWER)
                continue
            if raw == _HELLO:
                continue
            if self._client_id is None:
                self._client_id = self.duet._client_id(self)
            try:
                self.duet.gate.check(self._client_id, self.traffic, raw)
                return raw
            except Refused as refused:
                self.duet.report(f"message dropped ({refused.kind})", f"client {self._client_id}")
                # After what viser makes of the messages before: it does not know a browser until it has dealt with its first one.
                self.loop.call_soon(self.duet._refuse_kindly, self._client_id, self, refused)
            except Malformed as malformed:
                self.duet.report("connection closed", f"client {self._client_id} sent a malformed message ({malformed})")
                await self.close(1008, f"malformed message ({malformed})")
                raise self.protocol.close_exc from None


@contextlib.contextmanager
def served_by(duet: DuetServer, listener: socket.socket) -> Iterator[None]:
    """While open, the server that viser builds listens on `listener` and works by our rules."""
    connection_class = type("DuetConnection", (FilteredConnection,), {"duet": duet})
    # Not registered with `logging`, so that it goes with the server; viser hangs a filter on it at every start.
    quiet = logging.Logger("duet.server.websockets", level=logging.WARNING)
    quiet.addHandler(Forwarder(duet.report))

    def serve(
        handler: Callable[..., Any], host: str, port: int, *, process_request: Callable[..., Response | None], **options: Any
    ) -> Any:
        options |= {
            "process_request": lambda connection, request: duet._answer(connection, request, process_request),
            "create_connection": connection_class,
            "sock": listener,
            "process_response": lambda connection, request, response: connection.first_line.answer(response),
            "max_size": duet.limits.frame_bytes,
            "max_queue": duet.limits.frames_waiting,
            "close_timeout": 2.0,
            "server_header": None,
            "logger": quiet,
        }
        return websockets.asyncio.server.serve(lambda connection: duet._serve_one(connection, handler), **options)

    # Stands in for the name `websockets` in viser's one module that serves; the library itself stays untouched.
    stand_in = types.SimpleNamespace(
        asyncio=types.SimpleNamespace(server=types.SimpleNamespace(serve=serve, ServerConnection=ServerConnection)),
        exceptions=websockets.exceptions,
        datastructures=websockets.datastructures,
    )
    original = viser_infra.websockets  # pyright: ignore[reportPrivateImportUsage]
    setattr(viser_infra, "websockets", stand_in)  # noqa: B010  (a type checker knows it as a module)
    try:
        yield
    finally:
        setattr(viser_infra, "websockets", original)  # noqa: B010
