"""The web server: viser, locked down, and everything that touches viser's insides.

viser has no public way to look at a request or at a message before it acts on it. It does build its server with
`websockets.asyncio.server.serve`, so we hand it a listening socket of our own, a connection class that filters what it reads,
and a function that answers the requests which are ours. All of this relies on viser 1.1 and lives in this file alone;
`tests/app/server` notices when viser changes.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import gzip
import http
import importlib.metadata
import io
import json
import logging
import operator
import re
import secrets
import socket
import sys
import threading
import time
import types
from collections import deque
from collections.abc import Awaitable, Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, cast

import msgspec
import viser
import viser.infra._infra as viser_infra
import websockets
import websockets.asyncio.server
import zstandard
from viser import _messages as viser_messages
from viser.infra._async_message_buffer import AsyncMessageBuffer
from viser.infra._messages import Message
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from app.documents import DOCUMENTS, PREFIX, document_page
from app.doorway import LOOPBACK_NAMES, Doorway
from app.gate import UPLOAD_TOO_LARGE, Control, Gate, Limits, Malformed, Refused, Scope, Traffic
from app.index import ROOM_IS_FULL, full_page, page_query, patched_index
from controllers.errors import BadSetting, DuetError

log = logging.getLogger("duet.server")

SEND_BUFFER_BYTES = 64 * 1024
_OWN_HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "X-Frame-Options": "SAMEORIGIN",
    "Cache-Control": "no-cache",
}
_HTML = "text/html; charset=utf-8"
_ADDRESS = re.compile(r"https?://[A-Za-z0-9.\-]+(:\d{1,5})?|https?://\[[0-9A-Fa-f:.]+\](:\d{1,5})?")
_FOREIGN = (
    "This page may not talk to this Duet server. Open Duet under its own address, "
    "or start it with --allow-origin and this page's address.\n"
)
_construction = threading.Lock()

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


async def _produce(
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


viser_infra._message_producer = _produce


class PortInUse(DuetError):
    """Another program listens on the port; the message names a port to try instead."""


class _Reporter:
    """Writes at most one line per kind and ten seconds, so that an attacker can't fill the log either."""

    def __init__(self, every: float = 10.0) -> None:
        self._every = every
        self._last: dict[str, float] = {}
        self._held_back: dict[str, int] = {}

    def __call__(self, kind: str, detail: str) -> None:
        now = time.monotonic()
        if now - self._last.get(kind, -1e9) < self._every:
            self._held_back[kind] = self._held_back.get(kind, 0) + 1
            return
        self._last[kind] = now
        more = self._held_back.pop(kind, 0)
        log.warning("%s: %s%s", kind, detail, f" ({more} more since the last line)" if more else "")


