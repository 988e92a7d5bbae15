"""Broken messages of every kind end the connection they came by, and nothing else."""

from __future__ import annotations

import contextlib
import logging
import math
import os
import random
import re
from collections.abc import Callable
from typing import Any

import msgspec
import pytest
import viser
import websockets
from viser import _messages as viser_messages

from app.server.gate import Traffic
from app.server.limits import Limits
from app.server.refusal import Malformed, Refused
from app.server.server import DuetServer
from app.server.shapes import SHAPES
from app.visitor.sync_visitor import SyncVisitor
from app.visitor.visitor import CAMERA
from tests.app.server.conftest import Room, furnish, roundtrip

NAN, INF = math.nan, math.inf


def valid_messages(room: Room) -> dict[str, dict[str, Any]]:
    """One message of every kind, as the browser sends them."""
    point, pixel = [0.0, 0.0, 1.0], [0.5, 0.5]
    uuid, owned = room.slider._impl.uuid, {"name": "/hand", "owner": ""}
    ray = {"ray_origin": point, "ray_direction": point, "modifier": None}
    drag = {"start_position": point, "start_screen_pos": pixel, "end_position": point, "end_screen_pos": pixel}
    file = {"source_component_uuid": room.upload._impl.uuid, "transfer_uuid": "t"}
    messages = [
        CAMERA,
        {"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": 0.2}},
        {"type": "GuiButtonHoldMessage", "uuid": uuid, "frequency": 10},
        {"type": "GuiFormSubmitMessage", "uuid": room.form._impl.uuid},
        {"type": "GuiFormDirtyMessage", "uuid": room.form._impl.uuid},
        {"type": "CommandTriggerMessage", "uuid": "c"},
        {"type": "FileTransferStartUpload", **file, "filename": "a", "mime_type": "", "part_count": 1, "size_bytes": 3},
        {"type": "FileTransferPart", **file, "part_index": 0, "content": b"abc"},
        {"type": "TransformControlsUpdateMessage", **owned, "wxyz": [1, 0, 0, 0], "position": point},
        {"type": "TransformControlsDragStartMessage", **owned},
        {"type": "TransformControlsDragEndMessage", **owned},
        {"type": "SceneNodeClickMessage", **owned, **ray, "instance_index": None, "screen_pos": pixel},
        {
            "type": "SceneNodeDragMessage",
            **owned,
            **drag,
            "phase": "start",
            "instance_index": 1,
            "button": "left",
            "modifier": "alt",
        },
        {"type": "ScenePointerMessage", **ray, "event_type": "click", "screen_pos": [pixel]},
        {"type": "GetRenderResponseMessage", "payload": b"", "render_uuid": "r"},
        {"type": "LocalStorageGetItemResponseMessage", "value": None, "error": None, "request_uuid": "r"},
    ]
    return {message["type"]: message for message in messages}


def test_every_kind_of_message_is_known_and_is_what_viser_expects(room: Room) -> None:
    messages = valid_messages(room)
    room.server.gui.add_command("c")
    (uuid,) = room.server.gui._command_handle_from_uuid
    messages["CommandTriggerMessage"]["uuid"] = uuid
    assert set(messages) == set(SHAPES)
    traffic = Traffic()
    for message in messages.values():
        raw = msgspec.msgpack.encode(message)
        room.server.gate.check(0, traffic, raw)
        viser_messages.Message.deserialize(raw)
    # viser's fields and ours are the same, so a new version of viser can't slip a field past us.
    from viser.infra._messages import wire_field_names

    for kind, shape in SHAPES.items():
        assert set(wire_field_names(getattr(viser_messages, kind))) == set(shape), kind


def test_the_browser_sends_no_kind_that_we_do_not_know() -> None:
    source = os.path.join(os.path.dirname(viser.__file__), "client", "src")
    sent: set[str] = set()
    for folder, _, names in os.walk(source):
        for name in names:
            if name.endswith((".ts", ".tsx")) and name != "WebsocketMessages.ts":
                with open(os.path.join(folder, name), encoding="utf-8") as file:
                    text = file.read()
                sent |= set(
                    re.findall(
                        r"""(?:sendMessage|[sS]end\w*|messageSender)\(\s*\{\s*type:\s*["'](\w+Message|\w+Upload|FileTransfer\w+|\w+Request)""",
                        text,
                    )
                )
    assert len(sent) >= 8
    assert sent - set(SHAPES) <= {"ShareUrlRequest", "ShareUrlDisconnect"}, sent - set(SHAPES)


