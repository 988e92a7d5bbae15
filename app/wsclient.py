"""A visitor without a browser: speaks viser's protocol, keeps a mirror of the page, counts what arrives.

For tests and for the benchmark. Knows the wire format, not viser's Python classes. A frame is two 8-byte little-endian sizes,
zstd-compressed msgpack, and raw arrays aligned to 8 bytes.
"""

from __future__ import annotations

import asyncio
import contextlib
import struct
import threading
import time
from collections import Counter
from collections.abc import Callable, Coroutine
from dataclasses import dataclass, field
from typing import Any, TypeVar

import msgspec
import numpy as np
import viser
import websockets
import zstandard
from websockets.typing import Origin, Subprotocol

T = TypeVar("T")

CAMERA: dict[str, Any] = {
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
    """What has arrived since the counters were last reset.

    Attributes:
        frames: websocket messages (viser calls them windows; one is one update of the page).
        bytes: their size.
        messages: viser messages by type; stays empty unless frames are decoded.
        lags: from the server's `perf_counter` at sending to ours at receipt, in seconds; means something on one machine only.
    """

    frames: int = 0
    bytes: int = 0
    messages: Counter[str] = field(default_factory=Counter)
    lags: list[float] = field(default_factory=list)


def decode_frame(frame: bytes) -> tuple[list[dict[str, Any]], float]:
    """The messages in one frame, arrays as numpy, and the server's time stamp."""
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
    """The page as the messages so far have built it.

    Attributes:
        gui: uuid → properties of a GUI element, with `type`, `value` (if it has one) and `container_uuid`.
        nodes: name → properties of a scene node, with `type`, `owner`, `wxyz`, `position`.
        commands: uuid → properties of a palette command.
        replayed: whether the server has sent everything that existed before we came.
    """

    def __init__(self) -> None:
        self.gui: dict[str, dict[str, Any]] = {}
        self.nodes: dict[str, dict[str, Any]] = {}
        self.commands: dict[str, dict[str, Any]] = {}
        self.replayed = False

    def take(self, message: dict[str, Any]) -> None:
        """Apply one message; kinds that draw nothing are ignored."""
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
        elif kind == "RemoveSceneNodeMessage":
            self.nodes.pop(message["name"], None)
        elif "props" in message and "uuid" in message:
            self.gui[message["uuid"]] = {**message["props"], **{key: value for key, value in message.items() if key != "props"}}
        elif "props" in message and "name" in message:
            self._node(message).update(message["props"], type=kind, owner=message.get("owner", ""))

    def _node(self, message: dict[str, Any]) -> dict[str, Any]:
        return self.nodes.setdefault(message["name"], {"wxyz": (1.0, 0.0, 0.0, 0.0), "position": (0.0, 0.0, 0.0)})

    def labelled(self, label: str, kind: str = "") -> dict[str, Any]:
        """The GUI element with this label, and of this kind (such as "GuiSliderMessage") if given.

        Raises:
            KeyError: there is none; the message lists the labels that exist.
        """
        for element in self.gui.values():
            if element.get("label") == label and kind in ("", element["type"]):
                return element
        there_are = sorted({str(element.get("label")) for element in self.gui.values()})
        raise KeyError(f"no {kind or 'element'} labelled {label!r}; there are {there_are}")


class Visitor:
    """One connection.

    Args:
        url: the page's address, such as `http://127.0.0.1:8080` (`ws://` will do too).
        origin: what to send as Origin; None for none, as programs do.
        query: the deep link's query without `?`.
        decode: False only counts frames and bytes, which costs next to nothing.
        read_pause: seconds to wait between frames, to play a slow one.
        language: what to send as Accept-Language; "" for none, as programs do.

    Attributes:
        mirror: the page so far.
        received: counters.
        closed: why the connection ended, None while it lives.
    """

    def __init__(
        self,
        url: str,
        origin: str | None = None,
        query: str = "",
        *,
        decode: bool = True,
        read_pause: float = 0.0,
        language: str = "",
    ) -> None:
        base = url.replace("http://", "ws://", 1).replace("https://", "wss://", 1).rstrip("/")
        self.url = f"{base}/?{query}" if query else base
        self.mirror = Mirror()
        self.received = Received()
        self.closed: websockets.ConnectionClosed | None = None
        self._origin = origin
        self._decode = decode
        self._read_pause = read_pause
        self._headers = {"Accept-Language": language} if language else {}
        self._news = asyncio.Event()
        self._reader: asyncio.Task[None] | None = None
        self._socket: websockets.ClientConnection | None = None

    async def connect(self, timeout: float = 10.0, *, camera: bool = True) -> Visitor:
        """Connect, and say where we look from, after which the server counts us in.

        Raises:
            websockets.InvalidStatus: turned away (wrong Origin).
        """
        self._socket = await websockets.connect(
            self.url,
            origin=None if self._origin is None else Origin(self._origin),
            additional_headers=self._headers,
            subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
            max_size=None,
            compression=None,
            ping_interval=None,
            open_timeout=timeout,
            close_timeout=2.0,
            proxy=None,
        )
        if camera:
            # A full room closes at once; the reader will tell.
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
                if self._decode:
                    messages, sent_at = decode_frame(frame)
                    self.received.lags.append(time.perf_counter() - sent_at)
                    for message in messages:
                        self.received.messages[message["type"]] += 1
                        self.mirror.take(message)
                self._news.set()
                if self._read_pause:
                    await asyncio.sleep(self._read_pause)
        except websockets.ConnectionClosed as closed:
            self.closed = closed
        finally:
            self._news.set()

    def reset_counters(self) -> None:
        """Count from here."""
        self.received = Received()

    async def send(self, message: dict[str, Any]) -> None:
        """Send one message, as a dictionary with `type`."""
        await self.send_raw(msgspec.msgpack.encode(message))

    async def send_raw(self, data: bytes | str) -> None:
        """Send anything at all."""
        assert self._socket is not None
        await self._socket.send(data)

    async def set_value(self, label: str, value: object) -> None:
        """Operate the GUI element with this label."""
        await self.send({"type": "GuiUpdateMessage", "uuid": self.mirror.labelled(label)["uuid"], "updates": {"value": value}})

    async def click(self, label: str) -> None:
        """Press the button with this label."""
        uuid = self.mirror.labelled(label, "GuiButtonMessage")["uuid"]
        await self.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": True}})

    async def move_gizmo(
        self, name: str, position: object = (0.0, 0.0, 0.0), wxyz: object = (1.0, 0.0, 0.0, 0.0), *, phase: str = "update"
    ) -> None:
        """One step of dragging a gizmo; `phase` is "start", "update" or "end"."""
        message: dict[str, Any] = {"name": name, "owner": self.mirror.nodes[name].get("owner", "")}
        if phase == "update":
            message |= {"type": "TransformControlsUpdateMessage", "position": position, "wxyz": wxyz}
        else:
            message |= {"type": f"TransformControlsDrag{phase.capitalize()}Message"}
        await self.send(message)

    async def wait_for(self, predicate: Callable[[Visitor], object], timeout: float = 60.0) -> None:
        """Return as soon as `predicate(self)` is true; it is asked again after every frame and at the end of the connection.

        Raises:
            TimeoutError: it never was.
        """

        async def until() -> None:
            while not predicate(self):
                self._news.clear()
                # The predicate may also look at things that change without a frame.
                with contextlib.suppress(TimeoutError):
                    await asyncio.wait_for(self._news.wait(), 0.05)

        try:
            await asyncio.wait_for(until(), timeout)
        except TimeoutError as error:
            raise TimeoutError(f"not within {timeout} s; connection closed: {self.closed}") from error

    async def break_off(self, unfinished: bytes = b"") -> None:
        """End the connection as a lost line does, without a word; `unfinished`: a message of which only a part is sent before."""
        assert self._socket is not None
        if unfinished:
            # A masked binary frame (RFC 6455, section 5.2) that promises all, and half of it.
            head = b"\x82\xfe" + len(unfinished).to_bytes(2, "big") + b"\0\0\0\0"
            self._socket.transport.write(head + unfinished[: len(unfinished) // 2])
            await asyncio.sleep(0)
        self._socket.transport.abort()

    async def close(self) -> None:
        """Leave. May be called twice."""
        if self._socket is not None:
            await self._socket.close()
        if self._reader is not None:
            if self._read_pause:
                self._reader.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._reader


class SyncVisitor:
    """A `Visitor` for plain functions: its loop runs in a thread of its own.

    Needed where the calling thread already has a running loop, as it does while Playwright's synchronous interface is open.

    Raises, when made:
        websockets.InvalidStatus: turned away.
    """

    def __init__(self, url: str, origin: str | None = None, query: str = "", *, camera: bool = True, **options: Any) -> None:
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True, name="visitor")
        self._thread.start()
        try:
            self.visitor = self._run(self._make(url, origin, query, camera, options))
        except BaseException:
            self._end()
            raise

    @staticmethod
    async def _make(url: str, origin: str | None, query: str, camera: bool, options: dict[str, Any]) -> Visitor:
        return await Visitor(url, origin, query, **options).connect(camera=camera)

    def _run(self, work: Coroutine[Any, Any, T], timeout: float = 30.0) -> T:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(timeout)

    def _end(self) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(5.0)
        self._loop.close()

    @property
    def mirror(self) -> Mirror:
        """The page so far."""
        return self.visitor.mirror

    @property
    def received(self) -> Received:
        """The counters."""
        return self.visitor.received

    @property
    def closed(self) -> websockets.ConnectionClosed | None:
        """Why the connection ended, None while it lives."""
        return self.visitor.closed

    def send(self, message: dict[str, Any]) -> None:
        """See `Visitor.send`."""
        self._run(self.visitor.send(message))

    def send_raw(self, data: bytes | str) -> None:
        """See `Visitor.send_raw`."""
        self._run(self.visitor.send_raw(data))

    def set_value(self, label: str, value: object) -> None:
        """See `Visitor.set_value`."""
        self._run(self.visitor.set_value(label, value))

    def click(self, label: str) -> None:
        """See `Visitor.click`."""
        self._run(self.visitor.click(label))

    def move_gizmo(
        self, name: str, position: object = (0.0, 0.0, 0.0), wxyz: object = (1.0, 0.0, 0.0, 0.0), *, phase: str = "update"
    ) -> None:
        """See `Visitor.move_gizmo`."""
        self._run(self.visitor.move_gizmo(name, position, wxyz, phase=phase))

    def wait_for(self, predicate: Callable[[Visitor], object], timeout: float = 60.0) -> None:
        """See `Visitor.wait_for`; the predicate runs in the visitor's thread."""
        self._run(self.visitor.wait_for(predicate, timeout), timeout + 5.0)

    def break_off(self, unfinished: bytes = b"") -> None:
        """See `Visitor.break_off`."""
        self._run(self.visitor.break_off(unfinished))

    def close(self) -> None:
        """Leave and end the thread. May be called twice."""
        if self._loop.is_closed():
            return
        try:
            self._run(self.visitor.close())
        finally:
            self._end()

    def __enter__(self) -> SyncVisitor:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