class _Elements:
    """Looks up in viser's tables what exists on a browser's page."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server

    def _places(self, client_id: int) -> Iterator[tuple[viser.GuiApi, Scope]]:
        client = self._server._connected_clients.get(client_id)
        if client is not None:
            yield client.gui, "own"
        yield self._server.gui, "shared"

    def control(self, client_id: int, uuid: str) -> Control | None:
        for gui, scope in self._places(client_id):
            handle = gui._gui_input_handle_from_uuid.get(uuid)
            if handle is None or handle._impl.removed:
                continue
            props = handle._impl.props
            takes_files = isinstance(handle, viser.GuiUploadButtonHandle)
            return Control(
                scope=scope,
                value=None if takes_files else handle._impl.value,
                enabled=not getattr(props, "disabled", False),
                low=getattr(props, "min", None),
                high=getattr(props, "max", None),
                options=getattr(props, "options", None),
                takes_files=takes_files,
            )
        return None

    def form(self, client_id: int, uuid: str) -> Scope | None:
        for gui, scope in self._places(client_id):
            if isinstance(gui._container_handle_from_uuid.get(uuid), viser.GuiFormHandle):
                return scope
        return None

    def command(self, client_id: int, uuid: str) -> Scope | None:
        for gui, scope in self._places(client_id):
            if uuid in gui._command_handle_from_uuid:
                return scope
        return None


class DuetServer(viser.ViserServer):
    """A viser server with a filter at its door; made by `start_server`.

    Attributes:
        gate: the filter; `gate.may_share` decides which browser may operate what everybody sees.
        limits: how much one browser may ask for.
        max_clients: places, None for any number.
        run: a random word, new for every start.
    """

    def __init__(
        self,
        listener: socket.socket,
        doorway: Doorway,
        *,
        label: str,
        max_clients: int | None,
        full_html: str | None,
        limits: Limits,
        script: str = "",
    ) -> None:
        self.limits = limits
        self.max_clients = max_clients
        self.run = secrets.token_hex(8)
        self.gate = Gate(_Elements(self), limits)
        self.report = _Reporter()
        self._doorway = doorway
        self._ready = threading.Event()
        self._taken: set[ServerConnection] = set()
        self._pages = _own_pages(label, self.run, full_html or full_page(max_clients or 0), script)
        with _construction, _served_by(self, listener), contextlib.redirect_stdout(io.StringIO()):
            super().__init__(host=doorway.host, port=doorway.port, label=label, verbose=False)
        for kind in (viser_messages.ShareUrlRequest, viser_messages.ShareUrlDisconnect):
            self._websock_server.unregister_handler(kind)
        self._ready.set()

    @property
    def url(self) -> str:
        """The address to open in a browser on this computer."""
        host = self._doorway.host
        host = "localhost" if host in ("0.0.0.0", "::", "") else f"[{host}]" if ":" in host else host
        return f"http://{host}:{self.get_port()}"

    def count_clients(self) -> int:
        """How many browsers are connected this moment, including those whose page is still being built."""
        return len(self._taken)

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Always None: Duet opens no tunnel to the outside."""
        return None

    def stop(self) -> None:
        """Close all connections, release the port and end the server's thread. May be called twice."""
        with contextlib.redirect_stdout(io.StringIO()):
            super().stop()

    # The rest is called on the network thread.

    def _has_room(self) -> bool:
        return self.max_clients is None or len(self._taken) < self.max_clients

    async def _document(self, name: str) -> Response:
        # Its formulas take a second to draw; meanwhile everybody else is served.
        return _respond(200, _HTML, await asyncio.to_thread(document_page, name), {})

    def _answer(
        self, connection: ServerConnection, request: Request, static: Callable[..., Response | None]
    ) -> Response | Awaitable[Response] | None:
        """Answer a request, or return None to let it become a websocket."""
        path, _, query = request.path.partition("?")
        if request.headers.get("Upgrade", "").lower() == "websocket":
            origins, peer = request.headers.get_all("Origin"), connection.remote_address
            if self._doorway.admits(origins, request.headers.get_all("Host"), str(peer[0]) if peer else ""):
                return None
            self.report("refused origin", f"{origins!r:.120} from {peer[0] if peer else 'unknown'}")
            return connection.respond(http.HTTPStatus.FORBIDDEN, _FOREIGN)
        if path == "/healthz":
            state = {"ok": True, "clients": self.count_clients(), "room": self._has_room()}
            state |= {"version": duet_version(), "run": self.run}
            return _respond(200, "application/json", json.dumps(state).encode(), {"Cache-Control": "no-store"})
        if path in ("", "/"):
            if not self._has_room():
                return _respond(503, _HTML, self._pages["full"], {"Retry-After": "10", "Cache-Control": "no-store"})
            packed = "gzip" in request.headers.get("Accept-Encoding", "")
            extra = {"Content-Encoding": "gzip", "Vary": "Accept-Encoding"} if packed else {"Vary": "Accept-Encoding"}
            return _respond(200, _HTML, self._pages["packed" if packed else "plain"], extra)
        document = path.removeprefix(PREFIX)
        if path != document and document in DOCUMENTS:
            return self._document(document)
        if path == "/index.html":
            # Under this name viser's client would take the websocket's address for a foreign one.
            return _respond(308, "text/plain", b"", {"Location": "./" + ("?" + query if query else "")})
        response = static(connection, request)
        if response is not None:
            for name, value in _OWN_HEADERS.items():
                response.headers.setdefault(name, value)
        return response

    async def _serve_one(self, connection: ServerConnection, handler: Callable[..., Any]) -> None:
        """Give a new connection a place, then leave it to viser."""
        if not self._has_room():
            # The page knows this reason, reloads, and gets the friendly page; decided here as two tabs may have loaded at once.
            await connection.close(1013, ROOM_IS_FULL)
            return
        self._taken.add(connection)
        try:
            # Old tabs come back within milliseconds of a restart, when viser's constructor is still at work.
            while not self._ready.is_set():
                await asyncio.sleep(0.01)
            await handler(connection)
        finally:
            self._taken.discard(connection)

    def _client_id(self, connection: ServerConnection) -> int:
        return next((i for i, live in self._websock_server._live_connections.items() if live is connection), -1)

    def _refuse_kindly(self, client_id: int, refused: Refused) -> None:
        client = self._connected_clients.get(client_id)
        if refused.kind == UPLOAD_TOO_LARGE and client is not None:
            megabytes = self.limits.upload_bytes / 1e6
            client.add_notification("This file is too large", f"Files of up to {megabytes:g} MB can be read.", color="orange")


