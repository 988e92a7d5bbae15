"""The web server: viser with filters."""

from __future__ import annotations

import asyncio
import contextlib
import gzip
import http
import io
import json
import logging
import secrets
import socket
import threading
import time
from collections.abc import Awaitable, Callable, Mapping, Sequence
from functools import partial
from typing import Any, Final

import viser
import websockets.asyncio.server
from prometheus_client import CONTENT_TYPE_PLAIN_0_0_4
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from app.i18n.catalogue import words_of
from app.i18n.reader_language import language_asked
from app.i18n.speaking import N_
from app.runtime.throttled_log import ThrottledLog
from app.settings import Language
from app.version import duet_version
from app.web import viser_internals
from app.web.connection import BufferChoice, FilteredConnection, Forwarder
from app.web.listening import listen, url_of
from app.web.message_gate import Gate
from app.web.origin_policy import VOUCHED, OriginPolicy, check_origin
from app.web.pages import (
    ELSEWHERE,
    NO_ASSETS,
    OPEN_TOO_OFTEN,
    ROOM_IS_FULL,
    TAKEN_OVER,
    PageAssets,
    accepted_languages,
    full_page,
    page_query,
    patched_index,
)
from app.web.plain_http import ALLOWED, HTML, OWN_HEADERS, metrics_text, respond
from app.web.schemas import UPLOAD_TOO_LARGE, Refused
from app.web.sending import ClientBuffer
from app.web.traffic_limits import BoundedQueue, TrafficLimits
from controllers.errors import BadSetting

log = logging.getLogger("duet.server")

_FOREIGN = (
    "This page may not talk to this Duet server. Open Duet under its own address, "
    "or start it with --allow-origin and this page's address.\n"
)
_LOG_EVERY = 10.0
"""Least time between two log lines of a kind [s]."""

ANSWER_SECONDS: Final = 300.0
"""Longest time for a request and its answer [s]."""

MOST_DELAYED: Final = 200
"""Most delayed answers at once; further requests are refused."""

NEWS: Final = 1.0
"""Time within which news of other processes' browsers arrive [s]."""

MOVED_CODE: Final = 4001
"""Close code after which the page reconnects at once."""

Handler = Callable[[ServerConnection], Awaitable[None]]
Static = Callable[..., Response | None]
Document = Callable[[Language], bytes]
"""HTML in a reader's language."""


