"""Client without a browser."""

from __future__ import annotations

import asyncio
import contextlib
import struct
import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Final

import msgspec
import numpy as np
import websockets
import zstandard
from websockets.typing import Subprotocol

from app.web.viser_internals import VISER_VERSION


def decode_frame(frame: bytes) -> tuple[list[dict[str, Any]], float]:
    """Messages in a frame, arrays as numpy, and the server's time stamp [s]."""
    size, packed = struct.unpack_from("<QQ", frame)
    body = zstandard.ZstdDecompressor().decompress(frame[16 : 16 + packed], max_output_size=size)
    content = msgspec.msgpack.decode(body)
    offsets, at = [], 16 + packed
    for length in content["binaryBufferLengths"]:
        at += -at % 8
        offsets.append((at, length))
        at += length

    def fill(value: Any) -> Any:
        if isinstance(value, dict):
            if "__binary_index" in value and "dtype" in value:
                start, length = offsets[value["__binary_index"]]
                return np.frombuffer(frame[start : start + length], dtype=value["dtype"])
            return {key: fill(entry) for key, entry in value.items()}
        return [fill(entry) for entry in value] if isinstance(value, list) else value

    return [fill(message) for message in content["messages"]], content["timestampSec"]


class Mirror:
    """The page after the messages so far.

    Attributes:
        gui: uuid → properties, with `type`, `value` (if any) and `container_uuid`.
        nodes: name → properties, with `type`, `owner`, `wxyz`, `position`.
        commands: uuid → properties of a palette command.
        replayed: True once all earlier messages have arrived.
    """

    def __init__(self) -> None:
        self.gui: dict[str, dict[str, Any]] = {}
        self.nodes: dict[str, dict[str, Any]] = {}
        self.commands: dict[str, dict[str, Any]] = {}
        self.replayed = False

    def take(self, message: dict[str, Any]) -> None:
        """Ignores kinds that draw nothing."""
        kind: str = message["type"]
        if kind == "ReplayDoneMessage":
            self.replayed = True
        elif kind == "GuiUpdateMessage":
            self.gui.get(message["uuid"], {}).update(message["updates"])
        elif kind == "GuiRemoveMessage":
            self.gui.pop(message["uuid"], None)
        elif kind == "ResetGuiMessage":
            self.gui.clear()
        elif kind == "RegisterCommandMessage":
            self.commands[message["uuid"]] = {**message, **(message.get("props") or {})}
        elif kind == "RemoveCommandMessage":
            self.commands.pop(message["uuid"], None)
        elif kind == "SceneNodeUpdateMessage":
            self._node(message).update(message["updates"])
        elif kind == "SetPositionMessage":
            self._node(message)["position"] = tuple(message["position"])
        elif kind == "SetOrientationMessage":
            self._node(message)["wxyz"] = tuple(message["wxyz"])
        elif kind == "SetSceneNodeVisibilityMessage":
            self._node(message)["visible"] = message["visible"]
        elif kind == "SetSceneNodeDragBindingsMessage":
            self._node(message)["grabbable"] = bool(message["bindings"])
        elif kind == "RemoveSceneNodeMessage":
            self.nodes.pop(message["name"], None)
        elif "props" in message and "uuid" in message:
            self.gui[message["uuid"]] = {
                **message["props"],
                **{key: value for key, value in message.items() if key != "props"},
            }
        elif "props" in message and "name" in message:
            self._node(message).update(message["props"], type=kind, owner=message.get("owner", ""))

    def _node(self, message: dict[str, Any]) -> dict[str, Any]:
        return self.nodes.setdefault(
            message["name"], {"wxyz": (1.0, 0.0, 0.0, 0.0), "position": (0.0, 0.0, 0.0)}
        )

    @property
    def grabbable(self) -> set[str]:
        """Names of draggable scene nodes."""
        return {name for name, node in list(self.nodes.items()) if node.get("grabbable") and "owner" in node}

    def labelled(self, label: str, kind: str = "") -> dict[str, Any]:
        """GUI element with this label and kind (such as "GuiSliderMessage").

        Raises:
            KeyError: no such element; the message lists the labels.
        """
        # May be called from another thread than the one that mirrors.
        for element in list(self.gui.values()):
            if element.get("label") == label and kind in ("", element["type"]):
                return element
        labels = sorted({str(element.get("label")) for element in list(self.gui.values())})
        raise KeyError(f"no {kind or 'element'} labelled {label!r}; there are {labels}")


