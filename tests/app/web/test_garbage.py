"""A broken message ends only its own connection; messages that a page would never send are dropped."""

import contextlib
import logging
import math
import random
import re
import threading
import tracemalloc
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import msgspec
import numpy as np
import pytest
import viser
import websockets
from viser import _messages as viser_messages
from viser.infra._messages import wire_field_names
from websockets.frames import OP_BINARY, Frame

from app.runtime.throttled_log import ThrottledLog
from app.web.headless_client import CAMERA
from app.web.message_gate import Gate, Traffic
from app.web.schemas import SHAPES, Malformed, Refused
from app.web.server import DuetServer
from app.web.traffic_limits import TrafficLimits
from tests.app.viser_private import component_id, handlers, shared_messages
from tests.app.web.conftest import Join, Room, ended, roundtrip, socket_of, write
from tests.blocking_client import BlockingClient

NAN, INF = math.nan, math.inf


def valid_messages(room: Room) -> dict[str, dict[str, Any]]:
    point, pixel = [0.0, 0.0, 1.0], [0.5, 0.5]
    uuid, owned = component_id(room.slider), {"name": "/hand", "owner": ""}
    ray = {"ray_origin": point, "ray_direction": point, "modifier": None}
    drag = {
        "start_position": point,
        "start_screen_pos": pixel,
        "end_position": point,
        "end_screen_pos": pixel,
        "modifier": "alt",
    }
    file = {"source_component_uuid": component_id(room.upload), "transfer_uuid": "t"}
    messages = [
        CAMERA,
        {"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": 0.2}},
        {"type": "GuiButtonHoldMessage", "uuid": uuid, "frequency": 10},
        {"type": "GuiFormSubmitMessage", "uuid": component_id(room.form)},
        {"type": "GuiFormDirtyMessage", "uuid": component_id(room.form)},
        {"type": "CommandTriggerMessage", "uuid": "c"},
        {
            "type": "FileTransferStartUpload",
            **file,
            "filename": "a",
            "mime_type": "",
            "part_count": 1,
            "size_bytes": 3,
        },
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
        },
        {"type": "ScenePointerMessage", **ray, "event_type": "click", "screen_pos": [pixel]},
        {"type": "GetRenderResponseMessage", "payload": b"", "render_uuid": "r"},
        {"type": "LocalStorageGetItemResponseMessage", "value": None, "error": None, "request_uuid": "r"},
    ]
    return {message["type"]: message for message in messages}


def test_every_kind_of_message_is_known_and_matches_viser(room: Room) -> None:
    messages = valid_messages(room)
    room.server.gui.add_command("c")
    (uuid,) = room.server.gui._command_handle_from_uuid
    messages["CommandTriggerMessage"]["uuid"] = uuid
    assert set(messages) == set(SHAPES)
    traffic = Traffic(TrafficLimits())
    for message in messages.values():
        raw = msgspec.msgpack.encode(message)
        room.server.gate.check(0, traffic, raw)
        viser_messages.Message.deserialize(raw)
    # The fields equal viser's: a new version of viser cannot add an unchecked field.
    for kind, shape in SHAPES.items():
        assert set(wire_field_names(getattr(viser_messages, kind))) == set(shape), kind


def test_the_browser_sends_only_known_kinds() -> None:
    kinds = r"(\w+Message|\w+Upload|FileTransfer\w+|\w+Request)"
    call = re.compile(r"(?:sendMessage|[sS]end\w*|messageSender)\(\s*\{\s*type:\s*[\"']" + kinds)
    source = Path(viser.__file__).parent / "client" / "src"
    texts = (
        path.read_text(encoding="utf-8")
        for path in source.rglob("*.ts*")
        if path.name != "WebsocketMessages.ts"
    )
    sent = {kind for text in texts for kind in call.findall(text)}
    assert len(sent) >= 8
    assert sent - set(SHAPES) <= {"ShareUrlRequest", "ShareUrlDisconnect"}, sent - set(SHAPES)


