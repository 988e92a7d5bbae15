"""What a browser may say to the server: which of its messages are let through.

viser believes every message. It lets a client overwrite any attribute of a slider, send NaN or a gigabyte, and show all of
that to everybody else. This file holds the rules that stop this, as plain functions of the decoded message. It knows nothing of
viser: what exists on the page is asked of `Elements`.

Two outcomes besides "let through":
- `Malformed`: no real browser would send this. The connection is closed, nobody else notices.
- `Refused`: well formed, yet not allowed (or out of range). The message is dropped, the connection lives on.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

import msgspec

Scope = Literal["own", "shared"]
UPLOAD_TOO_LARGE = "upload too large"
_SMALLEST_PART = 64 * 1024  # viser's client cuts files into pieces of 512 kB
_LARGEST = 1e9  # far beyond anything in the scene, near enough that squares and products stay finite


class Malformed(Exception):
    """The message can't have come from viser's own client; close the connection."""


class Refused(Exception):
    """The message is understood but not allowed; drop it. `kind` groups the log lines."""

    def __init__(self, kind: str) -> None:
        super().__init__(kind)
        self.kind = kind


@dataclass(frozen=True)
class Limits:
    """How much one browser may ask for.

    Attributes:
        text_bytes: longest text that may be typed into one field.
        upload_bytes: largest file, and the sum of all unfinished ones of a browser.
        uploads: files under way at the same time.
        messages_per_second: what is beyond is read later, so the sender is slowed down; a lively person sends about 100.
        frame_bytes: largest single websocket message.
        stall_seconds: a browser that reads nothing for this long is taken for gone.
    """

    text_bytes: int = 100_000
    upload_bytes: int = 20_000_000
    uploads: int = 4
    messages_per_second: float = 600.0
    frame_bytes: int = 16 * 1024 * 1024
    stall_seconds: float = 45.0


@dataclass(frozen=True)
class Control:
    """One GUI element as far as a browser may change it.

    Attributes:
        scope: "own" if only this browser has it, "shared" if everybody sees the same one.
        value: its present value; a new one must be of the same kind.
        enabled: False while it is greyed out.
        low, high: bounds, a number for all components or one for each; None for none.
        options: the allowed texts; None for any.
        takes_files: an upload button.
    """

    scope: Scope
    value: object
    enabled: bool = True
    low: float | Sequence[float] | None = None
    high: float | Sequence[float] | None = None
    options: Collection[str] | None = None
    takes_files: bool = False


class Elements(Protocol):
    """What exists on one browser's page."""

    def control(self, client_id: int, uuid: str) -> Control | None:
        """The input with this uuid, if this browser has it."""
        ...

    def form(self, client_id: int, uuid: str) -> Scope | None:
        """Where the form with this uuid belongs, if this browser has it."""
        ...

    def command(self, client_id: int, uuid: str) -> Scope | None:
        """Where the palette command with this uuid belongs, if this browser has it."""
        ...


@dataclass
class _Upload:
    size: int
    left: int
    parts: int
    seen: set[int] = field(default_factory=set)


@dataclass
class Traffic:
    """What one connection has sent so far: its uploads under way and its speed."""

    uploads: dict[str, _Upload] = field(default_factory=dict)
    allowance: float = 0.0
    counted_at: float = -math.inf

    def pause(self, per_second: float, now: float | None = None) -> float:
        """Count one message; returns for how many seconds the next one should be left unread."""
        now = time.monotonic() if now is None else now
        # Half a second's worth may come at once: a page that was held up sends in bursts.
        self.allowance = min(per_second / 2, self.allowance + (now - self.counted_at) * per_second) - 1.0
        self.counted_at = now
        return max(0.0, -self.allowance / per_second)


Check = Callable[[object], None]


def _number(low: float = -_LARGEST, high: float = _LARGEST) -> Check:
    def check(value: object) -> None:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise Malformed("not a number")
        if not (math.isfinite(value) and low <= value <= high):
            raise Refused("number out of range")

    return check


def _row(length: int | None, item: Check) -> Check:
    def check(value: object) -> None:
        if not isinstance(value, (list, tuple)) or len(value) > 64 or (length is not None and len(value) != length):
            raise Malformed("not a row of the right length")
        for entry in value:
            item(entry)

    return check


