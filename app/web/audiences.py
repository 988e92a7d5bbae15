"""Who of a lecture's visitors is sent what: those who watch share what is drawn for their look, everybody else has a page of their own.

viser sends every browser what is drawn on the server object. In a lecture nothing is drawn there: when a browser connects it is given
the buffer of its audience, or, for a page of its own, the server's, which holds no more than viser's own beginning.
Like `app.web` this relies on viser 1.1.
"""

import asyncio
import threading
from collections.abc import Awaitable, Callable
from typing import Final
from weakref import WeakKeyDictionary

import viser
import viser.infra._infra as viser_infra
from viser._gui_handles import _PlacementMixin
from viser.infra._async_message_buffer import AsyncMessageBuffer
from viser.infra._messages import Message
from websockets.asyncio.server import ServerConnection

from app.settings import Look
from app.web.audience import Audience
from app.web.index_page import ELSEWHERE, page_query
from app.web.server import DuetServer

MOVED_CODE: Final = 4001
"""Why a connection was ended: the page comes back at once, and finds itself somewhere else."""

MOST: Final = 8
"""Audiences at once: each is drawn for itself. Who comes with a further look joins the one that is most like it."""


class Audiences:
    """Decides for every browser with whom it watches, and ends connections of those who are to be somewhere else.

    Args:
        server: that the browsers connect to.
        look: returns with which look the browser watches that has a client id, a query, and says which languages it likes;
            None for a page of its own. Asked on the network's thread.
        gone: called with the client id of a browser that is gone, on the network's thread.
    """

    def __init__(
        self, server: DuetServer, look: Callable[[int, dict[str, str], str], Look | None], gone: Callable[[int], None]
    ) -> None:
        self._server, self._look, self._gone = server, look, gone
        self._lock = threading.Lock()
        self._audiences: dict[Look, Audience] = {}
        shared = server._websock_server._broadcast_buffer
        self._loop = shared.event_loop
        with shared.buffer_lock:
            self._before = list(shared.message_from_id.values())
        _HOUSES[server] = self

    @property
    def audiences(self) -> tuple[Audience, ...]:
        """Return those who watch, by look."""
        with self._lock:
            return tuple(self._audiences.values())

    def audience_of(self, number: int) -> Audience | None:
        """Return with whom the browser with this client id watches; None if it has a page of its own, or is gone."""
        return next((one for one in self.audiences if number in one.watchers), None)

    def move(self, client: viser.ClientHandle) -> None:
        """End a browser's connection, so that its page comes back and is asked anew where it belongs."""
        connection = self._server._websock_server._live_connections.get(client.client_id)
        if connection is not None:
            asyncio.run_coroutine_threadsafe(connection.close(MOVED_CODE, ELSEWHERE), self._loop)

    # ---- on the network's thread -------------------------------------------------------------------------------------------

    def _enter(self, connection: ServerConnection, number: int, shared: AsyncMessageBuffer) -> AsyncMessageBuffer:
        """Return the buffer that a browser is to be sent."""
        request = connection.request
        if request is None:
            return shared
        look = self._look(number, page_query(request.path), ",".join(request.headers.get_all("Accept-Language")))
        if look is None:
            return shared
        with self._lock:
            audience = self._audiences.get(look)
            if audience is None and len(self._audiences) >= MOST:
                audience = max(self._audiences.values(), key=lambda one: _likeness(one.look, look))
            if audience is None:
                audience = self._audiences[look] = Audience(self._server, look, self._before)
            audience.watchers.add(number)
        audience.tidy()
        return audience.buffer

    def _leave(self, number: int) -> None:
        with self._lock:
            for audience in tuple(self._audiences.values()):
                audience.watchers.discard(number)
                if not audience.watchers:
                    del self._audiences[audience.look]
        self._gone(number)


def _likeness(one: Look, other: Look) -> tuple[bool, int]:
    """Return how much two looks have in common, the language before all."""
    return one.language == other.language, sum(a == b for a, b in zip(one, other, strict=True))


_HOUSES: WeakKeyDictionary[DuetServer, Audiences] = WeakKeyDictionary()
_Produce = Callable[[ServerConnection, AsyncMessageBuffer, int, Message | None], Awaitable[None]]
_produce: Final[_Produce] = viser_infra._message_producer


async def _produce_apart(
    connection: ServerConnection, buffer: AsyncMessageBuffer, client_id: int, backlog_done_message: Message | None = None
) -> None:
    """Send one browser what a buffer holds for it; instead of what is everybody's, what its audience is shown."""
    server = getattr(connection, "duet", None)
    house = _HOUSES.get(server) if buffer.persistent_messages and server is not None else None
    if house is None:
        await _produce(connection, buffer, client_id, backlog_done_message)
        return
    try:
        await _produce(connection, house._enter(connection, client_id, buffer), client_id, backlog_done_message)
    finally:
        house._leave(client_id)


viser_infra._message_producer = _produce_apart


class _PlacedForOne(_PlacementMixin):
    """A panel that an audience has, as one browser is to place it."""

    def __init__(self, client: viser.ClientHandle, panel: viser.PanelHandle) -> None:
        self._placement_uuid, self._placement_gui_api = panel._placement_uuid, client.gui


def expand_for(client: viser.ClientHandle, panel: viser.PanelHandle) -> None:
    """Unfold a panel that an audience has, for one browser only."""
    _PlacedForOne(client, panel).expand()
