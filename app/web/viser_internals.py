"""viser's private side, for viser 1.1.x; no other file of Duet uses it. Tests in `tests/app/web` fail
where a new version differs."""

from __future__ import annotations

import asyncio
import contextlib
import threading
import types
from asyncio import AbstractEventLoop
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, Final, cast, get_args, get_origin, get_type_hints
from zipfile import ZipFile

import numpy as np
import numpy.typing as npt
import viser
import viser.infra._infra as viser_infra
import websockets
from viser import _gui_api, _gui_handles, _messages, _scene_handles
from viser._assignable_props_api import AssignablePropsBase, colors_to_uint8, props_setattr
from viser._icons import ICONS_DIR
from viser._messages import HotkeyKey as HotkeyKey
from viser._scene_api import cast_vector
from viser.infra._async_message_buffer import AsyncMessageBuffer as MessageBuffer
from viser.infra._messages import Message as Message
from viser.infra._messages import _prepare_for_serialization, wire_field_names
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request

from app.web.entries import Entries
from app.web.schemas import Control, Scope

VISER_VERSION: Final = viser.__version__
append_aligned_buffers: Final = viser_infra._append_aligned_buffers


def client_html() -> str:
    return (Path(viser.__file__).parent / "client" / "build" / "index.html").read_text(encoding="utf-8")


# --- one browser ---------------------------------------------------------------------------------------------------------------


def connection_of(server: viser.ViserServer, client_id: int) -> ServerConnection | None:
    """None if the browser is gone."""
    return server._websock_server._live_connections.get(cast(Any, client_id))


def client_id_of(server: viser.ViserServer, connection: ServerConnection) -> int:
    """−1 for an unknown connection."""
    return next((i for i, live in server._websock_server._live_connections.items() if live is connection), -1)


def client_of(server: viser.ViserServer, client_id: int) -> viser.ClientHandle | None:
    """Handle of a browser, also during viser's calls for its arrival."""
    return server._connected_clients.get(client_id)


def server_of(client: viser.ClientHandle) -> viser.ViserServer:
    return client._viser_server


def request_of(client: viser.ClientHandle) -> Request | None:
    """None if the browser is gone."""
    connection = connection_of(client._viser_server, client.client_id)
    return None if connection is None else connection.request


# --- elements ------------------------------------------------------------------------------------------------------------------


def uuid_of(handle: viser.GuiInputHandle[Any] | viser.GuiButtonHandle) -> str:
    return handle._impl.uuid


def container_uuid_of(handle: viser.GuiInputHandle[Any]) -> str:
    """Id of its tab or folder."""
    return handle._impl.parent_container_id


