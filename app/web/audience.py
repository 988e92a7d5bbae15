"""Those who watch a lecture with the same look: what is drawn for them is packed once, and sent to them alone.

viser's server object sends all browsers the same. An audience looks like a server to viser's scene and GUI, but has a buffer of
its own, which `app.web.audiences` gives to the browsers that belong to it. Like `app.web` this relies on viser 1.1.
"""

import viser
from viser.infra._async_message_buffer import AsyncMessageBuffer
from viser.infra._infra import WebsockMessageHandler
from viser.infra._messages import Message

from app.settings import Look
from app.web.server import DuetServer


class _Channel(WebsockMessageHandler):
    """Stands in for viser's websocket server. Nothing comes in here: an audience operates nothing."""

    def __init__(self, buffer: AsyncMessageBuffer) -> None:
        super().__init__()
        self._broadcast_buffer = buffer

    def get_message_buffer(self) -> AsyncMessageBuffer:
        return self._broadcast_buffer

    def flush(self) -> None:
        self._broadcast_buffer.flush()


class Audience(viser.ViserServer):
    """A host for what some browsers see; it starts no server.

    Args:
        server: that the browsers are connected to.
        look: of their tabs.
        before: what every browser is sent first.

    Attributes:
        look: see above.
        watchers: the client ids of its browsers; belongs to `app.web.audiences`.
    """

    def __init__(self, server: DuetServer, look: Look, before: list[Message]) -> None:
        self.look = look
        self.watchers: set[int] = set()
        self.buffer = AsyncMessageBuffer(server.get_event_loop(), persistent_messages=True)
        for message in before:
            self.buffer.push(message)
        self._websock_server = _Channel(self.buffer)  # type: ignore[assignment]
        self._connected_clients = server._connected_clients
        self._scene_lifecycle_lock = server._scene_lifecycle_lock
        self._thread_executor, self._event_loop = server._thread_executor, server._event_loop
        self.scene = viser.SceneApi(self, self._thread_executor, self._event_loop)
        self.gui = viser.GuiApi(self, self._thread_executor, self._event_loop)

    def seat(self, client: viser.ClientHandle) -> None:
        """Let a browser have elements of its own inside the panels of this audience."""
        # viser looks for the panels around a client's elements on the server that the client came to.
        client.gui._root_server = lambda: self

    def tidy(self) -> None:
        """Forget what newcomers need not be sent: elements that are gone again."""
        self._run_garbage_collector()
