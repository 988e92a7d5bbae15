"""Newcomers are let in one at a time and piece by piece, so that those who are here have their frames meanwhile."""

from collections import deque
from collections.abc import Callable, Generator
from time import perf_counter
from typing import Final

import viser

SLICE: Final = 0.008
"""Wall time in one frame after which no further piece of a newcomer's page is built [s]."""

Pieces = Generator[None, None, None]
"""The building of a page, which rests after every piece."""


class Admission:
    """Used on the frame loop's thread only.

    Args:
        build: begins to build a newcomer's page.
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
        self._now: tuple[viser.ClientHandle, Pieces] | None = None

    @property
    def busy(self) -> bool:
        """Whether a page is still to be built."""
        return self._now is not None or bool(self._waiting)

    def come(self, client: viser.ClientHandle) -> None:
        """Take a newcomer into the queue."""
        self._waiting.append(client)

    def leave(self, number: int) -> None:
        """Forget a newcomer who is gone, by client id; a page that is half built is given up."""
        self._waiting = deque(client for client in self._waiting if client.client_id != number)
        if self._now is not None and self._now[0].client_id == number:
            self._now[1].close()
            self._now = None

    def advance(self) -> None:
        """Build the first newcomer's page on for `SLICE`, at least one piece; the next one waits for another frame."""
        if self._now is None and self._waiting:
            client = self._waiting.popleft()
            self._now = client, self._build(client)
        if self._now is None:
            return
        client, pieces = self._now
        deadline = self._clock() + SLICE
        try:
            for _ in pieces:
                if self._clock() >= deadline:
                    return
        except Exception:
            self._failed(client)
        self._now = None

    def close(self) -> None:
        """Give up what is half built."""
        self._waiting.clear()
        if self._now is not None:
            self._now[1].close()
            self._now = None
