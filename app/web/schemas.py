"""Fields of viser's messages, and values of controls. Typed decoding bounds the cost."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Final, Literal

import msgspec

from app.web.traffic_limits import TrafficLimits

UPLOAD_TOO_LARGE: Final = "upload too large"


class Malformed(Exception):
    """Not from viser's own client; close the connection."""


class Refused(Exception):
    """Well formed, but not allowed; drop the message. `kind` groups the log lines."""

    def __init__(self, kind: str) -> None:
        super().__init__(kind)
        self.kind = kind


_LARGEST: Final = 1e9  # far beyond anything in the scene, near enough that squares and products stay finite
_UNDECODABLE: Final = (msgspec.MsgspecError, RecursionError, ValueError, TypeError)


@dataclass(frozen=True)
class Field:
    """`check`: raises `Refused` for a bad value."""

    type: Any
    check: Callable[[Any], None] = lambda value: None

    def read(self, raw: msgspec.Raw) -> Any:
        """Raises `Malformed` or `Refused`."""
        try:
            value = msgspec.msgpack.decode(raw, type=self.type)
        except _UNDECODABLE as error:
            raise Malformed("wrong type") from error
        self.check(value)
        return value


def number(low: float = -_LARGEST, high: float = _LARGEST) -> Field:
    def check(value: float) -> None:
        if not (math.isfinite(value) and low <= value <= high):
            raise Refused("number out of range")

    return Field(int | float, check)


def row(length: int | None, item: Field) -> Field:
    """Row of `length` items (None: up to 64), each checked."""

    def check(value: list[Any]) -> None:
        for entry in value:
            item.check(entry)

    bounds = msgspec.Meta(min_length=length, max_length=64 if length is None else length)
    return Field(Annotated[list[item.type], bounds], check)


def text(longest: int) -> Field:
    """`longest`: [bytes]."""

    def check(value: str) -> None:
        if len(value) > longest or len(value.encode()) > longest:
            raise Refused("text too long")

    return Field(str, check)


_four: Final = row(4, number())


def _check_turn(value: list[float]) -> None:
    _four.check(value)
    # Callers divide by the norm.
    if not 0.25 < sum(x * x for x in value) < 4.0:
        raise Refused("number out of range")


def _check_updates(value: dict[str, msgspec.Raw]) -> None:
    # The value is checked once its element is known.
    if set(value) != {"value"}:
        raise Refused("attribute other than the value")


def _or_none(item: Field) -> Field:
    return Field(item.type | None, lambda value: None if value is None else item.check(value))


_name, _any_text, _blob = text(256), Field(str), Field(bytes)
_point, _pixel = row(3, number()), row(2, number())
_whole, _turn = Field(int, number(0).check), Field(_four.type, _check_turn)
_updates = Field(Annotated[dict[str, msgspec.Raw], msgspec.Meta(max_length=16)], _check_updates)
_owned = {"name": _name, "owner": _name}

# All that viser 1.1's own client ever sends, except requests for a public tunnel.
SHAPES: Mapping[str, Mapping[str, Field]] = {
    "ViewerCameraMessage": {
        "wxyz": _turn,
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
    "TransformControlsUpdateMessage": {**_owned, "wxyz": _turn, "position": _point},
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
    "LocalStorageGetItemResponseMessage": {
        "value": _or_none(_any_text),
        "error": _or_none(_any_text),
        "request_uuid": _name,
    },
}


class _Head(msgspec.Struct):
    type: str


def _decoder(kind: str, fields: Mapping[str, Field]) -> msgspec.msgpack.Decoder[Any]:
    # Older fields have no default; `owner` has one, which means the shared scene.
    described = [
        (name, field.type, "") if name == "owner" else (name, field.type) for name, field in fields.items()
    ]
    struct = msgspec.defstruct(
        kind, described, tag_field="type", tag=kind, forbid_unknown_fields=True, kw_only=True
    )
    return msgspec.msgpack.Decoder(struct)


_HEAD: Final = msgspec.msgpack.Decoder(_Head)
_DECODERS: Final = {kind: _decoder(kind, fields) for kind, fields in SHAPES.items()}


def kind_of(raw: bytes) -> str:
    """Raises `Malformed` without a kind, `Refused` if viser's client sends no such kind."""
    try:
        kind = _HEAD.decode(raw).type
    except _UNDECODABLE as error:
        raise Malformed("no message") from error
    if kind not in SHAPES:
        raise Refused("kind of message")
    return kind


def fields_of(kind: str, raw: bytes) -> dict[str, Any]:
    """Checked fields; raises `Malformed` or `Refused`."""
    try:
        message = msgspec.structs.asdict(_DECODERS[kind].decode(raw))
    except _UNDECODABLE as error:
        raise Malformed("wrong fields") from error
    for name, field in SHAPES[kind].items():
        field.check(message[name])
    return message


Scope = Literal["own", "shared"]


@dataclass(frozen=True)
class Control:
    """What a browser may change of a GUI element.

    Attributes:
        scope: "own" for this browser's element, "shared" for that of all.
        value: present one; a new one must be of the same kind.
        low, high: bounds, for all components or each.
        options: None for any.
    """

    scope: Scope
    value: object
    enabled: bool = True
    low: float | Sequence[float] | None = None
    high: float | Sequence[float] | None = None
    options: Collection[str] | None = None
    takes_files: bool = False


def _bound(bounds: object, index: int) -> float | None:
    bound = bounds[index] if isinstance(bounds, (list, tuple)) else bounds
    return float(bound) if isinstance(bound, (int, float)) else None


def check_value(control: Control, sent: msgspec.Raw, limits: TrafficLimits) -> None:
    """Raises `Malformed` or `Refused`."""
    present = control.value
    if isinstance(present, bool):
        Field(bool).read(sent)
    elif isinstance(present, str):
        value = text(limits.text_bytes).read(sent)
        if control.options is not None and value not in control.options:
            raise Refused("not one of the options")
    elif isinstance(present, (int, float, tuple)):
        entries: Any = (
            row(len(present), number()).read(sent) if isinstance(present, tuple) else (number().read(sent),)
        )
        for index, entry in enumerate(entries):
            low, high = _bound(control.low, index), _bound(control.high, index)
            # The browser computes min + k step with its own rounding.
            slack = 1e-6 * max(1e-3, abs(low or 0.0), abs(high or 0.0))
            if (low is not None and entry < low - slack) or (high is not None and entry > high + slack):
                raise Refused("number out of range")
    else:
        raise Refused("element without a value")
