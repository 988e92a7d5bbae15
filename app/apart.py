"""Visitors of a lecture who do not see the stage: they are sent nothing of what is everybody's, and have a page of their own.

viser sends every browser what is drawn on the server object. Here a browser may be left out of that when it connects: it gets what
was there before the stage was built, and then nothing. Like `app.server` this relies on viser 1.1.
"""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Final
from weakref import WeakKeyDictionary

import viser
import viser.infra._infra as viser_infra
from viser._gui_handles import _PlacementMixin
from viser.infra._async_message_buffer import AsyncMessageBuffer
from viser.infra._messages import Message
from websockets.asyncio.server import ServerConnection

from app.server.index import ELSEWHERE, page_query
from app.server.server import DuetServer

MOVED_CODE: Final = 4001
"""Why a connection was ended: the page comes back at once, and finds itself somewhere else."""


class Apart:
    """Decides for every browser whether it sees the stage, and ends connections of those who are to be somewhere else.

    Args:
        server: whose stage is about to be built.
        wanted: whether the browser with a query is to be apart; asked on the network's thread.
    """

    def __init__(self, server: DuetServer, wanted: Callable[[dict[str, str]], bool]) -> None:
        self._server, self._wanted = server, wanted
        self._numbers: set[int] = set()
        shared = server._websock_server._broadcast_buffer
        self._bare = AsyncMessageBuffer(shared.event_loop, persistent_messages=True)
        with shared.buffer_lock:
            before = list(shared.message_from_id.values())
        for message in before:
            self._bare.push(message)
        _HOUSES[server] = self

        @server.on_client_disconnect
        async def _(client: viser.ClientHandle) -> None:
            self._numbers.discard(client.client_id)

    def holds(self, number: int) -> bool:
        """Return whether the browser with this client id is apart."""
        return number in self._numbers

    def move(self, client: viser.ClientHandle) -> None:
        """End a browser's connection, so that its page comes back and is asked anew where it belongs."""
        connection = self._server._websock_server._live_connections.get(client.client_id)
        if connection is not None:
            asyncio.run_coroutine_threadsafe(connection.close(MOVED_CODE, ELSEWHERE), self._bare.event_loop)

    def close(self) -> None:
        """Let those who are apart go."""
        self._bare.set_done()

    def _buffer(self, connection: ServerConnection, client_id: int, shared: AsyncMessageBuffer) -> AsyncMessageBuffer:
        request = connection.request
        if request is None or not self._wanted(page_query(request.path)):
            return shared
        self._numbers.add(client_id)
        return self._bare


_HOUSES: WeakKeyDictionary[DuetServer, Apart] = WeakKeyDictionary()
_Produce = Callable[[ServerConnection, AsyncMessageBuffer, int, Message | None], Awaitable[None]]
_produce: Final[_Produce] = viser_infra._message_producer


async def _produce_apart(
    connection: ServerConnection, buffer: AsyncMessageBuffer, client_id: int, backlog_done_message: Message | None = None
) -> None:
    """Send one browser what a buffer holds for it; what is everybody's only if it sees the stage."""
    server = getattr(connection, "duet", None)
    house = _HOUSES.get(server) if buffer.persistent_messages and server is not None else None
    if house is not None:
        buffer = house._buffer(connection, client_id, buffer)
    await _produce(connection, buffer, client_id, backlog_done_message)


viser_infra._message_producer = _produce_apart


class _PlacedForOne(_PlacementMixin):
    """A panel that everybody has, as one browser is to place it."""

    def __init__(self, client: viser.ClientHandle, panel: viser.PanelHandle) -> None:
        self._placement_uuid, self._placement_gui_api = panel._placement_uuid, client.gui


def expand_for(client: viser.ClientHandle, panel: viser.PanelHandle) -> None:
    """Unfold a panel that everybody has, for one browser only."""
    _PlacedForOne(client, panel).expand()