class _Connection(ServerConnection):
    """A connection that hands on only what the gate lets through, and that doesn't let a slow reader fall behind by much."""

    duet: DuetServer  # set on a subclass, one per server

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.traffic = Traffic()
        self._client_id: int | None = None
        self._stalled: asyncio.TimerHandle | None = None
        # What waits in the system's buffer is stale by the time it is drawn.
        transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER_BYTES)
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

    async def recv(self, decode: bool | None = None) -> Any:
        while True:
            raw = await super().recv(decode)
            pause = self.traffic.pause(self.duet.limits.messages_per_second)
            if pause > 0.0:
                self.duet.report("slowed down", f"client {self._client_id} sends too fast")
                await asyncio.sleep(pause)
            if self._client_id is None:
                self._client_id = self.duet._client_id(self)
            try:
                self.duet.gate.check(self._client_id, self.traffic, raw)
                return raw
            except Refused as refused:
                self.duet.report(f"message dropped ({refused.kind})", f"client {self._client_id}")
                self.duet._refuse_kindly(self._client_id, refused)
            except Malformed as malformed:
                self.duet.report("connection closed", f"client {self._client_id} sent a malformed message ({malformed})")
                await self.close(1008, "malformed message")
                raise self.protocol.close_exc from None


@contextlib.contextmanager
def _served_by(duet: DuetServer, listener: socket.socket) -> Iterator[None]:
    """While open, the server that viser builds listens on `listener` and works by our rules."""
    connection_class = type("DuetConnection", (_Connection,), {"duet": duet})
    # Not registered with `logging`, so that it goes with the server; viser hangs a filter on it at every start.
    quiet = logging.Logger("duet.server.websockets", level=logging.WARNING)
    quiet.addHandler(_Forwarder(duet.report))

    def serve(
        handler: Callable[..., Any], host: str, port: int, *, process_request: Callable[..., Response | None], **options: Any
    ) -> Any:
        options |= {
            "process_request": lambda connection, request: duet._answer(connection, request, process_request),
            "create_connection": connection_class,
            "sock": listener,
            "max_size": duet.limits.frame_bytes,
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


class _Forwarder(logging.Handler):
    """Turns the library's tracebacks (a stranger's garbage, a lost line) into one short line."""

    def __init__(self, report: _Reporter) -> None:
        super().__init__()
        self._report = report

    def emit(self, record: logging.LogRecord) -> None:
        error = record.exc_info[1] if record.exc_info else None
        self._report(record.getMessage()[:120], f"{type(error).__name__}: {error!s:.200}" if error else record.levelname.lower())
        log.debug(record.getMessage(), exc_info=record.exc_info)


def _respond(status: int, content_type: str, body: bytes, extra: dict[str, str]) -> Response:
    headers = Headers({"Content-Type": content_type, "Content-Length": str(len(body)), "Connection": "close"})
    for name, value in {**_OWN_HEADERS, **extra}.items():
        headers[name] = value
    return Response(status, http.HTTPStatus(status).phrase, headers, body)


def _own_pages(label: str, run: str, full_html: str, script: str) -> dict[str, bytes]:
    client = Path(viser.__file__).parent / "client" / "build" / "index.html"
    plain = patched_index(client.read_text(encoding="utf-8"), title=label, run=run, script=script).encode()
    return {"plain": plain, "packed": gzip.compress(plain, 6), "full": full_html.encode()}


def duet_version() -> str:
    """The installed version of Duet, "0" when it runs from a bare checkout."""
    try:
        return importlib.metadata.version("lwr-duet")
    except importlib.metadata.PackageNotFoundError:
        return "0"


def request_query(client: viser.ClientHandle) -> dict[str, str]:
    """The query (`?dm=0.1&n=10`) of the page that this browser has open; empty if it has none or is gone.

    Anybody can write anything there: validate names and values.
    """
    connection = client._viser_server._websock_server._live_connections.get(client.client_id)
    return {} if connection is None or connection.request is None else page_query(connection.request.path)


def request_address(client: viser.ClientHandle) -> str:
    """The address under which this browser knows the page, such as http://localhost:8080: a proxy may have given it another one."""
    connection = client._viser_server._websock_server._live_connections.get(client.client_id)
    headers = {} if connection is None or connection.request is None else connection.request.headers
    origin, host = headers.get("Origin", ""), headers.get("Host", "")
    if _ADDRESS.fullmatch(origin):
        return origin
    return f"http://{host}" if _ADDRESS.fullmatch(f"http://{host}") else cast(DuetServer, client._viser_server).url


def _somebody_answers(host: str, port: int) -> bool:
    with contextlib.suppress(OSError), socket.create_connection((host, port), timeout=0.25):
        return True
    return False


def _listen(host: str, port: int) -> socket.socket:
    """Bind `host`:`port` now, in the caller's thread, where a failure can be told."""
    if not isinstance(port, int) or not 0 <= port <= 65535:
        raise BadSetting(f"port {port!r} is no port; valid: 1 to 65535, or 0 for any free one")
    in_use = PortInUse(
        f"port {port} on {host} is already in use, perhaps by another Duet; choose another one: --port {port % 65535 + 1}"
    )
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)[0]
    except (OSError, UnicodeError) as error:
        raise BadSetting(f"host {host!r} is unknown; valid: 127.0.0.1, 0.0.0.0 or an address of this computer") from error
    # macOS lets a second program take the loopback side of a port that is held for all addresses.
    if port and sys.platform == "darwin" and _somebody_answers("127.0.0.1" if host in ("0.0.0.0", "::", "") else host, port):
        raise in_use
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        if sys.platform == "win32":
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
        else:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        # A listener is what makes Linux refuse the next bind on this port.
        listener.listen(128)
    except OSError as error:
        listener.close()
        # Windows names a port that is held exclusively by its own number, as a lack of permission.
        if error.errno == errno.EADDRINUSE or getattr(error, "winerror", None) in (10013, 10048):
            raise in_use from error
        if isinstance(error, PermissionError):
            raise BadSetting(f"port {port} needs administrator rights; choose one from 1024 on: --port 8080") from error
        raise BadSetting(
            f"host {host!r} is not an address of this computer; valid: 127.0.0.1, 0.0.0.0 or an address of its own"
        ) from error
    return listener


