"""The locked-down server, met by real clients: programs that speak the protocol, and a real browser.

Every refusal is paired with something that does get through, so that a server which refuses everything can't pass.
"""

from __future__ import annotations

import asyncio
import contextlib
import gc
import importlib.util
import itertools
import json
import logging
import math
import os
import random
import re
import socket
import sys
import threading
import urllib.error
import urllib.request
import weakref
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from types import ModuleType, SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest
import viser
import viser.infra._infra as viser_infra
import websockets
from viser import _messages as viser_messages
from viser import infra
from viser.infra._async_message_buffer import AsyncMessageBuffer

import app.server
from app.doorway import Doorway
from app.gate import SHAPES, Gate, Limits, Malformed, Refused, Traffic
from app.index import ROOM_IS_FULL, full_page, page_query, patched_index
from app.server import STAMP, DuetServer, Packed, PortInUse, _somebody_answers, request_query, start_server
from app.wsclient import SyncVisitor, Visitor, decode_frame
from controllers.errors import BadSetting, DuetError
from tests.browser import PageAt, drag_arrow, installed_browser, screenshot, wait_ready, world_position

NAN, INF = math.nan, math.inf


@dataclass
class Room:
    """A server with one of everything on it, and what its callbacks have seen."""

    server: DuetServer
    slider: Any
    text: Any
    choice: Any
    pair: Any
    locked: Any
    form: Any
    upload: Any
    gizmo: Any
    seen: list[tuple[str, Any]] = field(default_factory=list)

    def values(self, name: str) -> list[Any]:
        return [value for what, value in self.seen if what == name]


def furnish(server: DuetServer) -> Room:
    gui = server.gui
    with gui.add_form("form") as form:
        inner = gui.add_number("inner", 0.0)
    room = Room(
        server,
        slider=gui.add_slider("d_m", min=0.05, max=0.3, step=0.01, initial_value=0.1),
        text=gui.add_text("note", ""),
        choice=gui.add_dropdown("law", ("smooth", "strict"), initial_value="smooth"),
        pair=gui.add_vector2("pair", (0.0, 0.0), min=(-1.0, -1.0), max=(1.0, 1.0)),
        locked=gui.add_slider("locked", min=0.0, max=1.0, step=0.1, initial_value=0.5, disabled=True),
        form=form,
        upload=gui.add_upload_button("file"),
        gizmo=server.scene.add_transform_controls("/hand", scale=0.3, position=(0.0, 0.0, 0.5)),
    )
    button = gui.add_button("go")
    watched = {"d_m": room.slider, "note": room.text, "law": room.choice, "pair": room.pair, "inner": inner}
    watched["locked"] = room.locked
    for name, handle in watched.items():

        @handle.on_update
        async def _(event: Any, name: str = name) -> None:
            room.seen.append((name, event.target.value))

    @button.on_click
    async def _(event: Any) -> None:
        room.seen.append(("go", event.client_id))

    @room.upload.on_upload
    async def _(event: Any) -> None:
        room.seen.append(("file", len(event.target.value.content)))

    @room.gizmo.on_update
    async def _(event: Any) -> None:
        room.seen.append(("hand", tuple(event.target.position)))

    return room


@pytest.fixture
def start() -> Iterator[Callable[..., DuetServer]]:
    servers: list[DuetServer] = []

    def make(port: int = 0, **options: Any) -> DuetServer:
        servers.append(start_server(port=port, **options))
        return servers[-1]

    yield make
    for server in servers:
        server.stop()


@pytest.fixture
def room(start: Callable[..., DuetServer]) -> Room:
    return furnish(start())


@pytest.fixture
def join(room: Room) -> Iterator[Callable[..., SyncVisitor]]:
    visitors: list[SyncVisitor] = []

    def make(**options: Any) -> SyncVisitor:
        visitors.append(SyncVisitor(room.server.url, **options))
        visitors[-1].wait_for(lambda v: v.mirror.replayed)
        return visitors[-1]

    yield make
    for visitor in visitors:
        visitor.close()


def get(url: str, **headers: str) -> tuple[int, dict[str, str], bytes]:
    try:
        with urllib.request.urlopen(urllib.request.Request(url, headers=headers), timeout=5) as answer:
            return answer.status, {k.lower(): v for k, v in answer.headers.items()}, answer.read()
    except urllib.error.HTTPError as error:
        return error.code, {k.lower(): v for k, v in error.headers.items()}, error.read()


_pings = itertools.count(1)


def roundtrip(visitor: SyncVisitor, room: Room) -> None:
    """Returns when the server has dealt with all that `visitor` said before: a connection's messages are read in order."""
    mark = f"mark {next(_pings)}"
    visitor.set_value("note", mark)
    visitor.wait_for(lambda v: mark in room.values("note") or v.closed)
    assert mark in room.values("note")


# --- who may connect -----------------------------------------------------------------------------------------------------------

