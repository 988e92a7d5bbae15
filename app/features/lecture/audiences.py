"""Audiences of a lecture: browsers with the same look share one drawing.

Nothing is drawn on the server object, since viser sends its elements to all browsers.
"""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

import viser
from websockets.asyncio.server import ServerConnection

from app.settings import Look
from app.web.pages import accepted_languages, page_query
from app.web.server import DuetServer
from app.web.viser_internals import Message, MessageBuffer, ServerView, shared_messages

MOST: Final = 8
"""Most audiences; a browser with one more look joins the most similar one."""

MOST_SCREENS: Final = 4
"""Most additional audiences of projectors."""

SCREEN: Final = "screen"
"""Query key of a projector's link."""

SMALL: Final = "small"
"""Value of `screen` for the uncounted small picture on a teacher's page."""


class Audience(ServerView):
    """View for the browsers of one look. `watchers`: client ids."""

    def __init__(self, server: viser.ViserServer, look: Look, screen: bool, before: list[Message]) -> None:
        self.look, self.screen = look, screen
        self.watchers: set[int] = set()
        super().__init__(server, before)


class Audiences:
    """Assigns browsers to audiences. Calls `look` and `gone` on the network's thread.

    Args:
        look: (client id, query, Accept-Language) → look of a watcher; None for its own page.
        gone: receives the client id of a disconnected browser.
    """

    def __init__(
        self,
        server: DuetServer,
        look: Callable[[int, dict[str, str], str], Look | None],
        gone: Callable[[int], None],
    ) -> None:
        self._server, self._look, self._gone = server, look, gone
        self._lock = threading.Lock()
        self._audiences: list[Audience] = []
        self._before = shared_messages(server)
        server.shared_buffer = self._buffer_of

    @property
    def audiences(self) -> tuple[Audience, ...]:
        with self._lock:
            return tuple(self._audiences)

    def audience_of(self, number: int) -> Audience | None:
        """None for its own page, or a disconnected client."""
        return next((one for one in self.audiences if number in one.watchers), None)

    # ---- on the network's thread -------------------------------------------------------------------------------------------

    @contextmanager
    def _buffer_of(
        self, connection: ServerConnection, number: int, shared: MessageBuffer
    ) -> Iterator[MessageBuffer]:
        try:
            audience = self._assign(connection, number)
            yield shared if audience is None else audience.buffer
        finally:
            self._leave(number)

    def _assign(self, connection: ServerConnection, number: int) -> Audience | None:
        request = connection.request
        if request is None:
            return None
        query = page_query(request.path)
        look, screen = self._look(number, query, accepted_languages(request)), SCREEN in query
        if look is None:
            return None
        with self._lock:
            alike = [one for one in self._audiences if one.screen == screen]
            audience = max(alike, key=lambda one: _likeness(one.look, look), default=None)
            if audience is None or (
                audience.look != look and len(alike) < (MOST_SCREENS if screen else MOST)
            ):
                audience = Audience(self._server, look, screen, self._before)
                self._audiences.append(audience)
            audience.watchers.add(number)
        audience.drop_removed()
        return audience

    def _leave(self, number: int) -> None:
        with self._lock:
            for audience in self._audiences:
                audience.watchers.discard(number)
            self._audiences = [one for one in self._audiences if one.watchers]
        self._gone(number)


def _likeness(one: Look, other: Look) -> tuple[bool, int]:
    return one.language == other.language, sum(a == b for a, b in zip(one, other, strict=True))