def mutations(rng: random.Random, messages: list[dict[str, Any]]) -> bytes | str:
    message, pack = dict(rng.choice(messages)), msgspec.msgpack.encode
    odd: list[Any] = [None, True, -1, 2**63, NAN, INF, "x", "", [], [1], {}, {"a": 1}, b"\xff", [[1, 2], [3]]]
    odd += ["y" * 3000, [NAN] * 3, {"value": NAN}]
    whole, key = pack(message), rng.choice(list(message))
    flipped = bytearray(whole)
    for _ in range(rng.randrange(1, 4)):
        flipped[rng.randrange(len(flipped))] = rng.randrange(256)
    surplus = rng.choice(["surplus", "owner", "excluded_self_client", "type"])
    broken: list[bytes | str] = [
        rng.randbytes(rng.randrange(200)),
        "text",
        bytes(flipped),
        whole[: rng.randrange(len(whole))],
    ]
    broken += [pack(rng.choice(odd)), pack({name: value for name, value in message.items() if name != key})]
    broken += [pack({**message, name: rng.choice(odd)}) for name in (surplus, key)]
    return rng.choice([*broken, b"\x81" * rng.randrange(1, 3000) + b"\xc0"])


def test_fuzzed_messages_pass_or_are_refused_or_malformed(room: Room) -> None:
    rng, traffic, gate = random.Random(5), Traffic(TrafficLimits()), room.server.gate
    messages, outcomes = (
        list(valid_messages(room).values()),
        dict.fromkeys(("through", "refused", "malformed"), 0),
    )
    for _ in range(6000):
        raw = mutations(rng, messages)
        try:
            gate.check(0, traffic, raw)
        except Refused:
            outcomes["refused"] += 1
        except Malformed:
            outcomes["malformed"] += 1
        else:
            # viser must read accepted messages without an error.
            assert isinstance(raw, bytes)
            viser_messages.Message.deserialize(raw)
            outcomes["through"] += 1
    assert min(outcomes.values()) > 100, outcomes


def test_garbage_closes_only_its_own_connection(
    room: Room, join: Join, caplog: pytest.LogCaptureFixture
) -> None:
    witness, rng, messages = join(), random.Random(6), list(valid_messages(room).values())
    codes: set[int] = set()
    # A frozen clock: no line is logged a second time, even on a slow machine.
    room.server.log = ThrottledLog(logging.getLogger("duet.server"), clock=lambda: 0.0)
    with caplog.at_level(logging.WARNING, "duet.server"):
        for number in range(11):
            with BlockingClient(room.server.url) as attacker:
                for _ in range(3):
                    try:
                        attacker.send_raw(mutations(rng, messages))
                    except websockets.ConnectionClosed:
                        break
                with contextlib.suppress(websockets.ConnectionClosed):
                    attacker.send_raw(b"\xc1")
                codes.add(ended(attacker)[0])
            if number % 5 == 0:
                value = 0.1 + 0.001 * (number + 1)
                room.slider.value = value
                witness.wait_for(lambda v, value=value: v.mirror.labelled("d_m")["value"] == value)
    assert codes == {1008}
    roundtrip(witness, room)
    witness.wait_for(lambda _: room.server.count_clients() == 1)
    # One line per kind, and never a traceback.
    lines = [record.getMessage() for record in caplog.records if record.name == "duet.server"]
    assert 1 <= len(lines) <= 12 and not any(record.exc_info for record in caplog.records)


def bomb(before: dict[str, Any], key: str, filling: bytes, after: dict[str, Any]) -> bytes:
    """A legal message of 250 kB with a field of many one-byte elements."""
    fields = [msgspec.msgpack.encode(part)[1:] for part in (before, after)]
    head = bytes([0x80 + len(before) + 1 + len(after)])
    many = b"\xdd" + (249_000).to_bytes(4, "big") + filling * 249_000
    return head + fields[0] + msgspec.msgpack.encode(key) + many + fields[1]