ORIGINS = [
    # bound to, Host, Origin, admitted; {} stands for the port
    ("127.0.0.1", "127.0.0.1:{}", "http://127.0.0.1:{}", True),
    ("127.0.0.1", "localhost:{}", "http://localhost:{}", True),
    ("127.0.0.1", "[::1]:{}", "http://[::1]:{}", True),
    ("127.0.0.1", "127.0.0.1:{}", "https://localhost:{}", True),
    ("127.0.0.1", "LOCALHOST:{}", "http://LocalHost:{}", True),
    ("127.0.0.1", "localhost:9000", "http://localhost:9000", True),  # ssh -L 9000:localhost:8080
    ("127.0.0.1", "127.0.0.1:{}", None, True),
    ("127.0.0.1", "127.0.0.1:{}", "https://lab.example.org", True),  # listed explicitly
    ("127.0.0.1", "127.0.0.1:{}", "https://evil.example", False),
    ("127.0.0.1", "127.0.0.1:{}", "http://localhost:3000", False),
    ("127.0.0.1", "127.0.0.1:{}", "http://localhost", False),
    ("127.0.0.1", "127.0.0.1:{}", "null", False),
    ("127.0.0.1", "127.0.0.1:{}", "", False),
    ("127.0.0.1", "127.0.0.1:{}", "file://", False),
    ("127.0.0.1", "127.0.0.1:{}", "http://127.0.0.1:{}.evil.example", False),
    ("127.0.0.1", "127.0.0.1:{}", "http://127.0.0.1:{}@evil.example", False),
    ("127.0.0.1", "127.0.0.1:{}", "http://evil.example#127.0.0.1:{}", False),
    ("127.0.0.1", "evil.example:{}", "http://evil.example:{}", False),  # DNS rebinding
    ("127.0.0.1", "evil.example:{}", "http://127.0.0.1:{}", False),
    ("0.0.0.0", "192.168.1.5:{}", "http://192.168.1.5:{}", True),
    ("0.0.0.0", "lab-pc-7:{}", "http://lab-pc-7:{}", True),
    ("0.0.0.0", "lab-pc.local:{}", "http://lab-pc.local:{}", True),
    ("0.0.0.0", "localhost:{}", "http://localhost:{}", True),
    ("0.0.0.0", "192.168.1.5:{}", "http://evil.example", False),
    ("0.0.0.0", "evil.example:{}", "http://evil.example:{}", False),  # DNS rebinding on the network
    ("192.168.1.5", "192.168.1.5:{}", "http://192.168.1.5:{}", True),
    ("192.168.1.5", "192.168.1.5:{}", "http://192.168.1.6:{}", False),
]


@pytest.mark.parametrize(("bound", "host", "origin", "admitted"), ORIGINS)
def test_origin_rules(bound: str, host: str, origin: str | None, admitted: bool) -> None:
    doorway = Doorway(bound, 8080, ("https://lab.example.org",))
    origins = [] if origin is None else [origin.replace("{}", "8080")]
    assert doorway.admits(origins, [host.replace("{}", "8080")], "127.0.0.1") is admitted


def test_a_program_without_origin_is_let_in_from_this_computer_only() -> None:
    doorway = Doorway("0.0.0.0", 8080)
    assert doorway.admits([], ["192.168.1.5:8080"], "127.0.0.1")
    assert not doorway.admits([], ["192.168.1.5:8080"], "192.168.1.77")
    assert not doorway.admits(["http://localhost:8080"] * 2, ["localhost:8080"], "127.0.0.1")
    assert not doorway.admits(["http://localhost:8080"], [], "127.0.0.1")


@pytest.mark.parametrize(
    ("origin", "admitted"), [(None, True), ("http://localhost:{}", True), ("https://evil.example", False), ("null", False)]
)
def test_origin_is_asked_at_the_door(room: Room, origin: str | None, admitted: bool) -> None:
    asked = None if origin is None else origin.replace("{}", str(room.server.get_port()))
    if admitted:
        with SyncVisitor(room.server.url, asked) as visitor:
            visitor.wait_for(lambda v: v.mirror.replayed)
            return
    with pytest.raises(websockets.InvalidStatus) as refusal:
        SyncVisitor(room.server.url, asked)
    assert refusal.value.response.status_code == 403
    assert b"--allow-origin" in refusal.value.response.body
    assert room.server.count_clients() == 0


