"""Arrival of browsers, and the queue for pages."""

from collections import deque
from collections.abc import Callable, Generator
from contextvars import Context, copy_context
from time import perf_counter
from typing import Final

import viser

from app.hosting.app_context import AppContext

SLICE: Final = 0.008
"""Wall time per frame for building pages [s]."""

Pieces = Generator[None, None, None]
"""Builds a page; yields after every piece."""

_WHOLE: Final = object()


class Admission:
    """Queue of browsers for pages. Frame loop's thread only.

    Args:
        build: builds a client's page; changes of the current language between pieces do not affect it.
        failed: called while an exception of `build` is handled.
    """

    def __init__(
        self,
        context: AppContext,
        build: Callable[[viser.ClientHandle], Pieces],
        failed: Callable[[viser.ClientHandle], None],
    ) -> None:
        self._context, self._build, self._failed = context, build, failed
        self._here: dict[int, viser.ClientHandle] = {}
        self._waiting: deque[viser.ClientHandle] = deque()
        self._current: tuple[viser.ClientHandle, Pieces, Context] | None = None

    @property
    def busy(self) -> bool:
        return self._current is not None or bool(self._waiting)

    def changes(self) -> tuple[list[viser.ClientHandle], set[int]]:
        """Clients that connected, and ids of those that disconnected, since the last call. The latter leave
        the queue; a half-built page is abandoned.
        """
        before, self._here = self._here, self._context.server.get_clients()
        departures = before.keys() - self._here.keys()
        self._waiting = deque(client for client in self._waiting if client.client_id not in departures)
        if self._current is not None and self._current[0].client_id in departures:
            self._give_up()
        return [client for client_id, client in self._here.items() if client_id not in before], departures

    def come(self, client: viser.ClientHandle) -> None:
        self._waiting.append(client)

    def send_on(self, count: int, may_go: Callable[[viser.ClientHandle], bool]) -> list[viser.ClientHandle]:
        """Remove at most `count` waiting clients that may go elsewhere, newest first."""
        found = [client for client in reversed(self._waiting) if may_go(client)][: max(count, 0)]
        for client in found:
            self._waiting.remove(client)
        return found

    def advance(self) -> None:
        """Build the first client's page for `SLICE`, at least one piece."""
        if self._current is None and self._waiting:
            client = self._waiting.popleft()
            self._current = client, self._build(client), copy_context()
        if self._current is None:
            return
        client, pieces, its_own = self._current
        deadline = perf_counter() + SLICE
        try:
            while its_own.run(next, pieces, _WHOLE) is not _WHOLE:
                if perf_counter() >= deadline:
                    break
            else:
                self._current = None
        except Exception:
            self._current = None
            self._failed(client)
        if self.busy:
            self._context.wake()

    def close(self) -> None:
        self._waiting.clear()
        self._give_up()

    def _give_up(self) -> None:
        if self._current is not None:
            self._current[1].close()
            self._current = None
