"""The server itself, and how to start it."""

from __future__ import annotations

import asyncio
import contextlib
import http
import io
import json
import logging
import secrets
import socket
import threading
from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import Any

import viser
import viser.infra._infra as viser_infra
from viser import _messages as viser_messages
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from app.i18n.catalogue import words_of
from app.i18n.reader_language import language_asked
from app.i18n.speaking import N_
from app.runtime.reporter import Reporter
from app.settings import Language
from app.text.documents import DOCUMENTS, PREFIX, document_page
from app.version import duet_version
from app.web.connection import FilteredConnection, served_by
from app.web.gui_registry import ViserGuiRegistry
from app.web.http_methods import ALLOWED
from app.web.index_page import OPEN_TOO_OFTEN, ROOM_IS_FULL, full_page, page_query
from app.web.listening import listen
from app.web.message_gate import Gate
from app.web.origin_policy import LOOPBACK_NAMES, OriginPolicy, check_origin
from app.web.own_pages import HTML, OWN_HEADERS, own_pages, respond
from app.web.page_assets import NO_ASSETS, PageAssets
from app.web.refusal import UPLOAD_TOO_LARGE, Refused
from app.web.sending import produce
from app.web.traffic_limits import TrafficLimits
from controllers.errors import BadSetting

log = logging.getLogger("duet.server")

_FOREIGN = (
    "This page may not talk to this Duet server. Open Duet under its own address, "
    "or start it with --allow-origin and this page's address.\n"
)
_construction = threading.Lock()

TurnAway = Callable[[str, dict[str, str]], str]

viser_infra._message_producer = produce


class DuetServer(viser.ViserServer):
    """A viser server with a filter at its door; made by `start_server`.

    Attributes:
        gate: the filter; `gate.may_share` decides which browser may operate what everybody sees.
        limits: how much one browser may ask for.
        max_clients: places, None for any number.
        always_admits: whether a page with a query gets in though every place is taken.
        run: a random word, new for every start.
        is_at_work: whether the pages are still being drawn; a page that asks gets no answer while they are not.
    """

    def __init__(
        self,
        listener: socket.socket,
        doorway: OriginPolicy,
        *,
        label: str,
        max_clients: int | None,
        full_html: str | None,
        limits: TrafficLimits,
        assets: PageAssets = NO_ASSETS,
        body: str = "",
        turn_away: TurnAway = lambda address, query: "",
    ) -> None:
        self.limits = limits
        self.max_clients = max_clients
        self.always_admits: Callable[[Mapping[str, str]], bool] = lambda query: False
        self.run = secrets.token_hex(8)
        self.gate = Gate(ViserGuiRegistry(self), limits)
        self.report = Reporter()
        self.is_at_work: Callable[[], bool] = lambda: True
        self._doorway, self._turn_away = doorway, turn_away
        self._ready = threading.Event()
        self._taken: dict[ServerConnection, tuple[str, str]] = {}
        self._pages = own_pages(label, self.run, full_html or full_page(max_clients or 0), assets, body)
        with _construction, served_by(self, listener), contextlib.redirect_stdout(io.StringIO()):
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

    def _has_room(self, path: str = "") -> bool:
        return self.max_clients is None or len(self._taken) < self.max_clients or self.always_admits(page_query(path))

    def _admits(self, connection: ServerConnection, request: Request, origins: Sequence[str]) -> bool:
        return self._doorway.admits(origins, request.headers.get_all("Host"), _address_of(connection))

    async def _document(self, name: str, language: Language) -> Response:
        # Its formulas take a second to draw; meanwhile everybody else is served.
        return respond(200, HTML, await asyncio.to_thread(document_page, name, language), {"Vary": "Accept-Language"})

    def _answer(
        self, connection: FilteredConnection, request: Request, static: Callable[..., Response | None]
    ) -> Response | Awaitable[Response] | None:
        """Answer a request, or return None to let it become a websocket."""
        path, _, query = request.path.partition("?")
        method, upgrades = connection.first_line.method, request.headers.get("Upgrade", "").lower() == "websocket"
        if method not in ALLOWED or (upgrades and method != "GET"):
            return respond(405, "text/plain", b"Only GET and HEAD are possible.\n", {"Allow": ", ".join(ALLOWED)})
        if upgrades:
            origins = request.headers.get_all("Origin")
            if self._admits(connection, request, origins):
                return None
            remedy = self._doorway.remedy(origins)
            self.report("refused origin", f"{origins!r:.120} from {_address_of(connection) or 'unknown'}{remedy:.200}")
            return connection.respond(http.HTTPStatus.FORBIDDEN, _FOREIGN)
        if path == "/healthz":
            state = {"ok": self.is_at_work(), "clients": self.count_clients(), "room": self._has_room()}
            state |= {"version": duet_version(), "run": self.run}
            origin = page_query(request.path).get("origin")
            if origin is not None:
                state["admitted"] = self._admits(connection, request, [origin])
            return respond(200, "application/json", json.dumps(state).encode(), {"Cache-Control": "no-store"})
        if path in ("", "/"):
            if not self._has_room(request.path):
                return respond(503, HTML, self._pages["full"], {"Retry-After": "10", "Cache-Control": "no-store"})
            packed = "gzip" in request.headers.get("Accept-Encoding", "")
            extra = {"Content-Encoding": "gzip", "Vary": "Accept-Encoding"} if packed else {"Vary": "Accept-Encoding"}
            return respond(200, HTML, self._pages["packed" if packed else "plain"], extra)
        document = path.removeprefix(PREFIX)
        if path != document and document in DOCUMENTS:
            return self._document(document, _language_of(request))
        if path == "/index.html":
            # Under this name viser's client would take the websocket's address for a foreign one.
            return respond(308, "text/plain", b"", {"Location": "./" + ("?" + query if query else "")})
        response = static(connection, request)
        if response is not None:
            for name, value in OWN_HEADERS.items():
                response.headers.setdefault(name, value)
        return response

    async def _serve_one(self, connection: ServerConnection, handler: Callable[..., Any]) -> None:
        """Give a new connection a place, then leave it to viser."""
        path = connection.request.path if connection.request is not None else ""
        if not self._has_room(path):
            # The page knows this reason, reloads, and gets the friendly page; decided here as two tabs may have loaded at once.
            await connection.close(1013, ROOM_IS_FULL)
            return
        reason = self._turn_away(_address_of(connection), page_query(path))
        if reason:
            await connection.close(1013, reason)
            return
        # Every page of ours names its tab. So a class behind one address is many, and only programs are counted by where they are.
        tab = page_query(path).get("resume", "")
        holder = ("tab", tab) if tab else ("address", _address_of(connection))
        if sum(one == holder for one in self._taken.values()) >= self.limits.connections:
            self.report("connection closed", f"too many at once of one {holder[0]}")
            await connection.close(1013, OPEN_TOO_OFTEN)
            return
        self._taken[connection] = holder
        try:
            # Old tabs come back within milliseconds of a restart, when viser's constructor is still at work.
            while not self._ready.is_set():
                await asyncio.sleep(0.01)
            await handler(connection)
        finally:
            del self._taken[connection]

    def _client_id(self, connection: ServerConnection) -> int:
        return next((i for i, live in self._websock_server._live_connections.items() if live is connection), -1)

    def _refuse_kindly(self, client_id: int, connection: ServerConnection, refused: Refused) -> None:
        client, request = self._connected_clients.get(client_id), connection.request
        if refused.kind == UPLOAD_TOO_LARGE and client is not None and request is not None:
            words, size = words_of(_language_of(request)), f"{self.limits.upload_bytes / 1e6:g}"
            title, body = words(N_("This file is too large")), words(N_("Files of up to {size} MB can be read."), size=size)
            client.add_notification(title, body, color="orange")