CAMERA: Final[dict[str, Any]] = {
    "type": "ViewerCameraMessage",
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [3.0, 3.0, 3.0],
    "fov": 1.3,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 800,
    "image_width": 1200,
    "look_at": [0.0, 0.0, 0.0],
    "up_direction": [0.0, 0.0, 1.0],
}


@dataclass
class Received:
    """Counters since the last reset.

    Attributes:
        frames: updates of the page.
        messages: by type; empty unless frames are decoded.
        times: arrival of each frame, `perf_counter` [s].
    """

    frames: int = 0
    bytes: int = 0
    messages: Counter[str] = field(default_factory=Counter)
    times: list[float] = field(default_factory=list)


class HeadlessClient:
    """One connection.

    Args:
        url: such as `http://127.0.0.1:8080` (or `ws://`).
        decode: False only counts, which is far cheaper.

    Attributes:
        closed: reason for the end; None while it is open.
    """

    def __init__(
        self,
        url: str,
        query: str = "",
        *,
        decode: bool = True,
        headers: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        base = url.replace("http://", "ws://", 1).replace("https://", "wss://", 1).rstrip("/")
        self.url = f"{base}/?{query}" if query else base
        self.mirror = Mirror()
        self.received = Received()
        self.closed: websockets.ConnectionClosed | None = None
        self._decode, self._headers = decode, headers
        self._news = asyncio.Event()
        self._reader: asyncio.Task[None] | None = None
        self._socket: websockets.ClientConnection | None = None

    async def connect(self, timeout: float = 30.0, *, camera: bool = True) -> HeadlessClient:
        """Connect; a camera makes us a visitor.

        Raises:
            websockets.InvalidStatus: the server refuses the connection (wrong Origin).
        """
        self._socket = await websockets.connect(
            self.url,
            additional_headers=self._headers,
            subprotocols=[Subprotocol(f"viser-v{VISER_VERSION}")],
            max_size=None,
            compression=None,
            ping_interval=None,
            open_timeout=timeout,
            close_timeout=10.0,
            proxy=None,
        )
        if camera:
            # A full server closes at once; the reader sets `closed`.
            with contextlib.suppress(websockets.ConnectionClosed):
                await self.send(CAMERA)
        self._reader = asyncio.create_task(self._read())
        return self

    async def _read(self) -> None:
        assert self._socket is not None
        try:
            while True:
                frame = await self._socket.recv()
                assert isinstance(frame, bytes)
                self.received.frames += 1
                self.received.bytes += len(frame)
                self.received.times.append(time.perf_counter())
                if self._decode:
                    messages, _ = decode_frame(frame)
                    for message in messages:
                        self.received.messages[message["type"]] += 1
                        self.mirror.take(message)
                self._news.set()
        except websockets.ConnectionClosed as closed:
            self.closed = closed
        finally:
            self._news.set()

    def reset_counters(self) -> None:
        self.received = Received()

    async def send(self, message: dict[str, Any]) -> None:
        """`message`: with `type`."""
        await self.send_raw(msgspec.msgpack.encode(message))

    async def send_raw(self, data: bytes | str) -> None:
        assert self._socket is not None
        await self._socket.send(data)

    async def pull(self, name: str, phase: str, taken: object, to: object) -> None:
        """One step of dragging a node: `phase` "start", "update" or "end"; `taken`, `to`: (3,), world [m]."""
        middle = {"start_screen_pos": (0.5, 0.5), "end_screen_pos": (0.5, 0.5), "instance_index": None}
        pulled = {"start_position": taken, "end_position": to, "button": "left", "modifier": None}
        owner = self.mirror.nodes[name].get("owner", "")
        await self.send(
            {"type": "SceneNodeDragMessage", "name": name, "owner": owner, "phase": phase, **middle, **pulled}
        )

    async def wait_for(self, predicate: Callable[[HeadlessClient], object], timeout: float = 60.0) -> None:
        """Wait until `predicate(self)` is true.

        Raises:
            TimeoutError: it never was.
        """
        end = time.perf_counter() + timeout
        while not predicate(self):
            if time.perf_counter() > end:
                raise TimeoutError(f"not within {timeout} s; connection closed: {self.closed}")
            self._news.clear()
            # The predicate may depend on things that change without a frame.
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._news.wait(), 0.05)

    async def close(self) -> None:
        """May be called twice."""
        if self._socket is not None:
            await self._socket.close()
        if self._reader is not None:
            with contextlib.suppress(asyncio.CancelledError):
                await self._reader
