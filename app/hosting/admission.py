"""Which browsers have come and gone; pages of newcomers are built one at a time and piece by piece, while all others have their frames."""

import threading
from collections import deque
from collections.abc import Callable, Generator
from time import perf_counter
from typing import Final

import viser

from app.web.server import DuetServer

SLICE: Final = 0.008
"""Wall time in one frame after which no further piece of a page is built [s]."""

Pieces = Generator[None, None, None]
"""The building of a page, which yields after every piece."""


class Admission:
    """The queue of clients that wait for their pages. Belongs to the frame loop's thread.

    Args:
        build: begins to build a client's page.
        failed: called in the handler of an exception that a building has raised.
    """

    def __init__(self, build: Callable[[viser.ClientHandle], Pieces], failed: Callable[[viser.ClientHandle], None]) -> None:
        self._build, self._failed = build, failed
        self._waiting: deque[viser.ClientHandle] = deque()
        self._current: tuple[viser.ClientHandle, Pieces] | None = None

    @property
    def busy(self) -> bool:
        """Whether a page is still to be built."""
        return self._current is not None or bool(self._waiting)

    def come(self, client: viser.ClientHandle) -> None:
        self._waiting.append(client)

    def leave(self, client_id: int) -> None:
        """Drop a client that has disconnected; a page that is half built is given up."""
        self._waiting = deque(client for client in self._waiting if client.client_id != client_id)
        if self._current is not None and self._current[0].client_id == client_id:
            self._give_up()

    def send_on(self, count: int, may_go: Callable[[viser.ClientHandle], bool]) -> list[viser.ClientHandle]:
        """Drop as many clients as wait and may go elsewhere, at most so many, those first that came last; return them."""
        found = [client for client in reversed(self._waiting) if may_go(client)][: max(count, 0)]
        for client in found:
            self._waiting.remove(client)
        return found

    def advance(self) -> None:
        """Go on with the first client's page for `SLICE`, at least by one piece; the next page waits for another frame."""
        if self._current is None and self._waiting:
            client = self._waiting.popleft()
            self._current = client, self._build(client)
        if self._current is None:
            return
        client, pieces = self._current
        deadline = perf_counter() + SLICE
        try:
            for _ in pieces:
                if perf_counter() >= deadline:
                    return
        except Exception:
            self._failed(client)
        self._current = None

    def close(self) -> None:
        """Give up all pages that are not whole."""
        self._waiting.clear()
        self._give_up()

    def _give_up(self) -> None:
        if self._current is not None:
            self._current[1].close()
            self._current = None


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