@pytest.mark.parametrize("filling", [b"\x80", b"\x90", b"\xc0", b"\xa0", b"\x01"])
@pytest.mark.parametrize(
    ("before", "key", "after"),
    [
        ({"type": "GuiUpdateMessage", "uuid": "u"}, "updates", {}),
        ({"type": "GuiUpdateMessage"}, "surplus", {"uuid": "u", "updates": {"value": 1}}),
        ({}, "surplus", {"type": "GuiUpdateMessage"}),
        ({}, "position", {key: value for key, value in CAMERA.items() if key != "position"}),
        ({"type": "ScenePointerMessage", "event_type": "click"}, "screen_pos", {}),
        (
            {
                "type": "FileTransferPart",
                "transfer_uuid": "t",
                "part_index": 0,
                "source_component_uuid": None,
            },
            "content",
            {},
        ),
        ({"uuid": "u"}, "type", {}),
        ({}, "surplus", {"type": "NoSuchMessage"}),
    ],
)
def test_many_small_elements_are_refused_before_they_cost_memory(
    before: dict[str, Any], key: str, after: dict[str, Any], filling: bytes
) -> None:
    costs_little(
        Gate(cast(Any, None), TrafficLimits()), bomb(before, key, filling, after), Malformed, Refused
    )


def costs_little(gate: Gate, raw: bytes, *errors: type[Exception]) -> None:
    traffic = Traffic(TrafficLimits())
    # Machine code that an earlier test is loading would count here.
    for thread in threading.enumerate():
        if thread.name == "duet-compiled":
            thread.join()
    tracemalloc.start()
    try:
        with pytest.raises(errors):
            gate.check(0, traffic, raw)
        assert tracemalloc.get_traced_memory()[1] < 100_000
    finally:
        tracemalloc.stop()


def test_an_elements_value_is_decoded_only_as_its_kind(room: Room) -> None:
    empty = msgspec.Raw(b"\xdd" + (200_000).to_bytes(4, "big") + b"\x80" * 200_000)
    for handle in (room.slider, room.text, room.choice, room.pair):
        update = {"type": "GuiUpdateMessage", "uuid": component_id(handle), "updates": {"value": empty}}
        costs_little(room.server.gate, msgspec.msgpack.encode(update), Malformed)


def test_oversized_and_fragmented_messages_close_only_their_connection(room: Room, join: Join) -> None:
    witness, mask, binary = join(), b"\0\0\0\0", b"\x82\xff"
    update = {
        "type": "GuiUpdateMessage",
        "uuid": component_id(room.text),
        "updates": {"value": "x" * 256_000},
    }
    small = 1008, "too many small frames"
    for sent, code, reason in (
        (Frame(OP_BINARY, msgspec.msgpack.encode(update)).serialize(mask=True), 1008, "too large"),
        (binary + (1_000_001).to_bytes(8, "big") + mask, 1009, "exceeds limit"),
        # An unfinished message, followed by pings or by fragments (RFC 6455, section 5.2).
        *((b"\x02\x80" + mask + (head + mask) * 1000, *small) for head in (b"\x89\x80", b"\x00\x80")),
    ):
        attacker = join()
        write(attacker, sent)
        assert ended(attacker)[0] == code and reason in ended(attacker)[1]
    roundtrip(witness, room)


def test_a_message_may_arrive_in_pieces(room: Room, join: Join) -> None:
    visitor = join()
    raw = msgspec.msgpack.encode(
        {"type": "GuiUpdateMessage", "uuid": component_id(room.slider), "updates": {"value": 0.25}}
    )
    visitor.run(socket_of(visitor).send([raw[:1], raw[1:20], raw[20:]]))
    roundtrip(visitor, room)
    assert room.values("d_m") == [0.25]


def test_valid_messages_take_effect(room: Room, join: Join) -> None:
    a, b = join(), join()
    a.set_value("d_m", 0.2)
    a.set_value("law", "strict")
    a.set_value("pair", [0.5, -1])
    a.set_value("inner", 7)
    a.click("go")
    a.send({"type": "GuiFormDirtyMessage", "uuid": component_id(room.form)})
    a.move_gizmo("/hand", (0.1, 0, 0.5))
    roundtrip(a, room)
    assert room.seen[:5] == [
        ("d_m", 0.2),
        ("law", "strict"),
        ("pair", (0.5, -1.0)),
        ("inner", 7.0),
        ("go", 0),
    ]
    assert room.values("hand") == [(0.1, 0.0, 0.5)]
    b.wait_for(
        lambda v: (
            v.mirror.labelled("d_m")["value"] == 0.2
            and v.mirror.nodes["/hand"]["position"] == (0.1, 0.0, 0.5)
        )
    )
    b.wait_for(lambda v: v.received.messages["GuiFormDirtyMessage"] == 1)