def start_server(
    host: str = "127.0.0.1",
    port: int = 8080,
    *,
    label: str = "Duet",
    allowed_origins: tuple[str, ...] = (),
    max_clients: int | None = None,
    page_full_html: str | None = None,
    limits: Limits | None = None,
    script: str = "",
) -> DuetServer:
    """Start the web server.

    Args:
        host: 127.0.0.1 for this computer only, 0.0.0.0 for the whole network.
        port: the port, 0 for any free one.
        label: title of the tab and of the main panel.
        allowed_origins: further pages that may connect, such as `https://duet.example.org` behind a proxy.
        max_clients: places; whoever comes later gets a friendly page that lets them in when a place is free. None for no limit.
        page_full_html: that page; by default `app.index.full_page`.
        limits: how much one browser may ask for.
        script: JavaScript that every page runs before viser's own.

    Raises:
        PortInUse: another program has the port.
        BadSetting: the host or the port can't be used at all, or `max_clients` is below 1.
    """
    if max_clients is not None and max_clients < 1:
        raise BadSetting(f"max_clients {max_clients} leaves no place; valid: 1 or more")
    for origin in allowed_origins:
        if not origin.startswith(("http://", "https://")):
            raise BadSetting(f"allowed origin {origin!r} is no web address; valid: http://name:port or https://name")
    listener = _listen(host, port)
    doorway = Doorway(host, listener.getsockname()[1], tuple(allowed_origins))
    if not doorway.is_private and host not in LOOPBACK_NAMES:
        log.info("everybody on the network can reach this server")
    limits = Limits() if limits is None else limits
    return DuetServer(
        listener, doorway, label=label, max_clients=max_clients, full_html=page_full_html, limits=limits, script=script
    )