class GuiRegistry:
    """Elements of a server's pages."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server

    def _guis(self, client_id: int) -> Iterator[tuple[viser.GuiApi, Scope]]:
        client = client_of(self._server, client_id)
        if client is not None:
            yield client.gui, "own"
        yield self._server.gui, "shared"

    def control(self, client_id: int, uuid: str) -> Control | None:
        """None if this browser does not have it."""
        for gui, scope in self._guis(client_id):
            handle = gui._gui_input_handle_from_uuid.get(uuid)
            if handle is None or handle._impl.removed:
                continue
            props = handle._impl.props
            takes_files = isinstance(handle, viser.GuiUploadButtonHandle)
            # The labels of a row of buttons may change while a press is on its way; the receiver knows what
            # it means.
            changes = isinstance(handle, viser.GuiButtonGroupHandle)
            return Control(
                scope=scope,
                value=None if takes_files else handle._impl.value,
                enabled=not getattr(props, "disabled", False),
                low=getattr(props, "min", None),
                high=getattr(props, "max", None),
                options=None if changes else getattr(props, "options", None),
                takes_files=takes_files,
            )
        return None

    def form(self, client_id: int, uuid: str) -> Scope | None:
        """None if this browser does not have it."""
        for gui, scope in self._guis(client_id):
            if isinstance(gui._container_handle_from_uuid.get(uuid), viser.GuiFormHandle):
                return scope
        return None

    def command(self, client_id: int, uuid: str) -> Scope | None:
        """None if this browser does not have it."""
        return next(
            (scope for gui, scope in self._guis(client_id) if uuid in gui._command_handle_from_uuid), None
        )


# --- the server ----------------------------------------------------------------------------------------------------------------

_construction: Final = threading.Lock()


@contextlib.contextmanager
def serving_with(serve: Callable[..., Any]) -> Iterator[None]:
    """Context in which viser's new servers call `serve` in place of `websockets.asyncio.server.serve`; the
    library is not changed."""
    stand_in = types.SimpleNamespace(
        asyncio=types.SimpleNamespace(
            server=types.SimpleNamespace(serve=serve, ServerConnection=ServerConnection)
        ),
        exceptions=websockets.exceptions,
        datastructures=websockets.datastructures,
    )
    with _construction:
        names = cast(dict[str, Any], vars(viser_infra))
        original, names["websockets"] = names["websockets"], stand_in
        try:
            yield
        finally:
            names["websockets"] = original


def remove_share_handlers(server: viser.ViserServer) -> None:
    """Ignore requests for a public tunnel."""
    for kind in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        server._websock_server.unregister_handler(kind)


# --- for all servers of the process --------------------------------------------------------------------------------------------

_produce: Final = viser_infra._message_producer
_client_state: Final = viser_infra._ClientHandleState
_hints_of: Final = cache(get_type_hints)
_take_value: Final = _gui_api.GuiApi._handle_gui_updates


_MOVES: Final = frozenset(
    (_messages.SetOrientationMessage, _messages.SetPositionMessage, _messages.SetSceneNodeVisibilityMessage)
)
"""Messages with plain numbers."""


def adapt_viser(client_buffer: Callable[[AbstractEventLoop], MessageBuffer]) -> None:
    """Replace parts of viser for the whole process; a second call changes nothing.

    - A connection's `send_windows` replaces viser's loop.
    - Messages to one browser alone wait in a `client_buffer`.
    - The types of an element's properties are looked up once per class.
    - Setting an unchanged property or pose is cheap: a frame sets some forty properties and twenty poses.
    - The key of a node's move is computed faster.
    - An entry is not overwritten before it is acted upon; see `app.web.entries`.
    - Icons are read once; viser keeps 32, and reads the archive's directory for every icon.
    """
    viser_infra._message_producer = _send_windows
    names = cast(dict[str, Any], vars(viser_infra))
    names["_ClientHandleState"] = lambda _, loop: _client_state(client_buffer(loop), loop)
    # Type checkers see the attribute as a cached property of every handle.
    setattr(AssignablePropsBase, "_prop_hints", _hints)  # noqa: B010
    setattr(AssignablePropsBase, "_cast_value_recursive", _cast_property)  # noqa: B010
    setattr(AssignablePropsBase, "__setattr__", _set_property)  # noqa: B010
    cast(dict[str, Any], vars(_scene_handles))["_set_pose_vector"] = _set_pose
    for kind in _MOVES:
        setattr(kind, "redundancy_key", _key_of_move)  # noqa: B010
    setattr(_gui_api.GuiApi, "_handle_gui_updates", _take_entry)  # noqa: B010
    for module in (_gui_api, _gui_handles):
        vars(module)["svg_from_icon"] = _icon


def _key_of_move(message: Any) -> str:
    return f"scene:{message.name}:update:{type(message).__name__}"


async def _send_windows(
    connection: ServerConnection,
    buffer: MessageBuffer,
    client_id: int,
    backlog_done_message: Message | None = None,
) -> None:
    own = getattr(connection, "send_windows", None)
    if own is None:
        await _produce(connection, buffer, client_id, backlog_done_message)
    else:
        await own(buffer, client_id, backlog_done_message)


@property
def _hints(handle: AssignablePropsBase[Any]) -> dict[str, Any]:
    return _hints_of(type(handle._impl.props))


_FLOATS: Final[dict[Any, type]] = {npt.NDArray[kind]: kind for kind in (np.float16, np.float32, np.float64)}
_BYTES: Final = npt.NDArray[np.uint8]
_PLAIN: Final = frozenset((str, bool, int, float))


def _set_property(handle: AssignablePropsBase[Any], name: str, value: Any) -> None:
    """Set an attribute as viser does, with a shortcut for plain values and arrays of numbers."""
    state = vars(handle).get("_impl")
    if state is None or state.removed:
        props_setattr(handle, name, value)
        return
    setter = _setters_of(type(handle)).get(name)
    if setter is not None:
        if name != "value" or _may_write(handle):
            setter(handle, value)
        return
    props, kind = state.props, type(value)
    current = vars(props).get(name)
    if (
        kind is type(current)
        and (kind in _PLAIN or (kind is tuple and set(map(type, value)) <= _PLAIN))
        and value == current
    ):
        return
    number = _number_of(type(props), name)
    if (
        number is None
        or current is None
        or current.dtype != number
        or (number is np.uint8 and getattr(value, "dtype", None) != number)
    ):
        props_setattr(handle, name, value)
        return
    # A copy, so that nothing changes it while it waits to be sent.
    new = np.array(value, number)
    if new.shape != current.shape:
        setattr(props, name, new.copy())
    elif (new == current).all():
        return
    else:
        current[...] = new
    handle._queue_update(name, new)
    handle._on_prop_assigned(name)


def _entries_of(gui: Any) -> Entries | None:
    """None for a shared GUI."""
    return getattr(gui._websock_interface.get_message_buffer(), "entries", None)


def _may_write(handle: Any) -> bool:
    entries = _entries_of(handle._impl.gui_api)
    return entries is None or entries.dealt_before(handle._impl.uuid) is not None


async def _take_entry(gui: Any, client_id: Any, message: _messages.GuiUpdateMessage) -> None:
    """Handle a value as viser does; an action that its callbacks post claims the entry."""
    handle, entries = gui._gui_input_handle_from_uuid.get(message.uuid), _entries_of(gui)
    if handle is None or entries is None:
        await _take_value(gui, client_id, message)
        return
    state, entered = handle._impl, message.updates["value"]

    def settle() -> None:
        state.value = type(state.value)(entered)

    with entries.taking(message.uuid, settle):
        await _take_value(gui, client_id, message)


@cache
def _setters_of(kind: type) -> dict[str, Callable[[Any, Any], None]]:
    found = {name: getattr(kind, name, None) for name in dir(kind)}
    return {
        name: one.fset for name, one in found.items() if isinstance(one, property) and one.fset is not None
    }


@cache
def _number_of(props: type, name: str) -> type | None:
    """None unless the property is one array of numbers."""
    hint = _hints_of(props).get(name)
    return (
        np.uint8
        if hint == _BYTES and "color" in name
        else _FLOATS.get(hint)
        if isinstance(hint, types.GenericAlias)
        else None
    )


def _cast_property(handle: AssignablePropsBase[Any], hint: Any, value: Any, name: str) -> Any:
    if hint in _FLOATS:
        return np.asarray(value).astype(_FLOATS[hint])
    if hint == _BYTES and "color" in name:
        return colors_to_uint8(value)
    if (
        isinstance(value, tuple)
        and get_origin(hint) is tuple
        and len(kinds := get_args(hint)) == 2
        and kinds[1] is ...
    ):
        return tuple(_cast_property(handle, kinds[0], item, name) for item in value)
    return value


def _set_pose(
    current: npt.NDArray[np.float64],
    value: Any,
    length: int,
    queue: Callable[[Any], None],
    make_message: Callable[[Any], Any],
) -> None:
    """Queue a part of a pose, unless it is within `numpy.allclose` of the old one."""
    numbers = cast_vector(
        value.tolist() if isinstance(value, np.ndarray) and value.ndim == 1 else value, length
    )
    for new, old in zip(numbers, current.tolist(), strict=True):
        if not abs(new - old) <= 1e-8 + 1e-5 * abs(old):
            current[:] = numbers
            queue(make_message(numbers))
            return


def turn(node: viser.SceneNodeHandle, wxyz: tuple[float, float, float, float]) -> None:
    """Set a node's `wxyz` without checks: an arm turns seven nodes a frame."""
    state = node._impl
    if state.removed:
        node.wxyz = wxyz  # viser raises its own error.
    state.wxyz[:] = wxyz
    state.api._queue_scene_message(_messages.SetOrientationMessage(state.name, wxyz))