# --- starting and stopping -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("other_host", ["127.0.0.1", "0.0.0.0"])
def test_a_busy_port_is_an_error_that_names_the_remedy(other_host: str) -> None:
    with socket.socket() as other:
        other.bind((other_host, 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(PortInUse, match=rf"port {port} .*--port {port % 65535 + 1}") as error:
            start_server(port=port)
        assert isinstance(error.value, DuetError) and "\n" not in str(error.value)
    start_server(port=port).stop()


@pytest.mark.parametrize(
    "options", [{"port": 70000}, {"port": -1}, {"host": "203.0.113.9"}, {"host": "no such host"}, {"max_clients": 0}]
)
def test_impossible_settings_are_explained(options: dict[str, Any]) -> None:
    with pytest.raises(BadSetting, match="valid: "):
        start_server(**{"port": 0, **options})


def test_stopping_releases_port_thread_and_page(start: Callable[..., DuetServer], capfd: pytest.CaptureFixture[str]) -> None:
    before = set(threading.enumerate())
    server = start()
    port, visitor = server.get_port(), SyncVisitor(server.url)
    visitor.wait_for(lambda v: v.mirror.replayed)
    server.stop()
    server.stop()
    visitor.wait_for(lambda v: v.closed)
    visitor.close()
    again = start(port)
    assert again.get_port() == port and again.run != server.run
    again.stop()
    assert set(threading.enumerate()) <= before
    assert capfd.readouterr().out == ""


def test_a_visitor_at_the_door_during_construction_is_served(
    start: Callable[..., DuetServer], monkeypatch: pytest.MonkeyPatch
) -> None:
    early: list[SyncVisitor] = []
    original = infra.WebsockServer.start

    def start_and_be_met(self: infra.WebsockServer) -> None:
        original(self)
        # viser listens already, but has yet to build its scene and its GUI.
        early.append(SyncVisitor(f"http://127.0.0.1:{self._port}"))

    monkeypatch.setattr(infra.WebsockServer, "start", start_and_be_met)
    server = start()
    early[0].wait_for(lambda v: v.mirror.replayed and server.get_clients())
    early[0].close()
    assert early[0].closed is not None and early[0].closed.rcvd is not None and early[0].closed.rcvd.code == 1000


# --- own pages -----------------------------------------------------------------------------------------------------------------


def test_health(room: Room, join: Callable[..., SyncVisitor]) -> None:
    join()
    status, headers, body = get(room.server.url + "/healthz")
    state = json.loads(body)
    assert (status, headers["content-type"]) == (200, "application/json")
    assert state["ok"] is True and state["clients"] == 1 and state["room"] is True and re.match(r"\d", state["version"])


def test_pages_carry_the_headers(room: Room) -> None:
    for path in ("/", "/?dm=0.1", "/healthz"):
        status, headers, _ = get(room.server.url + path)
        assert status == 200
        assert headers["x-content-type-options"] == "nosniff" and headers["x-frame-options"] == "SAMEORIGIN"
        assert headers["referrer-policy"] == "no-referrer" and headers["cache-control"] in ("no-cache", "no-store")
    assert get(room.server.url + "/nothing")[0] == 404
    assert get(room.server.url + "/../../../etc/passwd")[0] == 404
    assert get(room.server.url + "/index.html?dm=1")[0] == 200


def test_index_is_patched_once_and_safely(room: Room) -> None:
    plain = get(room.server.url + "/")[2].decode()
    assert plain.count("duet-connection") > 1 and "<title>Duet</title>" in plain
    hostile = patched_index("<head><title>Viser</title></head>", title="</title><script>1</script>", run="</script>")
    assert "<script>1" not in hostile and hostile.count("</script>") == 1
    with pytest.raises(ValueError, match="title"):
        patched_index("<html></html>", title="Duet", run="")


@pytest.mark.parametrize(
    ("path", "query"),
    [
        ("/?dm=0.1&n=10", {"dm": "0.1", "n": "10"}),
        ("/", {}),
        ("?a=1", {"a": "1"}),
        ("/?a=1&a=2", {"a": "1"}),
        ("/?empty=", {"empty": ""}),
        ("/?x=%3Cscript%3E&y=a+b", {"x": "<script>", "y": "a b"}),
        ("/?" + "k" * 41 + "=1&ok=2", {"ok": "2"}),
        ("/?long=" + "v" * 401 + "&ok=2", {"ok": "2"}),
        ("/?" + "&".join(f"k{i}=1" for i in range(65)), {}),
        ("//evil.example/?a=1", {"a": "1"}),
    ],
)
def test_page_query(path: str, query: dict[str, str]) -> None:
    assert page_query(path) == query


def test_query_arrives_with_the_client(room: Room, join: Callable[..., SyncVisitor]) -> None:
    arrived: dict[int, dict[str, str]] = {}

    @room.server.on_client_connect
    async def _(client: viser.ClientHandle) -> None:
        arrived[client.client_id] = request_query(client)

    join(query="dm=0.1&n=10").wait_for(lambda v: len(arrived) == 1)
    join().wait_for(lambda v: len(arrived) == 2)
    assert list(arrived.values()) == [{"dm": "0.1", "n": "10"}, {}]


# --- a room that is full -------------------------------------------------------------------------------------------------------


def test_the_ninth_gets_the_friendly_page_and_later_a_place(start: Callable[..., DuetServer]) -> None:
    server = start(max_clients=8)
    eight = [SyncVisitor(server.url) for _ in range(8)]
    try:
        eight[-1].wait_for(lambda v: server.count_clients() == 8)
        status, headers, body = get(server.url + "/?dm=0.1")
        assert status == 503 and headers["retry-after"] == "10" and "8 places" in body.decode()
        assert json.loads(get(server.url + "/healthz")[2])["room"] is False
        # Somebody whose page was loaded while there was room.
        late = SyncVisitor(server.url)
        late.wait_for(lambda v: v.closed)
        assert late.closed is not None and late.closed.rcvd is not None
        assert (late.closed.rcvd.code, late.closed.rcvd.reason) == (1013, ROOM_IS_FULL)
        late.close()
        eight.pop().close()
        eight[0].wait_for(lambda v: server.count_clients() == 7)
        assert get(server.url + "/")[0] == 200
        eight.append(SyncVisitor(server.url))
        eight[-1].wait_for(lambda v: v.mirror.replayed)
        assert eight[-1].closed is None
    finally:
        for visitor in eight:
            visitor.close()


def test_full_page_needs_nothing_from_elsewhere() -> None:
    page = full_page(8)
    assert "8 places" in page and "one place" in full_page(1)
    assert not re.search(r"(href|src)=.https?:|@import|url\(", page)


# --- messages that could hurt others -------------------------------------------------------------------------------------------


def test_real_use_gets_through(room: Room, join: Callable[..., SyncVisitor]) -> None:
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


@pytest.mark.parametrize(
    ("label", "value"),
    [
        ("d_m", NAN),
        ("d_m", INF),
        ("d_m", 1e9),
        ("d_m", 0.04),
        ("law", "rm -rf"),
        ("note", "x" * 100_001),
        ("note", "é" * 50_001),
        ("pair", [0.0, NAN]),
        ("pair", [0.0, 1.5]),
        ("locked", 0.7),
    ],
)
def test_values_that_a_page_would_not_send_are_dropped(
    room: Room, join: Callable[..., SyncVisitor], label: str, value: object
) -> None:
    visitor = join()
    visitor.set_value(label, value)
    roundtrip(visitor, room)
    assert {what for what, _ in room.seen} == {"note"} and len(room.values("note")) == 1


def test_only_the_value_of_an_element_can_be_set(room: Room, join: Callable[..., SyncVisitor]) -> None:
    visitor = join()
    uuid = visitor.mirror.labelled("d_m")["uuid"]
    for updates in ({"update_cb": []}, {"sync_cb": None}, {"value": 0.2, "update_cb": []}, {"removed": True}, {"props": {}}, {}):
        visitor.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": updates})
    visitor.set_value("d_m", 0.15)
    roundtrip(visitor, room)
    assert room.values("d_m") == [0.15]


@pytest.mark.parametrize(
    "change",
    [
        {"position": (NAN, 0.0, 0.0)},
        {"position": (INF, 0.0, 0.0)},
        {"position": (1e300, 0.0, 0.0)},
        {"wxyz": (NAN, 0.0, 0.0, 0.0)},
        {"wxyz": (0.0, 0.0, 0.0, 0.0)},
    ],
)
def test_a_gizmo_never_becomes_nan(room: Room, join: Callable[..., SyncVisitor], change: dict[str, Any]) -> None:
    visitor = join()
    visitor.move_gizmo("/hand", **{"position": (0.0, 0.0, 0.5), **change})
    visitor.move_gizmo("/hand", (0.0, 0.2, 0.5))
    roundtrip(visitor, room)
    assert room.values("hand") == [(0.0, 0.2, 0.5)]
    assert np.isfinite(room.gizmo.position).all() and np.isfinite(room.gizmo.wxyz).all()


def test_a_camera_never_becomes_nan(room: Room, join: Callable[..., SyncVisitor]) -> None:
    from app.wsclient import CAMERA

    visitor = join()
    visitor.send({**CAMERA, "position": [NAN, 0, 0]})
    visitor.send({**CAMERA, "position": [1, 2, 3]})
    roundtrip(visitor, room)
    (client,) = room.server.get_clients().values()
    assert tuple(client.camera.position) == (1, 2, 3)


def test_unknown_forms_do_not_pile_up(room: Room, join: Callable[..., SyncVisitor]) -> None:
    visitor, witness = join(), join()
    before = len(room.server._websock_server._broadcast_buffer.message_from_id)
    for number in range(100):
        visitor.send({"type": "GuiFormDirtyMessage", "uuid": f"no-{number}"})
    visitor.send({"type": "GuiFormDirtyMessage", "uuid": room.form._impl.uuid})
    roundtrip(visitor, room)
    witness.wait_for(lambda v: v.received.messages["GuiFormDirtyMessage"] > 0)
    assert len(room.server._websock_server._broadcast_buffer.message_from_id) <= before + 2
    assert witness.received.messages["GuiFormDirtyMessage"] == 1


def test_no_tunnel_can_be_asked_for(room: Room, join: Callable[..., SyncVisitor], monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[object] = []
    monkeypatch.setattr(viser.ViserServer, "request_share_url", lambda *args, **options: asked.append(args))
    monkeypatch.setattr(viser.ViserServer, "disconnect_share_url", lambda *args, **options: asked.append(args))
    monkeypatch.setattr(DuetServer, "request_share_url", lambda *args, **options: asked.append(args))
    visitor = join()
    for kind in ("ShareUrlRequest", "ShareUrlDisconnect"):
        visitor.send({"type": kind})
    # Even past the gate nobody listens.
    for kind in (viser_messages.ShareUrlRequest, viser_messages.ShareUrlDisconnect):
        assert kind not in room.server._websock_server._incoming_handlers
    visitor.click("go")
    roundtrip(visitor, room)
    assert room.values("go") == [0] and asked == []


def test_what_all_see_can_be_handed_to_one(room: Room, join: Callable[..., SyncVisitor]) -> None:
    teacher, pupil = join(), join()
    room.server.gate.may_share = lambda client_id: client_id == 0
    own: list[float] = []

    @room.server.on_client_connect
    async def _(client: viser.ClientHandle) -> None:
        handle = client.gui.add_slider(f"own {client.client_id}", min=0.0, max=1.0, step=0.1, initial_value=0.0)

        @handle.on_update
        async def _(event: Any) -> None:
            own.append(event.target.value)

    for visitor, label in ((teacher, "own 0"), (pupil, "own 1")):
        visitor.wait_for(lambda v, label=label: any(e.get("label") == label for e in v.mirror.gui.values()))
    pupil.set_value("d_m", 0.3)
    pupil.move_gizmo("/hand", (0.3, 0.0, 0.5))
    pupil.click("go")
    # Somebody else's private element, whose uuid was guessed.
    pupil.send({"type": "GuiUpdateMessage", "uuid": teacher.mirror.labelled("own 0")["uuid"], "updates": {"value": 0.9}})
    pupil.set_value("own 1", 0.5)
    pupil.wait_for(lambda v: own)
    teacher.set_value("d_m", 0.2)
    roundtrip(teacher, room)
    assert own == [0.5] and room.values("d_m") == [0.2] and room.values("hand") == [] and room.values("go") == []


def upload(visitor: SyncVisitor, size: int, pieces: dict[int, int], *, parts: int, transfer: str = "t") -> None:
    """Announce a file of `size` bytes in `parts` parts, then send the pieces, part number → number of bytes."""
    file = {"source_component_uuid": visitor.mirror.labelled("file")["uuid"], "transfer_uuid": transfer}
    announced = {"filename": "a.bvh", "mime_type": "", "part_count": parts, "size_bytes": size}
    visitor.send({"type": "FileTransferStartUpload", **file, **announced})
    for index, piece in pieces.items():
        visitor.send({"type": "FileTransferPart", **file, "part_index": index, "content": b"x" * piece})


def test_files_up_to_the_cap_arrive(start: Callable[..., DuetServer]) -> None:
    room = furnish(start(limits=Limits(upload_bytes=2_000_000)))
    with SyncVisitor(room.server.url) as visitor:
        visitor.wait_for(lambda v: v.mirror.replayed)
        upload(visitor, 1_000_000, {0: 524_288, 1: 475_712}, parts=2)
        visitor.wait_for(lambda v: room.values("file") == [1_000_000])
        upload(visitor, 0, {}, parts=0, transfer="empty")
        visitor.wait_for(lambda v: room.values("file") == [1_000_000, 0])
        upload(visitor, 2_000_001, {0: 524_288}, parts=4, transfer="too large")
        visitor.wait_for(lambda v: v.received.messages["NotificationShowMessage"] == 1)
        roundtrip(visitor, room)
        assert room.server.gui._current_file_upload_states == {}


def test_unfinished_files_count_and_belong_to_their_sender(start: Callable[..., DuetServer]) -> None:
    room = furnish(start(limits=Limits(upload_bytes=2_000_000)))
    buffers = room.server.gui._current_file_upload_states
    with SyncVisitor(room.server.url) as visitor, SyncVisitor(room.server.url) as other:
        for one in (visitor, other):
            one.wait_for(lambda v: v.mirror.replayed)
        upload(visitor, 1_500_000, {0: 500_000}, parts=3, transfer="open")
        upload(visitor, 600_000, {0: 500_000}, parts=2, transfer="above the cap together")
        upload(visitor, 100, {0: 200}, parts=1, transfer="more than said")
        roundtrip(visitor, room)
        assert set(buffers) == {"open", "more than said"} and buffers["more than said"]["parts"] == {}
        # The same part again must not count as another one, or the books and the memory come apart.
        file = {"source_component_uuid": room.upload._impl.uuid, "transfer_uuid": "open"}
        for index in (0, 0, 7):
            visitor.send({"type": "FileTransferPart", **file, "part_index": index, "content": b"x" * 300_000})
        roundtrip(visitor, room)
        assert "open" in room.server.gate._open_uploads and set(buffers["open"]["parts"]) == {0}
        other.send({"type": "FileTransferPart", **file, "part_index": 1, "content": b"spoilt"})
        upload(other, 100, {0: 100}, parts=1, transfer="open")
        roundtrip(other, room)
        assert buffers["open"]["total_bytes"] == 1_500_000 and set(buffers["open"]["parts"]) == {0}
        assert room.values("file") == []
        for number in range(6):
            upload(other, 100_000, {}, parts=1, transfer=f"many {number}")
        roundtrip(other, room)
        assert sum(name.startswith("many") for name in buffers) == 4
        for index in (1, 2):
            visitor.send({"type": "FileTransferPart", **file, "part_index": index, "content": b"x" * 500_000})
        visitor.wait_for(lambda v: room.values("file") == [1_500_000])
    with SyncVisitor(room.server.url) as late:
        late.wait_for(lambda v: room.server.count_clients() == 1 and not buffers and not room.server.gate._open_uploads)


def test_a_flood_is_slowed_down() -> None:
    traffic = Traffic()
    pauses = [traffic.pause(100.0, now=10.0) for _ in range(60)]
    assert pauses[:50] == [0.0] * 50 and all(0 < pause <= 0.1 for pause in pauses[50:])
    assert traffic.pause(100.0, now=20.0) == 0.0


def valid_messages(room: Room) -> dict[str, dict[str, Any]]:
    """One message of every kind, as the browser sends them."""
    from app.wsclient import CAMERA

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


def test_send_buffer_is_capped_and_a_stalled_reader_is_let_go(start: Callable[..., DuetServer]) -> None:
    server = start(limits=Limits(stall_seconds=0.5))
    picture = server.gui.add_html("")
    with SyncVisitor(server.url) as witness:
        witness.wait_for(lambda v: v.mirror.replayed)
        (live,) = server._websock_server._live_connections.values()
        size = live.transport.get_extra_info("socket").getsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF)
        assert size <= 2 * 64 * 1024  # Linux doubles what is asked for
        with SyncVisitor(server.url, decode=False, read_pause=1000.0) as sleeper:
            witness.wait_for(lambda v: server.count_clients() == 2)
            noise = random.Random(1)
            texts = (noise.randbytes(200_000).hex() for _ in itertools.count())

            def gone(v: Visitor) -> bool:
                picture.content = next(texts)
                return server.count_clients() == 1

            witness.wait_for(gone, timeout=20)
            assert sleeper.visitor._socket is not None
        assert witness.closed is None


# --- what is sent --------------------------------------------------------------------------------------------------------------


@pytest.fixture
def visers_own(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """viser's networking as it is without us, clock and all."""
    origin = viser_infra.__file__
    assert origin is not None
    spec = importlib.util.spec_from_file_location("viser.infra._infra_untouched", origin)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)
    spec.loader.exec_module(module)
    return module


@dataclass
class Line:
    """The end of a connection, as far as whoever sends needs one."""

    sent: list[bytes] = field(default_factory=list)

    async def send(self, data: bytes) -> None:
        self.sent.append(data)


def produced(produce: Callable[..., Any], batches: list[list[viser_messages.Message]], client_id: int = 1) -> list[bytes]:
    """What somebody is sent of these batches, one after another, by `produce`."""

    async def run() -> list[bytes]:
        line, buffer = Line(), AsyncMessageBuffer(asyncio.get_running_loop(), persistent_messages=True, window_duration_sec=0.0)
        work = asyncio.create_task(produce(line, buffer, client_id))
        for number, batch in enumerate(batches, 1):
            with contextlib.ExitStack() as stack:
                buffer.atomic_start()
                stack.callback(buffer.atomic_end)
                for message in batch:
                    buffer.push(message)
            while len(line.sent) < number:
                await asyncio.sleep(0)
        buffer.set_done()
        await work
        return line.sent

    # A thread of its own: where a browser is driven, this one has an event loop that is at work.
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, run()).result()


def some_batches() -> list[list[viser_messages.Message]]:
    turned, moved = viser_messages.SetOrientationMessage, viser_messages.SetPositionMessage
    curve = {"data": (np.linspace(0.0, 1.0, 7), np.arange(3, dtype=np.float32))}
    return [
        [turned("/a", (1.0, 0.0, 0.0, 0.0)), moved("/a", (0.1, 0.2, 0.3))],
        [
            viser_messages.GuiUpdateMessage("u", curve),
            moved("/a", (0.2, 0.2, 0.3)),
            viser_messages.GuiUpdateMessage("v", {"x": "é"}),
        ],
    ]


def test_what_is_sent_is_what_viser_would_send(visers_own: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(visers_own, "time", SimpleNamespace(perf_counter=lambda: STAMP))
    batches = some_batches()
    ours = produced(viser_infra._message_producer, batches)
    assert ours == produced(visers_own._message_producer, batches)
    messages, _ = decode_frame(ours[1])
    assert [message["type"] for message in messages] == ["GuiUpdateMessage", "SetPositionMessage", "GuiUpdateMessage"]
    np.testing.assert_array_equal(messages[0]["updates"]["data"][1], [0.0, 1.0, 2.0])


def test_the_stamp_by_which_a_page_would_hold_batches_back_stands_still(
    room: Room, join: Callable[..., SyncVisitor], visers_own: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, second = (decode_frame(frame)[1] for frame in produced(visers_own._message_producer, some_batches()))
    assert second > first > 0.0, "viser's own clock goes on; else there is nothing to hold still"

    stamps: list[float] = []

    def note(frame: bytes) -> tuple[list[dict[str, Any]], float]:
        messages, stamp = decode_frame(frame)
        stamps.append(stamp)
        return messages, stamp

    monkeypatch.setattr("app.wsclient.decode_frame", note)
    visitor = join()
    for value in (0.11, 0.12, 0.13):
        room.slider.value = value
        visitor.wait_for(lambda v, value=value: v.mirror.labelled("d_m")["value"] == value)
    assert len(stamps) >= 4 and len(set(stamps)) == 1


def test_what_everybody_is_sent_is_packed_once(
    room: Room, join: Callable[..., SyncVisitor], monkeypatch: pytest.MonkeyPatch
) -> None:
    visitors = [join() for _ in range(5)]
    packed: list[list[str]] = []
    pack = app.server.pack

    def note(messages: Any) -> bytes:
        packed.append([f"{type(m).__name__} {getattr(m, 'updates', '')}" for m in messages])
        return pack(messages)

    monkeypatch.setattr(app.server, "pack", note)
    for value in (0.11, 0.12, 0.13):
        room.slider.value = value
        room.server.flush()
        for visitor in visitors:
            visitor.wait_for(lambda v, value=value: v.mirror.labelled("d_m")["value"] == value)
    assert packed == [[f"GuiUpdateMessage {{'value': {value}}}"] for value in (0.11, 0.12, 0.13)]

    # One's own doing is sent to all others; what it has changed by then is not said to the newcomer in its old form.
    packed.clear()
    visitors[0].set_value("d_m", 0.2)
    for visitor in visitors[1:]:
        visitor.wait_for(lambda v: v.mirror.labelled("d_m")["value"] == 0.2)
    assert len(packed) == 1
    late = join()
    assert late.mirror.labelled("d_m")["value"] == 0.2
    room.server.gui.add_checkbox("more", False).value = True
    for visitor in (*visitors, late):
        visitor.wait_for(lambda v: any(e.get("label") == "more" and e["value"] for e in v.mirror.gui.values()))


def test_an_element_is_never_sent_as_it_once_was() -> None:
    packed, moved = Packed(), [viser_messages.SetPositionMessage("/a", (0.0, 0.0, 0.0))]
    assert packed.get(moved) is packed.get(list(moved))
    props = viser_messages.GuiHtmlProps(order=0.0, content="as it was made", visible=True)
    made = [viser_messages.GuiHtmlMessage("u", "root", props)]
    before = packed.get(made)
    props.content = "as it is now"
    assert packed.get(made) != before


@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="counts through /proc, which only Linux has")
def test_fifty_visits_leave_nothing_behind(room: Room, join: Callable[..., SyncVisitor]) -> None:
    handles: weakref.WeakSet[viser.ClientHandle] = weakref.WeakSet()

    @room.server.on_client_connect
    async def _(client: viser.ClientHandle) -> None:
        client.gui.add_slider("mine", min=0.0, max=1.0, step=0.1, initial_value=0.0)
        client.scene.add_frame("/mine")
        handles.add(client)

    def visit() -> None:
        with SyncVisitor(room.server.url) as visitor:
            visitor.wait_for(lambda v: "/mine" in v.mirror.nodes)

    def count() -> tuple[int, int, int]:
        gc.collect()
        return len(os.listdir("/proc/self/fd")), threading.active_count(), len(room.server._websock_server._live_connections)

    witness = join()
    visit()
    witness.wait_for(lambda v: room.server.count_clients() == 1)
    before = count()
    for _visit in range(50):
        visit()
    witness.wait_for(lambda v: room.server.count_clients() == 1)
    roundtrip(witness, room)
    assert count() == before
    assert len(handles) <= 2  # the witness, and one that a local variable of the loop may still hold
    assert len(room.server.get_clients()) == 1
    assert len(room.server.scene._active_transform_drag_handles) == 0


def test_messages_while_nothing_is_on_the_page() -> None:
    nothing: Any = SimpleNamespace(control=lambda *_: None, form=lambda *_: None, command=lambda *_: None)
    with pytest.raises(Refused, match="unknown element"):
        Gate(nothing, Limits()).check(0, Traffic(), msgspec.msgpack.encode({"type": "CommandTriggerMessage", "uuid": "x"}))


# --- in a real browser ---------------------------------------------------------------------------------------------------------


def test_two_tabs_bring_their_own_query(start: Callable[..., DuetServer], page_at: PageAt) -> None:
    server = start()
    arrived: list[dict[str, str]] = []

    @server.on_client_connect
    async def _(client: viser.ClientHandle) -> None:
        query = request_query(client)
        arrived.append(query)
        client.gui.add_markdown(f"ready {query.get('dm')}")

    one = page_at(700, 500)
    two = one.context.new_page()
    for page, dm in ((one, "0.1"), (two, "0.2")):
        # Not waiting for the load: both are under way at once.
        page.goto(f"{server.url}/?dm={dm}&n=10", wait_until="commit")
    for page, dm in ((one, "0.1"), (two, "0.2")):
        page.get_by_text(f"ready {dm}").wait_for()
        assert page.evaluate("location.search") == f"?dm={dm}&n=10"
    assert all(query.pop("window") == "700x500" for query in arrived)
    assert sorted(arrived, key=lambda q: q["dm"]) == [{"dm": "0.1", "n": "10"}, {"dm": "0.2", "n": "10"}]
    assert one.title() == "Duet"


def test_a_lost_connection_is_said_and_taken_back(start: Callable[..., DuetServer], page_at: PageAt) -> None:
    server = start()
    server.gui.add_markdown("first start")
    page = page_at(900, 600)
    page.goto(server.url)
    page.get_by_text("first start").wait_for()
    pill = page.locator("#duet-connection")
    assert not pill.is_visible() and pill.get_attribute("role") == "status"
    port = server.get_port()
    server.stop()
    pill.get_by_text("Connection lost").wait_for()
    screenshot(page, "connection-lost-light")
    page.evaluate("document.documentElement.setAttribute('data-mantine-color-scheme', 'dark')")
    screenshot(page, "connection-lost-dark")
    again = start(port)
    again.gui.add_markdown("second start")
    page.get_by_text("second start").wait_for()
    pill.wait_for(state="hidden")
    # Another server than before: the page came anew from it.
    page.wait_for_function("fetch('/healthz').then(a => a.json()).then(s => document.documentElement.outerHTML.includes(s.run))")


def test_the_full_page_lets_in_by_itself(start: Callable[..., DuetServer], page_at: PageAt) -> None:
    server = start(max_clients=1)
    server.gui.add_markdown("welcome")
    first = SyncVisitor(server.url)
    page = page_at(900, 600, expect=(r"status of 503",))
    page.goto(f"{server.url}/?dm=0.1")
    page.get_by_text("Every place is taken").wait_for()
    screenshot(page, "room-full-light")
    page.emulate_media(color_scheme="dark")
    screenshot(page, "room-full-dark")
    first.close()
    page.get_by_text("welcome").wait_for()
    assert page.evaluate("location.search") == "?dm=0.1"


def test_a_tab_that_finds_its_place_taken_gets_the_full_page(start: Callable[..., DuetServer], page_at: PageAt) -> None:
    server = start(max_clients=1)
    server.gui.add_markdown("welcome")
    page = page_at(900, 600, expect=(r"status of 503",))
    attempts: list[str] = []
    page.on("console", lambda message: attempts.append(message.text) if message.text.startswith("Connecting") else None)
    page.goto(f"{server.url}/?dm=0.1")
    page.get_by_text("welcome").wait_for()
    # Its page is there, but when it connects the room is full.
    server.max_clients = 0
    server._websock_server.disconnect_all_clients()
    page.get_by_text("Every place is taken").wait_for()
    assert server.count_clients() == 0 and len(attempts) <= 3
    server.max_clients = 1
    page.get_by_text("welcome").wait_for()
    assert page.evaluate("location.search") == "?dm=0.1"


def test_a_gizmo_follows_a_real_mouse(start: Callable[..., DuetServer], page_at: PageAt) -> None:
    server = start()
    server.scene.configure_default_lights(False)
    server.initial_camera.position, server.initial_camera.look_at = (2.0, 1.0, 1.2), (0.0, 0.0, 0.4)
    gizmo = server.scene.add_transform_controls(
        "/hand", scale=0.4, position=(0.0, 0.0, 0.4), depth_test=False, disable_rotations=True
    )
    phases: list[str] = []

    @gizmo.on_update
    async def _(event: viser.TransformControlsEvent) -> None:
        phases.append(event.phase)

    page = page_at(800, 500)
    page.goto(server.url)
    wait_ready(page, "/hand")
    drag_arrow(page, (0.0, 0.0, 0.4), axis=2, scale=0.4, distance=0.2, steps=12)
    with SyncVisitor(server.url) as other:
        other.wait_for(lambda v: phases and phases[-1] == "end")
        other.wait_for(lambda v: abs(v.mirror.nodes.get("/hand", {"position": (0, 9, 0)})["position"][2] - 0.6) < 0.03)
    assert phases[0] == "start" and phases.count("update") >= 2
    assert np.allclose(gizmo.position, (0.0, 0.0, 0.6), atol=0.03)
    # A node that the server moves is drawn where it says.
    server.scene.add_frame("/follower", position=tuple(gizmo.position))
    wait_ready(page, "/follower")
    assert np.allclose(world_position(page, "/follower"), gizmo.position, atol=1e-6)


def test_a_named_browser_that_is_missing_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DUET_BROWSER", "/no/such/browser")
    with pytest.raises(FileNotFoundError, match="unset it"):
        installed_browser()
    monkeypatch.delenv("DUET_BROWSER")
    assert installed_browser() is None or os.path.isfile(str(installed_browser()))


def test_who_answers_on_a_port_is_found_by_asking() -> None:
    # What macOS needs; the rule itself is the same everywhere.
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        assert _somebody_answers("127.0.0.1", port)
    assert not _somebody_answers("127.0.0.1", port)
