"""What exists on a browser's page, looked up in viser's tables."""

from __future__ import annotations

from collections.abc import Iterator

import viser

from app.web.control_values import Control, Scope


class ViserGuiRegistry:
    """The `Elements` of a server's pages.

    Args:
        server: viser's.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server

    def _places(self, client_id: int) -> Iterator[tuple[viser.GuiApi, Scope]]:
        client = self._server._connected_clients.get(client_id)
        if client is not None:
            yield client.gui, "own"
        yield self._server.gui, "shared"

    def control(self, client_id: int, uuid: str) -> Control | None:
        """The input with this uuid, if this browser has it."""
        for gui, scope in self._places(client_id):
            handle = gui._gui_input_handle_from_uuid.get(uuid)
            if handle is None or handle._impl.removed:
                continue
            props = handle._impl.props
            takes_files = isinstance(handle, viser.GuiUploadButtonHandle)
            return Control(
                scope=scope,
                value=None if takes_files else handle._impl.value,
                enabled=not getattr(props, "disabled", False),
                low=getattr(props, "min", None),
                high=getattr(props, "max", None),
                options=getattr(props, "options", None),
                takes_files=takes_files,
            )
        return None

    def form(self, client_id: int, uuid: str) -> Scope | None:
        """Where the form with this uuid belongs, if this browser has it."""
        for gui, scope in self._places(client_id):
            if isinstance(gui._container_handle_from_uuid.get(uuid), viser.GuiFormHandle):
                return scope
        return None

    def command(self, client_id: int, uuid: str) -> Scope | None:
        """Where the palette command with this uuid belongs, if this browser has it."""
        for gui, scope in self._places(client_id):
            if uuid in gui._command_handle_from_uuid:
                return scope
        return None