def aim(
    camera: viser.CameraHandle, eye: npt.NDArray[np.float64], look_at: npt.NDArray[np.float64], fov: float
) -> None:
    """Point a client's camera; its handle keeps the browser's last values. viser's setters move the aim with
    the position, and skip values equal to the browser's, perhaps outdated ones.

    Args:
        eye, look_at: (3,) [m].
        fov: vertical [rad].
    """
    for message in (
        _messages.SetCameraPositionMessage(cast_vector(eye, 3)),
        _messages.SetCameraLookAtMessage(cast_vector(look_at, 3)),
        _messages.SetCameraFovMessage(fov),
    ):
        camera.client._websock_connection.queue_message(message)


@cache
def _icon(name: str) -> str:
    return _icons().read(f"{name}.svg").decode("utf-8")


@cache
def _icons() -> ZipFile:
    return ZipFile(ICONS_DIR / "tabler-icons.zip")


# --- what is sent --------------------------------------------------------------------------------------------------------------

_UPDATES: Final = frozenset((_messages.GuiUpdateMessage, _messages.SceneNodeUpdateMessage))
_STAMP: Final = "after"
"""Key for the number of messages handled at a write, for `entries.js`."""


def stamp_value(message: Message, entries: Entries) -> bool:
    """Stamp a write into a control. False if an entry waits there, so that it may not be sent."""
    if type(message) is not _messages.GuiUpdateMessage or "value" not in message.updates:
        return True
    after = entries.dealt_before(message.uuid)
    setattr(message, _STAMP, after)
    return after is not None