def test_messages_that_a_page_never_sends_are_dropped(room: Room, join: Join) -> None:
    visitor = join()
    slider = {"type": "GuiUpdateMessage", "uuid": visitor.mirror.labelled("d_m")["uuid"]}
    for value in (NAN, INF, 1e9, 0.04):
        visitor.set_value("d_m", value)
    long: tuple[tuple[str, Any], ...] = (("note", "x" * 100_001), ("note", "é" * 50_001))
    for label, value in (
        *long,
        ("law", "rm -rf"),
        ("pair", [0.0, NAN]),
        ("pair", [0.0, 1.5]),
        ("locked", 0.7),
    ):
        visitor.set_value(label, value)
    for updates in (
        {"update_cb": []},
        {"sync_cb": None},
        {"value": 0.2, "update_cb": []},
        {"removed": True},
        {"props": {}},
        {},
    ):
        visitor.send({**slider, "updates": updates})
    for x in (NAN, INF, 1e300):
        visitor.move_gizmo("/hand", (x, 0.0, 0.0))
    for w in (NAN, 0.0):
        visitor.move_gizmo("/hand", (0.0, 0.0, 0.5), (w, 0.0, 0.0, 0.0))
    visitor.send({**CAMERA, "position": [NAN, 0, 0]})
    visitor.set_value("d_m", 0.15)
    visitor.move_gizmo("/hand", (0.0, 0.2, 0.5))
    visitor.send({**CAMERA, "position": [1, 2, 3]})
    roundtrip(visitor, room)
    assert room.seen[:-1] == [("d_m", 0.15), ("hand", (0.0, 0.2, 0.5))] and len(room.values("note")) == 1
    assert np.isfinite(room.gizmo.position).all() and np.isfinite(room.gizmo.wxyz).all()
    (client,) = room.server.get_clients().values()
    assert tuple(client.camera.position) == (1, 2, 3)


def test_messages_about_unknown_forms_are_not_kept(room: Room, join: Join) -> None:
    visitor, witness = join(), join()
    before = len(shared_messages(room.server))
    for number in range(100):
        visitor.send({"type": "GuiFormDirtyMessage", "uuid": f"no-{number}"})
    visitor.send({"type": "GuiFormDirtyMessage", "uuid": component_id(room.form)})
    roundtrip(visitor, room)
    witness.wait_for(lambda v: v.received.messages["GuiFormDirtyMessage"] > 0)
    assert len(shared_messages(room.server)) <= before + 2
    assert witness.received.messages["GuiFormDirtyMessage"] == 1


def test_a_tunnel_cannot_be_requested(room: Room, join: Join, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[object] = []
    for kind, name in (
        (viser.ViserServer, "request"),
        (viser.ViserServer, "disconnect"),
        (DuetServer, "request"),
    ):
        monkeypatch.setattr(kind, f"{name}_share_url", lambda *args, **options: asked.append(args))
    visitor = join()
    for message in (viser_messages.ShareUrlRequest, viser_messages.ShareUrlDisconnect):
        visitor.send({"type": message.__name__})
        # Even past the gate there is no handler.
        assert message not in handlers(room.server)
    visitor.click("go")
    roundtrip(visitor, room)
    assert room.values("go") == [0] and asked == []


def test_messages_to_an_empty_page_are_refused() -> None:
    nothing: Any = SimpleNamespace(control=lambda *_: None, form=lambda *_: None, command=lambda *_: None)
    with pytest.raises(Refused, match="unknown element"):
        Gate(nothing, TrafficLimits()).check(
            0,
            Traffic(TrafficLimits()),
            msgspec.msgpack.encode({"type": "CommandTriggerMessage", "uuid": "x"}),
        )
