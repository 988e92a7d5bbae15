"""The page as the server's frames have built it: two 8-byte little-endian sizes, zstd-compressed msgpack, raw arrays aligned to 8 bytes."""

from __future__ import annotations

import struct
from typing import Any

import msgspec
import numpy as np
import zstandard


def decode_frame(frame: bytes) -> tuple[list[dict[str, Any]], float]:
    """Return the messages in one frame, arrays as numpy, and the server's time stamp [s]."""
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
        replayed: whether the server has sent everything that existed before the client connected.
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
        elif kind == "SetSceneNodeDragBindingsMessage":
            self._node(message)["grabbable"] = bool(message["bindings"])
        elif kind == "RemoveSceneNodeMessage":
            self.nodes.pop(message["name"], None)
        elif "props" in message and "uuid" in message:
            self.gui[message["uuid"]] = {**message["props"], **{key: value for key, value in message.items() if key != "props"}}
        elif "props" in message and "name" in message:
            self._node(message).update(message["props"], type=kind, owner=message.get("owner", ""))

    def _node(self, message: dict[str, Any]) -> dict[str, Any]:
        return self.nodes.setdefault(message["name"], {"wxyz": (1.0, 0.0, 0.0, 0.0), "position": (0.0, 0.0, 0.0)})

    @property
    def grabbable(self) -> set[str]:
        """Names of the scene nodes that can be taken hold of."""
        return {name for name, node in list(self.nodes.items()) if node.get("grabbable") and "owner" in node}

    def labelled(self, label: str, kind: str = "") -> dict[str, Any]:
        """The GUI element with this label, and of this kind (such as "GuiSliderMessage") if given.

        Raises:
            KeyError: there is none; the message lists the labels that exist.
        """
        for element in self.gui.values():
            if element.get("label") == label and kind in ("", element["type"]):
                return element
        labels = sorted({str(element.get("label")) for element in self.gui.values()})
        raise KeyError(f"no {kind or 'element'} labelled {label!r}; there are {labels}")
