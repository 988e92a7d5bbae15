"""A server with one control of each kind, and clients that use viser's protocol."""

import asyncio
import itertools
import urllib.error
import urllib.request
from collections.abc import Callable, Coroutine, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

import pytest
import websockets

from app.web.server import DuetServer
from tests.blocking_client import BlockingClient

Start = Callable[..., DuetServer]
Join = Callable[..., BlockingClient]


class Room:
    def __init__(self, server: DuetServer) -> None:
        self.server, gui = server, server.gui
        self.seen: list[tuple[str, Any]] = []
        with gui.add_form("form") as self.form:
            inner = gui.add_number("inner", 0.0)
        self.slider = gui.add_slider("d_m", min=0.05, max=0.3, step=0.01, initial_value=0.1)
        self.text = gui.add_text("note", "")
        self.choice = gui.add_dropdown("law", ("smooth", "strict"), initial_value="smooth")
        self.pair = gui.add_vector2("pair", (0.0, 0.0), min=(-1.0, -1.0), max=(1.0, 1.0))
        self.upload = gui.add_upload_button("file")
        self.gizmo = server.scene.add_transform_controls("/hand", scale=0.3, position=(0.0, 0.0, 0.5))
        locked = gui.add_slider("locked", min=0.0, max=1.0, step=0.1, initial_value=0.5, disabled=True)
        named = {
            "d_m": self.slider,
            "note": self.text,
            "law": self.choice,
            "pair": self.pair,
            "inner": inner,
            "locked": locked,
        }
        for name, handle in named.items():
            self._watch(handle.on_update, name, lambda event: event.target.value)
        self._watch(gui.add_button("go").on_click, "go", lambda event: event.client_id)
        self._watch(self.upload.on_upload, "file", lambda event: len(event.target.value.content))
        self._watch(self.gizmo.on_update, "hand", lambda event: tuple(event.target.position))

    def _watch(self, register: Any, name: str, value: Callable[[Any], Any]) -> None:
        @register
        async def _(event: Any) -> None:
            self.seen.append((name, value(event)))

    def values(self, name: str) -> list[Any]:
        return [value for what, value in self.seen if what == name]


@pytest.fixture
def start() -> Iterator[Start]:
    servers: list[DuetServer] = []

    def make(port: int = 0, **options: Any) -> DuetServer:
        servers.append(DuetServer(port=port, **options))
        return servers[-1]

    yield make
    for server in servers:
        server.stop()


@pytest.fixture
def room(start: Start) -> Room:
    return Room(start())


@pytest.fixture
def join(room: Room) -> Iterator[Join]:
    visitors: list[BlockingClient] = []

    def make(**options: Any) -> BlockingClient:
        visitors.append(BlockingClient(room.server.url, **options))
        visitors[-1].wait_for(lambda v: v.mirror.replayed)
        return visitors[-1]

    yield make
    for visitor in visitors:
        visitor.close()


def in_a_loop(work: Coroutine[Any, Any, Any]) -> Any:
    """Result of a coroutine in a separate thread: with a browser, this thread has a running event loop."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, work).result()


def get(url: str, **headers: str) -> tuple[int, dict[str, str], bytes]:
    try:
        with urllib.request.urlopen(urllib.request.Request(url, headers=headers), timeout=60) as answer:
            return answer.status, {k.lower(): v for k, v in answer.headers.items()}, answer.read()
    except urllib.error.HTTPError as error:
        return error.code, {k.lower(): v for k, v in error.headers.items()}, error.read()


def socket_of(visitor: BlockingClient) -> websockets.ClientConnection:
    opened = visitor.visitor._socket
    assert opened is not None
    return opened


def write(visitor: BlockingClient, frames: bytes) -> None:
    visitor.loop.call_soon_threadsafe(socket_of(visitor).transport.write, frames)


_marks = itertools.count(1)


def roundtrip(visitor: BlockingClient, room: Room) -> None:
    """Wait until the server has read all messages of `visitor`; it reads a connection's messages in order."""
    mark = f"mark {next(_marks)}"
    visitor.set_value("note", mark)
    visitor.wait_for(lambda v: mark in room.values("note") or v.closed)
    assert mark in room.values("note")


@contextmanager
def visiting(server: DuetServer, **options: Any) -> Iterator[BlockingClient]:
    with BlockingClient(server.url, **options) as visitor:
        visitor.wait_for(lambda v: v.mirror.replayed)
        yield visitor


def ended(visitor: BlockingClient) -> tuple[int, str]:
    visitor.wait_for(lambda v: v.closed)
    assert visitor.closed is not None and visitor.closed.rcvd is not None
    return visitor.closed.rcvd.code, visitor.closed.rcvd.reason