def mutations(rng: random.Random, messages: list[dict[str, Any]]) -> bytes | str:
    """Something broken: raw bytes, cut or flipped messages, wrong types, missing and surplus fields."""
    message = dict(rng.choice(messages))
    odd: list[Any] = [
        None,
        True,
        -1,
        2**63,
        NAN,
        INF,
        "x",
        "",
        [],
        [1],
        {},
        {"a": 1},
        b"\xff",
        [[1, 2], [3]],
        "y" * 3000,
        [NAN] * 3,
        {"value": NAN},
    ]
    which = rng.randrange(9)
    if which == 0:
        return rng.randbytes(rng.randrange(200))
    if which == 1:
        return "text"
    if which == 2:
        raw = bytearray(msgspec.msgpack.encode(message))
        for _ in range(rng.randrange(1, 4)):
            raw[rng.randrange(len(raw))] = rng.randrange(256)
        return bytes(raw)
    if which == 3:
        raw = msgspec.msgpack.encode(message)
        return raw[: rng.randrange(len(raw))]
    if which == 4:
        return msgspec.msgpack.encode(rng.choice(odd))
    if which == 5:
        message[rng.choice(["surplus", "owner", "excluded_self_client", "type"])] = rng.choice(odd)
    elif which == 6:
        del message[rng.choice(list(message))]
    elif which == 7:
        return b"\x81" * rng.randrange(1, 3000) + b"\xc0"
    else:
        message[rng.choice(list(message))] = rng.choice(odd)
    return msgspec.msgpack.encode(message)


def test_fuzz_only_ever_ends_in_three_ways(room: Room) -> None:
    rng, traffic, gate = random.Random(5), Traffic(), room.server.gate
    messages, outcomes = list(valid_messages(room).values()), dict.fromkeys(("through", "refused", "malformed"), 0)
    for _ in range(6000):
        raw = mutations(rng, messages)
        try:
            gate.check(0, traffic, raw)
        except Refused:
            outcomes["refused"] += 1
        except Malformed:
            outcomes["malformed"] += 1
        else:
            # What passes, viser must be able to read without a complaint.
            assert isinstance(raw, bytes)
            viser_messages.Message.deserialize(raw)
            outcomes["through"] += 1
    assert min(outcomes.values()) > 100, outcomes


def test_garbage_closes_only_its_own_connection(
    room: Room, join: Callable[..., SyncVisitor], caplog: pytest.LogCaptureFixture
) -> None:
    witness, rng, messages = join(), random.Random(6), list(valid_messages(room).values())
    codes: dict[int, int] = {}
    with caplog.at_level(logging.WARNING, "duet.server"):
        for number in range(60):
            with SyncVisitor(room.server.url) as attacker:
                for _ in range(3):
                    try:
                        attacker.send_raw(mutations(rng, messages))
                    except websockets.ConnectionClosed:
                        break
                with contextlib.suppress(websockets.ConnectionClosed):
                    attacker.send_raw(b"\xc1")
                attacker.wait_for(lambda v: v.closed)
                assert attacker.closed is not None and attacker.closed.rcvd is not None
                codes[attacker.closed.rcvd.code] = codes.get(attacker.closed.rcvd.code, 0) + 1
            if number % 10 == 0:
                value = 0.1 + 0.001 * (number + 1)
                room.slider.value = value
                witness.wait_for(lambda v, value=value: v.mirror.labelled("d_m")["value"] == value)
    assert set(codes) == {1008}
    roundtrip(witness, room)
    assert room.server.count_clients() == 1
    # One line per kind, and never a traceback.
    lines = [record.getMessage() for record in caplog.records if record.name == "duet.server"]
    assert 1 <= len(lines) <= 12 and not any(record.exc_info for record in caplog.records)


def test_a_giant_frame_closes_only_its_own_connection(start: Callable[..., DuetServer]) -> None:
    room = furnish(start(limits=Limits(frame_bytes=100_000)))
    with SyncVisitor(room.server.url) as witness, SyncVisitor(room.server.url) as attacker:
        witness.wait_for(lambda v: v.mirror.replayed)
        attacker.send_raw(b"x" * 100_001)
        attacker.wait_for(lambda v: v.closed)
        assert attacker.closed is not None and attacker.closed.rcvd is not None and attacker.closed.rcvd.code == 1009
        roundtrip(witness, room)
