"""Which browsers have connected and disconnected since the last frame."""

import threading
from collections.abc import Callable

import viser

from app.web.server import DuetServer


class Connections:
    """Collects connections and disconnections on the network's thread for the frame loop's. `wake`: asks for a frame at once."""

    def __init__(self, server: DuetServer, wake: Callable[[], None]) -> None:
        self._arrivals: list[viser.ClientHandle] = []
        self._departures: set[int] = set()
        self._lock = threading.Lock()

        @server.on_client_connect
        async def _(client: viser.ClientHandle) -> None:
            with self._lock:
                self._arrivals.append(client)
            wake()

        @server.on_client_disconnect
        async def _(client: viser.ClientHandle) -> None:
            with self._lock:
                self._departures.add(client.client_id)
            wake()

    def changes(self) -> tuple[list[viser.ClientHandle], set[int]]:
        """Return the clients that have connected and are still there, and the ids of those that have disconnected, since the last call."""
        with self._lock:
            arrivals, self._arrivals = self._arrivals, []
            departures, self._departures = self._departures, set()
        return [client for client in arrivals if client.client_id not in departures], departures
