"""Messages that a page would not send are dropped; each refusal is paired with a message that gets through."""

import math
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest
import viser
from viser import _messages as viser_messages

from app.bench.headless_client import CAMERA
from app.web.message_gate import Gate, Traffic
from app.web.refusal import Refused
from app.web.server import DuetServer
from app.web.traffic_limits import TrafficLimits
from tests.app.web.conftest import Join, Room, roundtrip

NAN, INF = math.nan, math.inf


def test_real_use_gets_through(room: Room, join: Join) -> None:
    a, b = join(), join()
    a.set_value("d_m", 0.2)
    a.set_value("law", "strict")
    a.set_value("pair", [0.5, -1])
    a.set_value("inner", 7)
    a.click("go")
    a.send({"type": "GuiFormDirtyMessage", "uuid": room.form._impl.uuid})
    a.move_gizmo("/hand", (0.1, 0, 0.5))
    roundtrip(a, room)
    assert room.seen[:5] == [("d_m", 0.2), ("law", "strict"), ("pair", (0.5, -1.0)), ("inner", 7.0), ("go", 0)]
    assert room.values("hand") == [(0.1, 0.0, 0.5)]
    b.wait_for(lambda v: v.mirror.labelled("d_m")["value"] == 0.2 and v.mirror.nodes["/hand"]["position"] == (0.1, 0.0, 0.5))
    b.wait_for(lambda v: v.received.messages["GuiFormDirtyMessage"] == 1)


def test_what_a_page_would_not_send_is_dropped(room: Room, join: Join) -> None:
    visitor = join()
    slider = {"type": "GuiUpdateMessage", "uuid": visitor.mirror.labelled("d_m")["uuid"]}
    for value in (NAN, INF, 1e9, 0.04):
        visitor.set_value("d_m", value)
    long: tuple[tuple[str, Any], ...] = (("note", "x" * 100_001), ("note", "é" * 50_001))
    for label, value in (*long, ("law", "rm -rf"), ("pair", [0.0, NAN]), ("pair", [0.0, 1.5]), ("locked", 0.7)):
        visitor.set_value(label, value)
    for updates in ({"update_cb": []}, {"sync_cb": None}, {"value": 0.2, "update_cb": []}, {"removed": True}, {"props": {}}, {}):
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


def test_unknown_forms_do_not_pile_up(room: Room, join: Join) -> None:
    visitor, witness = join(), join()
    before = len(room.server._websock_server._broadcast_buffer.message_from_id)
    for number in range(100):
        visitor.send({"type": "GuiFormDirtyMessage", "uuid": f"no-{number}"})
    visitor.send({"type": "GuiFormDirtyMessage", "uuid": room.form._impl.uuid})
    roundtrip(visitor, room)
    witness.wait_for(lambda v: v.received.messages["GuiFormDirtyMessage"] > 0)
    assert len(room.server._websock_server._broadcast_buffer.message_from_id) <= before + 2
    assert witness.received.messages["GuiFormDirtyMessage"] == 1


def test_no_tunnel_can_be_asked_for(room: Room, join: Join, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[object] = []
    for kind, name in ((viser.ViserServer, "request"), (viser.ViserServer, "disconnect"), (DuetServer, "request")):
        monkeypatch.setattr(kind, f"{name}_share_url", lambda *args, **options: asked.append(args))
    visitor = join()
    for message in (viser_messages.ShareUrlRequest, viser_messages.ShareUrlDisconnect):
        visitor.send({"type": message.__name__})
        # Even past the gate there is no handler.
        assert message not in room.server._websock_server._incoming_handlers
    visitor.click("go")
    roundtrip(visitor, room)
    assert room.values("go") == [0] and asked == []


def test_messages_while_nothing_is_on_the_page() -> None:
    nothing: Any = SimpleNamespace(control=lambda *_: None, form=lambda *_: None, command=lambda *_: None)
    with pytest.raises(Refused, match="unknown element"):
        Gate(nothing, TrafficLimits()).check(
            0, Traffic(TrafficLimits()), msgspec.msgpack.encode({"type": "CommandTriggerMessage", "uuid": "x"})
        )