class DuetServer(viser.ViserServer):
    """viser server that filters requests and messages; it serves from its construction until `stop`.

    Args:
        host: 127.0.0.1 for this computer only, 0.0.0.0 for the whole network.
        port: 0 for any free one.
        allowed_origins: further pages that may connect, such as `https://duet.example.org` behind a proxy.
        embed_origins: foreign pages that may show ours in a frame.
        max_clients: places, or None for no limit; may be set at any time. Without a free one a browser gets a
            waiting page.
        documents: further pages by path ("/documents/model"), rendered outside the network's thread.
        delay: of an answer to an address and a query [s]; called on the network's thread.
        listener: socket that is bound to `port`.
        run: random word of this start, shared by the processes of one port; "" makes one.

    Attributes:
        always_admits: True if a page with this query needs no free place.
        trusts: True if it may connect from an unknown address.
        takes_over: True if it ends its tab's earlier connections.
        elsewhere: number of browsers of the port's other processes.
        count_changed: called with the new count on the network's thread.
        is_at_work: False if pages are no longer drawn; a page that asks then gets no answer.
        app_state: adds to `/healthz`; called on the network's thread.
        may_measure: True if a query has the key to `/metrics`.
        proof: see `OriginPolicy.is_owners`.

    Raises:
        PortInUse: another program has the port.
        BadSetting: unusable host, port, origin or `max_clients`.
    """

    def __init__(
        self,
        host: str = "127.0.0.1",
        port: int = 8080,
        *,
        allowed_origins: tuple[str, ...] = (),
        embed_origins: tuple[str, ...] = (),
        max_clients: int | None = None,
        limits: TrafficLimits | None = None,
        documents: Mapping[str, Document] = {},
        assets: PageAssets = NO_ASSETS,
        body: str = "",
        delay: Callable[[str, dict[str, str]], float] = lambda address, query: 0.0,
        listener: socket.socket | None = None,
        run: str = "",
    ) -> None:
        if max_clients is not None and max_clients < 1:
            raise BadSetting(f"max_clients = {max_clients} is out of range; valid: 1 or more")
        for origin in allowed_origins:
            check_origin(origin)
        for origin in embed_origins:
            check_origin(origin, "embed origin")
        if listener is None:
            listener = listen(host, port)
            port = listener.getsockname()[1]
        self._origins = OriginPolicy(host, port, tuple(allowed_origins))
        if not self._origins.is_private:
            log.info("everybody on the network can reach this server")
        self.limits = TrafficLimits() if limits is None else limits
        self.max_clients = max_clients
        self.always_admits: Callable[[Mapping[str, str]], bool] = lambda query: False
        self.trusts: Callable[[Mapping[str, str]], bool] = lambda query: False
        self.takes_over: Callable[[Mapping[str, str]], bool] = lambda query: False
        self.run = run or secrets.token_hex(8)
        self.elsewhere = 0
        self.count_changed: Callable[[int], None] = lambda count: None
        self.gate = Gate(viser_internals.GuiRegistry(self), self.limits)
        self.log = ThrottledLog(log, (_LOG_EVERY,))
        self.is_at_work: Callable[[], bool] = lambda: True
        self.app_state: Callable[[], Mapping[str, object]] = dict
        self.may_measure: Callable[[Mapping[str, str]], bool] = lambda query: False
        self.proof = ""
        self.shared_buffer: BufferChoice = lambda connection, client_id, buffer: contextlib.nullcontext(
            buffer
        )
        self.embed_origins = embed_origins
        self._frames = {"Content-Security-Policy": " ".join(("frame-ancestors 'self'", *embed_origins))}
        self._documents, self._delay, self._delayed = documents, delay, 0
        self._ready = threading.Event()
        self.holders: dict[ServerConnection, tuple[str, str]] = {}
        self.placed: set[ServerConnection] = set()
        self._silent = BoundedQueue[ServerConnection](
            2 * self.limits.silent, self.limits.silent, self.limits.connections
        )
        page = patched_index(viser_internals.client_html(), title="Duet", assets=assets, body=body).encode()
        self._pages = {"plain": page, "packed": gzip.compress(page, 6)}
        viser_internals.adapt_viser(ClientBuffer)
        with (
            viser_internals.serving_with(partial(self._serve, listener)),
            contextlib.redirect_stdout(io.StringIO()),
        ):
            super().__init__(host=host, port=self._origins.port, label="Duet", verbose=False)
        viser_internals.remove_share_handlers(self)
        self._ready.set()

    @property
    def url(self) -> str:
        return url_of(self._origins.host, self._origins.port)

    def count_clients(self) -> int:
        """Number of places in use, also by pages that are being built."""
        return len(self.placed)

    def page_of(self, client_id: int) -> FilteredConnection | None:
        """None if the browser is gone; from any thread."""
        connection = viser_internals.connection_of(self, client_id)
        return connection if isinstance(connection, FilteredConnection) else None

    def send_elsewhere(self, client: viser.ClientHandle) -> None:
        """Close a connection, so that its page reconnects at once, perhaps to another process; from any
        thread."""
        connection = self.page_of(client.client_id)
        if connection is not None:
            asyncio.run_coroutine_threadsafe(self._let_go(connection), self.get_event_loop())

    def is_owners(self, client_id: int) -> bool:
        """True for the person who started the server; never if foreign pages may frame ours."""
        page = self.page_of(client_id)
        if page is None or page.request is None or self.embed_origins:
            return False
        headers = page.request.headers
        return self._origins.is_owners(
            headers.get_all("Origin"), headers.get_all("Host"), page.address, headers, self.proof
        )

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Duet opens no tunnel to the outside."""
        return None

    def stop(self) -> None:
        """May be called twice."""
        with contextlib.redirect_stdout(io.StringIO()):
            super().stop()

    # ---- on the network's thread -------------------------------------------------------------------------------------------

    def _serve(
        self,
        listener: socket.socket,
        handler: Handler,
        *address: Any,
        process_request: Static,
        **options: Any,
    ) -> Any:
        """Replaces viser's `websockets.asyncio.server.serve`, on a bound socket."""
        # Not registered with `logging`, so that it is freed with the server; viser adds a filter to it at
        # every start.
        quiet = logging.Logger("duet.server.websockets", level=logging.WARNING)
        quiet.addHandler(Forwarder(self.log))
        options |= {
            "handler": lambda connection: self._serve_one(connection, handler),
            "process_request": lambda connection, request: self._answer(connection, request, process_request),
            "create_connection": partial(FilteredConnection, self),
            "sock": listener,
            "process_response": lambda connection, request, response: connection.answer(response),
            "max_size": self.limits.frame_bytes,
            "max_queue": self.limits.frames_waiting,
            # A request has `head_seconds`; a busy machine may take longer to draw a document.
            "open_timeout": ANSWER_SECONDS,
            "close_timeout": 2.0,
            "server_header": None,
            "logger": quiet,
        }
        return websockets.asyncio.server.serve(**options)

    def _has_room(self, path: str = "") -> bool:
        count = self.elsewhere + len(self.placed)
        return self.max_clients is None or count < self.max_clients or self.always_admits(page_query(path))

    def _admits(self, connection: FilteredConnection, request: Request, origins: Sequence[str]) -> bool:
        hosts, vouched = request.headers.get_all("Host"), VOUCHED in request.headers
        return self.trusts(page_query(request.path)) or self._origins.admits(
            origins, hosts, connection.address, vouched
        )

    async def _document(self, render: Document, request: Request) -> Response:
        # Formulas take a second to draw; meanwhile other requests are served.
        return respond(
            200, HTML, await asyncio.to_thread(render, _language_of(request)), {"Vary": "Accept-Language"}
        )

    def _state(self) -> dict[str, object]:
        state = {
            "ok": self.is_at_work(),
            "clients": self.elsewhere + self.count_clients(),
            "room": self._has_room(),
        }
        return {**state, "version": duet_version(), "run": self.run, **self.app_state()}

    async def _metrics(self) -> Response:
        text = await asyncio.to_thread(metrics_text, self._state())
        return respond(200, CONTENT_TYPE_PLAIN_0_0_4, text, {"Cache-Control": "no-store"})

    async def _answer(
        self, connection: FilteredConnection, request: Request, static: Static
    ) -> Response | None:
        """None accepts the request as a websocket."""
        delay = self._delay(connection.address, page_query(request.path))
        if delay > 0.0:
            self.log.warning("wrong key", f"from {connection.address or 'unknown'}")
            if self._delayed >= MOST_DELAYED:
                return respond(429, "text/plain", b"Too many wrong keys.\n", {"Retry-After": "10"})
            self._delayed += 1
            try:
                await asyncio.sleep(delay)
            finally:
                self._delayed -= 1
        response = self._answer_now(connection, request, static)
        if isinstance(response, Awaitable):
            response = await response
        if response is not None:
            response.headers.update(self._frames)
        return response

    def _answer_now(
        self, connection: FilteredConnection, request: Request, static: Static
    ) -> Response | Awaitable[Response] | None:
        fault = connection.head.fault
        if fault is not None:
            self.log.warning(
                "faulty request", f"{fault.value} {fault.phrase}, from {connection.address or 'unknown'}"
            )
            return respond(fault.value, "text/plain", f"{fault.phrase}.\n".encode(), {})
        path, _, query = request.path.partition("?")
        method, upgrades = connection.head.method, request.headers.get("Upgrade", "").lower() == "websocket"
        if method not in ALLOWED or (upgrades and method != "GET"):
            return respond(
                405, "text/plain", b"Only GET and HEAD are possible.\n", {"Allow": ", ".join(ALLOWED)}
            )
        if upgrades:
            origins = request.headers.get_all("Origin")
            if self._admits(connection, request, origins):
                return None
            remedy = self._origins.remedy(origins)
            self.log.warning(
                "refused origin", f"{origins!r:.120} from {connection.address or 'unknown'}{remedy:.200}"
            )
            return connection.respond(http.HTTPStatus.FORBIDDEN, _FOREIGN)
        if path == "/healthz":
            state = self._state()
            origin = page_query(request.path).get("origin")
            if origin is not None:
                state["admitted"] = self._admits(connection, request, [origin])
            return respond(200, "application/json", json.dumps(state).encode(), {"Cache-Control": "no-store"})
        if path == "/metrics":
            if self._origins.is_local(connection.address, request.headers) or self.may_measure(
                page_query(request.path)
            ):
                return self._metrics()
            return respond(
                403,
                "text/plain",
                b"Only for this computer, or with the teacher's key: /metrics?key=KEY\n",
                {},
            )
        if path in ("", "/"):
            if not self._has_room(request.path):
                return respond(
                    503,
                    HTML,
                    full_page(self.max_clients or 0).encode(),
                    {"Retry-After": "10", "Cache-Control": "no-store"},
                )
            packed = "gzip" in request.headers.get("Accept-Encoding", "")
            extra = (
                {"Content-Encoding": "gzip", "Vary": "Accept-Encoding"}
                if packed
                else {"Vary": "Accept-Encoding"}
            )
            return respond(200, HTML, self._pages["packed" if packed else "plain"], extra)
        if path in self._documents:
            return self._document(self._documents[path], request)
        if path == "/index.html":
            # Under this name viser's client would build a wrong websocket address.
            return respond(308, "text/plain", b"", {"Location": "./" + ("?" + query if query else "")})
        try:
            response = static(connection, request)
        except (OSError, ValueError):
            # No file can have this name.
            response = respond(404, "text/plain", b"404\n", {})
        if response is not None:
            for name, value in OWN_HEADERS.items():
                response.headers.setdefault(name, value)
        return response

    async def _serve_one(self, connection: FilteredConnection, handler: Handler) -> None:
        """A connection gets a place by its first message."""
        path, address = connection.request.path if connection.request is not None else "", connection.address
        # Every page names its tab, so a class behind one address counts per tab; only programs count by
        # address.
        tab = page_query(path).get("resume", "")
        holder = ("tab", tab) if tab else ("address", address)
        if sum(one == holder for one in self.holders.values()) >= self.limits.connections:
            if self._has_room(path):
                self.log.warning(
                    "connection closed", f"too many at once of one {holder[0]}, from {address or 'unknown'}"
                )
            await connection.close(1013, OPEN_TOO_OFTEN if self._has_room(path) else ROOM_IS_FULL)
            return
        before = [
            one
            for one, its in self.holders.items()
            if tab and its == holder and self.takes_over(page_query(path))
        ]
        self.holders[connection] = holder
        if (oldest := self._silent.enter(connection, address, tab)) is not None:
            oldest.transport.abort()
        try:
            # Old tabs reconnect within milliseconds of a restart, while viser's constructor still runs.
            while not self._ready.is_set():
                await asyncio.sleep(0.01)
            # The page was loaded while there was room, but two tabs may load at once.
            if not await self._has_room_soon(path):
                await connection.close(1013, ROOM_IS_FULL)
                return
            # A lost connection does not answer, and nothing waits for it.
            await asyncio.gather(handler(connection), *(one.close(1013, TAKEN_OVER) for one in before))
        finally:
            del self.holders[connection]
            self._silent.leave(connection)
            self.placed.discard(connection)
            self.count_changed(len(self.placed))

    async def _has_room_soon(self, path: str) -> bool:
        """True if there is room; waits for news, because a tab may arrive before its free place."""
        until = time.monotonic() + (NEWS if self.elsewhere else 0.0)
        while not self._has_room(path) and time.monotonic() < until:
            await asyncio.sleep(0.02)
        return self._has_room(path)

    async def place(self, connection: ServerConnection) -> str:
        """See `app.web.connection.ConnectionOwner.place`."""
        if not await self._has_room_soon(connection.request.path if connection.request is not None else ""):
            return ROOM_IS_FULL
        self._silent.leave(connection)
        self.placed.add(connection)
        self.count_changed(len(self.placed))
        return ""

    async def _let_go(self, connection: ServerConnection) -> None:
        # The page reconnects at once and needs its place: if all are taken, it would be refused.
        self.placed.discard(connection)
        self.count_changed(len(self.placed))
        await connection.close(MOVED_CODE, ELSEWHERE)

    def client_id(self, connection: ServerConnection) -> int:
        return viser_internals.client_id_of(self, connection)

    def explain(self, client_id: int, connection: ServerConnection, refused: Refused) -> None:
        client, request = viser_internals.client_of(self, client_id), connection.request
        if refused.kind == UPLOAD_TOO_LARGE and client is not None and request is not None:
            words, size = words_of(_language_of(request)), f"{self.limits.upload_bytes / 1e6:g}"
            title, body = (
                words(N_("This file is too large")),
                words(N_("Files of up to {size} MB can be read."), size=size),
            )
            client.add_notification(title, body, color="orange")


def _language_of(request: Request) -> Language:
    """Language of the link or the browser, not of a choice on the page."""
    return language_asked(page_query(request.path), accepted_languages(request))
