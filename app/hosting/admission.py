"""Pages of new visitors are built one at a time and piece by piece, so that all others have their frames meanwhile."""

from collections import deque
from collections.abc import Callable, Generator
from time import perf_counter
from typing import Final

import viser

SLICE: Final = 0.008
"""Wall time in one frame after which no further piece of a page is built [s]."""

Pieces = Generator[None, None, None]
"""The building of a page, which yields after every piece."""


class Admission:
    """The queue of clients that wait for their pages. Belongs to the frame loop's thread.

    Args:
        build: begins to build a client's page.
        failed: called in the handler of an exception that a building has raised.
        clock: returns the time [s].
    """

    def __init__(
        self,
        build: Callable[[viser.ClientHandle], Pieces],
        failed: Callable[[viser.ClientHandle], None],
        clock: Callable[[], float] = perf_counter,
    ) -> None:
        self._build, self._failed, self._clock = build, failed, clock
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

    def advance(self) -> None:
        """Go on with the first client's page for `SLICE`, at least by one piece; the next page waits for another frame."""
        if self._current is None and self._waiting:
            client = self._waiting.popleft()
            self._current = client, self._build(client)
        if self._current is None:
            return
        client, pieces = self._current
        deadline = self._clock() + SLICE
        try:
            for _ in pieces:
                if self._clock() >= deadline:
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