def content_of(message: Message, arrays: list[memoryview]) -> dict[str, Any]:
    """A message as viser packs it, with a shortcut for frequent kinds; appends to `arrays`."""
    kind = type(message)
    if kind not in _MOVES and kind not in _UPDATES:
        return message.as_serializable_dict(arrays)
    content = {name: getattr(message, name) for name in wire_field_names(kind)}
    if kind in _UPDATES:
        content["updates"] = {
            name: value if type(value) in _PLAIN else _prepare_for_serialization(value, Any, arrays)
            for name, value in content["updates"].items()
        }
    content["type"] = kind.__name__
    if (after := getattr(message, _STAMP, None)) is not None:
        content[_STAMP] = after
    return content


def nodes_of(scene: viser.SceneApi) -> dict[str, dict[str, Any]]:
    """Node name → pose, visibility and properties; arrays change with the node."""
    states = {name: handle._impl for name, handle in scene._handle_from_node_name.items()}
    return {
        name: {"wxyz": state.wxyz, "position": state.position, "visible": state.visible, **vars(state.props)}
        for name, state in states.items()
    }


# --- what only some browsers see -----------------------------------------------------------------------------------------------


def shared_messages(server: viser.ViserServer) -> list[Message]:
    buffer = server._websock_server._broadcast_buffer
    with buffer.buffer_lock:
        return list(buffer.message_from_id.values())


class _LoopEvent(asyncio.Event):
    """Event that only its event loop sets: viser also does so from other threads, where asyncio may raise."""

    def set(self) -> None:
        with contextlib.suppress(RuntimeError):
            asyncio.get_running_loop()
            super().set()


class _Channel(viser_infra.WebsockMessageHandler):
    """Stand-in for viser's websocket server; receives nothing."""

    def __init__(self, buffer: MessageBuffer) -> None:
        super().__init__()
        self._broadcast_buffer = buffer

    def get_message_buffer(self) -> MessageBuffer:
        return self._broadcast_buffer

    def flush(self) -> None:
        self._broadcast_buffer.flush()


class ServerView(viser.ViserServer):
    """Scene and GUI with their own buffer, for some browsers. `before`: first messages to each."""

    def __init__(self, server: viser.ViserServer, before: list[Message]) -> None:
        self.buffer = MessageBuffer(
            server.get_event_loop(), persistent_messages=True, message_event=_LoopEvent()
        )
        for message in before:
            self.buffer.push(message)
        self._websock_server = _Channel(self.buffer)  # type: ignore[assignment]
        self._connected_clients = server._connected_clients
        self._scene_lifecycle_lock = server._scene_lifecycle_lock
        self._thread_executor, self._event_loop = server._thread_executor, server._event_loop
        self.scene = viser.SceneApi(self, self._thread_executor, self._event_loop)
        self.gui = viser.GuiApi(self, self._thread_executor, self._event_loop)

    def contain_elements_of(self, client: viser.ClientHandle) -> None:
        """Allow a browser's own elements inside these panels."""
        # viser looks for the panels around a client's elements on the server that the client came to.
        client.gui._root_server = lambda: self

    def drop_removed(self) -> None:
        self._run_garbage_collector()


class _PlacedForOne(_gui_handles._PlacementMixin):
    def __init__(self, client: viser.ClientHandle, panel: viser.PanelHandle) -> None:
        self._placement_uuid, self._placement_gui_api = panel._placement_uuid, client.gui


def expand_for(client: viser.ClientHandle, panel: viser.PanelHandle) -> None:
    """Unfold a panel for one browser only."""
    _PlacedForOne(client, panel).expand()