def _whole(value: object) -> None:
    _number(0)(value)
    assert isinstance(value, (int, float))
    if value != int(value):
        raise Malformed("not a whole number")


def _text(longest: int) -> Check:
    def check(value: object) -> None:
        if not isinstance(value, str):
            raise Malformed("not a text")
        if len(value) > longest or len(value.encode()) > longest:
            raise Refused("text too long")

    return check


def _rotation(value: object) -> None:
    _row(4, _number())(value)
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


_name, _point, _any_text = _text(256), _row(3, _number()), _text(16 * 1024 * 1024)
_pixel = _row(2, _number())
_owned = {"name": _name, "owner": _name}

# All that viser 1.1's own client ever sends, except its requests for a public tunnel.
SHAPES: Mapping[str, Mapping[str, Check]] = {
    "ViewerCameraMessage": {
        "wxyz": _rotation,
        "position": _point,
        "fov": _number(0.0, math.pi),
        "near": _number(0.0),
        "far": _number(0.0),
        "image_height": _number(0),
        "image_width": _number(0),
        "look_at": _point,
        "up_direction": _point,
    },
    "GuiUpdateMessage": {"uuid": _name, "updates": _updates},
    "GuiButtonHoldMessage": {"uuid": _name, "frequency": _number(0.0)},
    "GuiFormSubmitMessage": {"uuid": _name},
    "GuiFormDirtyMessage": {"uuid": _name},
    "CommandTriggerMessage": {"uuid": _name},
    "FileTransferStartUpload": {
        "source_component_uuid": _name,
        "transfer_uuid": _text(64),
        "filename": _text(1024),
        "mime_type": _name,
        "part_count": _whole,
        "size_bytes": _whole,
    },
    "FileTransferPart": {
        "source_component_uuid": _or_none(_name),
        "transfer_uuid": _text(64),
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
        "screen_pos": _row(None, _pixel),
        "modifier": _or_none(_name),
    },
    "GetRenderResponseMessage": {"payload": _blob, "render_uuid": _name},
    "LocalStorageGetItemResponseMessage": {"value": _or_none(_any_text), "error": _or_none(_any_text), "request_uuid": _name},
}


def _bound(bounds: object, index: int) -> float | None:
    bound = bounds[index] if isinstance(bounds, (list, tuple)) else bounds
    return float(bound) if isinstance(bound, (int, float)) else None


def check_value(control: Control, value: object, limits: Limits) -> None:
    """Decide whether `control` may take `value`; raises `Malformed` or `Refused`."""
    present = control.value
    if isinstance(present, bool):
        if not isinstance(value, bool):
            raise Malformed("not a yes or no")
    elif isinstance(present, str):
        _text(limits.text_bytes)(value)
        if control.options is not None and value not in control.options:
            raise Refused("not one of the options")
    elif isinstance(present, (int, float, tuple)):
        if isinstance(present, tuple):
            _row(len(present), _number())(value)
        else:
            _number()(value)
        entries: Any = value if isinstance(present, tuple) else (value,)
        for index, entry in enumerate(entries):
            low, high = _bound(control.low, index), _bound(control.high, index)
            # The browser computes min + k step in its own rounding.
            slack = 1e-6 * max(1e-3, abs(low or 0.0), abs(high or 0.0))
            if (low is not None and entry < low - slack) or (high is not None and entry > high + slack):
                raise Refused("number out of range")
    else:
        raise Refused("element without a value")


