"""Filter of a browser's messages: viser accepts every one, even NaN or a gigabyte."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

from app.web.schemas import (
    SHAPES,
    UPLOAD_TOO_LARGE,
    Control,
    Malformed,
    Refused,
    Scope,
    check_value,
    fields_of,
    kind_of,
)
from app.web.traffic_limits import Allowance, TrafficLimits
from app.web.viser_internals import GuiRegistry

_SMALLEST_PART: Final = 64 * 1024  # viser's client cuts files into pieces of 512 kB


@dataclass
class _Upload:
    size: int
    left: int
    parts: int
    seen: set[int] = field(default_factory=set)


class Traffic:
    """Unfinished uploads and send rate of one connection."""

    def __init__(self, limits: TrafficLimits) -> None:
        self.uploads: dict[str, _Upload] = {}
        self._bytes_per_message = limits.bytes_per_second / limits.messages_per_second
        # Half a second's worth may come at once: a page that was held up sends in bursts.
        self._messages = Allowance(limits.messages_per_second, limits.messages_per_second / 2)
        self._small_frames = Allowance(limits.small_frames_per_second, limits.small_frames_per_second)

    def pause(self, size: int) -> float:
        """Count a message of `size` bytes. Returns the pause before the next one [s]."""
        return self._messages.spend(max(1.0, size / self._bytes_per_message))

    def takes_small_frame(self) -> bool:
        """Count a frame that ends no message, such as a ping; False if too many."""
        return self._small_frames.spend(1.0) == 0.0


class Gate:
    """Filter of all messages. `may_share`: True if a client id may operate shared elements."""

    def __init__(self, elements: GuiRegistry, limits: TrafficLimits) -> None:
        self._elements = elements
        self._limits = limits
        self._open_uploads: set[str] = set()
        self.may_share: Callable[[int], bool] = lambda client_id: True

    def check(self, client_id: int, traffic: Traffic, raw: bytes | str) -> None:
        """Raises `Malformed` or `Refused`."""
        if isinstance(raw, str):
            raise Malformed("text instead of bytes")
        kind = kind_of(raw)
        if len(raw) > self._limits.message_bytes and kind != "FileTransferPart":
            raise Malformed("too large")
        message = fields_of(kind, raw)
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
        # A ScenePointerMessage reaches both scenes and names no owner; its callbacks get the client and decide themselves.

    def forget(self, traffic: Traffic) -> None:
        self._open_uploads.difference_update(traffic.uploads)

    def _permit(self, client_id: int, scope: Scope | None) -> None:
        if scope is None:
            raise Refused("unknown element")
        if scope == "shared" and not self.may_share(client_id):
            raise Refused("operated by another browser")

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
        transfer, size, parts = (
            message["transfer_uuid"],
            int(message["size_bytes"]),
            int(message["part_count"]),
        )
        if transfer in self._open_uploads:
            raise Refused("upload that exists")
        # Also bounds the number of parts: each costs memory besides its bytes.
        if (size > 0) != (parts > 0) or parts > size // _SMALLEST_PART + 1:
            raise Malformed("parts don't add up")
        # Unfinished files count in full: their parts are kept in memory until the last one arrives.
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
