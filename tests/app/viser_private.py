"""Access of tests to viser's private side (viser 1.1.x); for the product see `app.web.viser_internals`."""

from collections.abc import Callable
from typing import Any

import viser


def component_id(handle: Any) -> str:
    """Id of a control in a browser's messages."""
    return handle._impl.uuid


def live_connections(server: viser.ViserServer) -> list[Any]:
    return list(_socket_server(server)._live_connections.values())


def disconnect_all(server: viser.ViserServer) -> None:
    _socket_server(server).disconnect_all_clients()


def shared_messages(server: viser.ViserServer) -> dict[int, Any]:
    """Messages to a new browser, by their order."""
    return _socket_server(server)._broadcast_buffer.message_from_id


def handlers(server: viser.ViserServer) -> dict[type, Any]:
    """Handlers of messages, by type."""
    return _socket_server(server)._incoming_handlers


def uploads(server: viser.ViserServer) -> dict[str, Any]:
    """Unfinished uploads, by their id."""
    return server.gui._current_file_upload_states  # pyright: ignore[reportReturnType]


def message_producer(module: Any) -> Callable[..., Any]:
    """The loop that sends a connection's messages, of viser's `infra` or a copy of it."""
    return module._message_producer


def type_hints(handle: Any) -> dict[str, Any]:
    """Types of a control's properties."""
    return handle._prop_hints


def _socket_server(server: viser.ViserServer) -> Any:
    return server._websock_server