class Gate:
    """The filter that every message of every browser passes.

    Args:
        elements: what exists on the pages.
        limits: how much a browser may ask for.

    Attributes:
        may_share: whether a browser (by client id) may operate what everybody sees; a lecture hands this to one browser.
    """

    def __init__(self, elements: Elements, limits: Limits) -> None:
        self._elements = elements
        self._limits = limits
        self._open_uploads: set[str] = set()
        self.may_share: Callable[[int], bool] = lambda client_id: True

    def check(self, client_id: int, traffic: Traffic, raw: bytes | str) -> None:
        """Let one message through by returning.

        Raises:
            Malformed: the connection should be closed.
            Refused: the message should be dropped.
        """
        if isinstance(raw, str):
            raise Malformed("text instead of bytes")
        try:
            message = msgspec.msgpack.decode(raw)
        except (msgspec.MsgspecError, RecursionError, ValueError, TypeError) as error:
            raise Malformed("undecodable") from error
        kind = message.pop("type", None) if isinstance(message, dict) else None
        if not isinstance(kind, str):
            raise Malformed("no message")
        shape = SHAPES.get(kind)
        if shape is None:
            raise Refused("kind of message")
        # Older fields have no default; `owner` has one, and means everybody's scene.
        if set(message) != set(shape) and set(message) != set(shape) - {"owner"}:
            raise Malformed("wrong fields")
        for name, value in message.items():
            shape[name](value)
        self._check_meaning(kind, client_id, traffic, message)

    def forget(self, traffic: Traffic) -> None:
        """Release what a closed connection had under way."""
        self._open_uploads.difference_update(traffic.uploads)

    def _check_meaning(self, kind: str, client_id: int, traffic: Traffic, message: dict[str, Any]) -> None:
        if kind in ("GuiUpdateMessage", "GuiButtonHoldMessage"):
            control = self._control(client_id, message["uuid"])
            if kind == "GuiUpdateMessage":
                check_value(control, message["updates"]["value"], self._limits)
        elif kind in ("GuiFormSubmitMessage", "GuiFormDirtyMessage"):
            self._permit(client_id, self._elements.form(client_id, message["uuid"]))
        elif kind == "CommandTriggerMessage":
            self._permit(client_id, self._elements.command(client_id, message["uuid"]))
        elif kind == "FileTransferStartUpload":
            self._start_upload(client_id, traffic, message)
        elif kind == "FileTransferPart":
            self._take_part(traffic, message)
        elif "owner" in SHAPES[kind]:
            self._permit(client_id, "shared" if message.get("owner", "") == "" else "own")
        elif kind == "ScenePointerMessage":
            # Reaches both scenes and names no owner; its callbacks get the client and can tell for themselves.
            return

    def _permit(self, client_id: int, scope: Scope | None) -> None:
        if scope is None:
            raise Refused("unknown element")
        if scope == "shared" and not self.may_share(client_id):
            raise Refused("operated by somebody else")

    def _control(self, client_id: int, uuid: str) -> Control:
        control = self._elements.control(client_id, uuid)
        self._permit(client_id, None if control is None else control.scope)
        assert control is not None
        if not control.enabled:
            raise Refused("disabled element")
        return control

    def _start_upload(self, client_id: int, traffic: Traffic, message: dict[str, Any]) -> None:
        if not self._control(client_id, message["source_component_uuid"]).takes_files:
            raise Refused("unknown element")
        transfer, size, parts = message["transfer_uuid"], int(message["size_bytes"]), int(message["part_count"])
        if transfer in self._open_uploads:
            raise Refused("upload that exists")
        # Bounds the number of parts too: each costs memory besides its bytes.
        if (size > 0) != (parts > 0) or parts > size // _SMALLEST_PART + 1:
            raise Malformed("parts don't add up")
        # Unfinished files count in full: their parts are kept in memory until the last one is here.
        reserved = sum(upload.size for upload in traffic.uploads.values())
        if len(traffic.uploads) >= self._limits.uploads or size + reserved > self._limits.upload_bytes:
            raise Refused(UPLOAD_TOO_LARGE)
        if parts:
            traffic.uploads[transfer] = _Upload(size=size, left=size, parts=parts)
            self._open_uploads.add(transfer)

    def _take_part(self, traffic: Traffic, message: dict[str, Any]) -> None:
        transfer, index, size = message["transfer_uuid"], int(message["part_index"]), len(message["content"])
        upload = traffic.uploads.get(transfer)
        if upload is None:
            raise Refused("part of no upload")
        if index >= upload.parts or index in upload.seen or size > upload.left:
            raise Refused("part that does not fit")
        upload.seen.add(index)
        upload.left -= size
        if len(upload.seen) == upload.parts:
            del traffic.uploads[transfer]
            self._open_uploads.discard(transfer)
