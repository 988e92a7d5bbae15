"""What the messages of viser's own client look like: the fields of each kind, and what may stand in them.

A check is a function of a value that returns, or raises `Malformed` or `Refused`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Final

from app.server.refusal import Malformed, Refused

_LARGEST: Final = 1e9  # far beyond anything in the scene, near enough that squares and products stay finite

Check = Callable[[object], None]


def number(low: float = -_LARGEST, high: float = _LARGEST) -> Check:
    """Return a check for a finite number between bounds."""

    def check(value: object) -> None:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise Malformed("not a number")
        if not (math.isfinite(value) and low <= value <= high):
            raise Refused("number out of range")

    return check


def row(length: int | None, item: Check) -> Check:
    """Return a check for a row of so many items (None: up to 64), each checked by itself."""

    def check(value: object) -> None:
        if not isinstance(value, (list, tuple)) or len(value) > 64 or (length is not None and len(value) != length):
            raise Malformed("not a row of the right length")
        for entry in value:
            item(entry)

    return check


def _whole(value: object) -> None:
    number(0)(value)
    assert isinstance(value, (int, float))
    if value != int(value):
        raise Malformed("not a whole number")


def text(longest: int) -> Check:
    """Return a check for a text of so many bytes at most."""

    def check(value: object) -> None:
        if not isinstance(value, str):
            raise Malformed("not a text")
        if len(value) > longest or len(value.encode()) > longest:
            raise Refused("text too long")

    return check


def _rotation(value: object) -> None:
    row(4, number())(value)
    assert isinstance(value, (list, tuple))
    # Callers divide by the norm.
    if not 0.25 < sum(x * x for x in value) < 4.0:
        raise Refused("number out of range")


def _blob(value: object) -> None:
    if not isinstance(value, bytes):
        raise Malformed("not bytes")


def _updates(value: object) -> None:
    if not isinstance(value, dict):
        raise Malformed("not a dictionary")
    if set(value) != {"value"}:
        raise Refused("attribute other than the value")


def _or_none(item: Check) -> Check:
    return lambda value: None if value is None else item(value)


_name, _point, _any_text = text(256), row(3, number()), text(16 * 1024 * 1024)
_pixel = row(2, number())
_owned = {"name": _name, "owner": _name}

# All that viser 1.1's own client ever sends, except its requests for a public tunnel.
SHAPES: Mapping[str, Mapping[str, Check]] = {
    "ViewerCameraMessage": {
        "wxyz": _rotation,
        "position": _point,
        "fov": number(0.0, math.pi),
        "near": number(0.0),
        "far": number(0.0),
        "image_height": number(0),
        "image_width": number(0),
        "look_at": _point,
        "up_direction": _point,
    },
    "GuiUpdateMessage": {"uuid": _name, "updates": _updates},
    "GuiButtonHoldMessage": {"uuid": _name, "frequency": number(0.0)},
    "GuiFormSubmitMessage": {"uuid": _name},
    "GuiFormDirtyMessage": {"uuid": _name},
    "CommandTriggerMessage": {"uuid": _name},
    "FileTransferStartUpload": {
        "source_component_uuid": _name,
        "transfer_uuid": text(64),
        "filename": text(1024),
        "mime_type": _name,
        "part_count": _whole,
        "size_bytes": _whole,
    },
    "FileTransferPart": {
        "source_component_uuid": _or_none(_name),
        "transfer_uuid": text(64),
        "part_index": _whole,
        "content": _blob,
    },
    "TransformControlsUpdateMessage": {**_owned, "wxyz": _rotation, "position": _point},
    "TransformControlsDragStartMessage": _owned,
    "TransformControlsDragEndMessage": _owned,
    "SceneNodeClickMessage": {
        **_owned,
        "instance_index": _or_none(_whole),
        "ray_origin": _point,
        "ray_direction": _point,
        "screen_pos": _pixel,
        "modifier": _or_none(_name),
    },
    "SceneNodeDragMessage": {
        **_owned,
        "phase": _name,
        "instance_index": _or_none(_whole),
        "start_position": _point,
        "start_screen_pos": _pixel,
        "end_position": _point,
        "end_screen_pos": _pixel,
        "button": _name,
        "modifier": _or_none(_name),
    },
    "ScenePointerMessage": {
        "event_type": _name,
        "ray_origin": _or_none(_point),
        "ray_direction": _or_none(_point),
        "screen_pos": row(None, _pixel),
        "modifier": _or_none(_name),
    },
    "GetRenderResponseMessage": {"payload": _blob, "render_uuid": _name},
    "LocalStorageGetItemResponseMessage": {"value": _or_none(_any_text), "error": _or_none(_any_text), "request_uuid": _name},
}