def _address_of(connection: ServerConnection) -> str:
    """Return where a connection comes from, "" if that is unknown."""
    peer = connection.remote_address
    return str(peer[0]) if peer else ""


def _language_of(request: Request) -> Language:
    """Return the language of whoever sent a request; what they chose on their page is not known here."""
    return language_asked(page_query(request.path), ",".join(request.headers.get_all("Accept-Language")))


def start_server(
    host: str = "127.0.0.1",
    port: int = 8080,
    *,
    label: str = "Duet",
    allowed_origins: tuple[str, ...] = (),
    max_clients: int | None = None,
    page_full_html: str | None = None,
    limits: TrafficLimits | None = None,
    assets: PageAssets = NO_ASSETS,
    body: str = "",
    turn_away: TurnAway = lambda address, query: "",
) -> DuetServer:
    """Start the web server.

    Args:
        host: 127.0.0.1 for this computer only, 0.0.0.0 for the whole network.
        port: the port, 0 for any free one.
        label: title of the tab and of the main panel.
        allowed_origins: further pages that may connect, such as `https://duet.example.org` behind a proxy.
        max_clients: places; whoever comes later gets a friendly page that lets them in when a place is free. None for no limit.
        page_full_html: that page; by default `app.web.index_page.full_page`.
        limits: how much one browser may ask for.
        assets: scripts and style sheets of every page, which run before viser's own.
        body: HTML that every page's body begins with.
        turn_away: returns why the browser of an address and with a query may not come in now, "" if it may; the page knows the
            reasons in `app.web.index_page`. Asked on the network's thread.

    Raises:
        PortInUse: another program has the port.
        BadSetting: the host or the port can't be used at all, or `max_clients` is below 1.
    """
    if max_clients is not None and max_clients < 1:
        raise BadSetting(f"max_clients {max_clients} leaves no place; valid: 1 or more")
    for origin in allowed_origins:
        check_origin(origin)
    listener = listen(host, port)
    doorway = OriginPolicy(host, listener.getsockname()[1], tuple(allowed_origins))
    if not doorway.is_private and host not in LOOPBACK_NAMES:
        log.info("everybody on the network can reach this server")
    limits = TrafficLimits() if limits is None else limits
    return DuetServer(
        listener,
        doorway,
        label=label,
        max_clients=max_clients,
        full_html=page_full_html,
        limits=limits,
        assets=assets,
        body=body,
        turn_away=turn_away,
    )
