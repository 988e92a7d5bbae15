"""A server with one of everything on it, and the visitors, programs that speak viser's protocol, whom it meets."""

from __future__ import annotations

import itertools
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import pytest

from app.bench.blocking_client import BlockingClient
from app.web.server import DuetServer


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
        servers.append(DuetServer(port=port, **options))
        return servers[-1]

    yield make
    for server in servers:
        server.stop()


@pytest.fixture
def room(start: Callable[..., DuetServer]) -> Room:
    return furnish(start())


@pytest.fixture
def join(room: Room) -> Iterator[Callable[..., BlockingClient]]:
    visitors: list[BlockingClient] = []

    def make(**options: Any) -> BlockingClient:
        visitors.append(BlockingClient(room.server.url, **options))
        visitors[-1].wait_for(lambda v: v.mirror.replayed)
        return visitors[-1]

    yield make
    for visitor in visitors:
        visitor.close()


def get(url: str, **headers: str) -> tuple[int, dict[str, str], bytes]:
    try:
        with urllib.request.urlopen(urllib.request.Request(url, headers=headers), timeout=60) as answer:
            return answer.status, {k.lower(): v for k, v in answer.headers.items()}, answer.read()
    except urllib.error.HTTPError as error:
        return error.code, {k.lower(): v for k, v in error.headers.items()}, error.read()


def write(visitor: BlockingClient, frames: bytes) -> None:
    """Put websocket frames on the line as they are, in one piece."""
    opened = visitor.visitor._socket
    assert opened is not None
    visitor._loop.call_soon_threadsafe(opened.transport.write, frames)


_pings = itertools.count(1)


def roundtrip(visitor: BlockingClient, room: Room) -> None:
    """Returns when the server has dealt with all that `visitor` said before: a connection's messages are read in order."""
    mark = f"mark {next(_pings)}"
    visitor.set_value("note", mark)
    visitor.wait_for(lambda v: mark in room.values("note") or v.closed)
    assert mark in room.values("note")
