"""What Duet replaces of viser: once, in whatever order it is called; what is replaced for one server is put back."""

from __future__ import annotations

from typing import Any

import pytest
import viser.infra._infra as viser_infra
import websockets
from viser import _gui_api, _gui_handles
from viser._assignable_props_api import AssignablePropsBase

from app.bench.blocking_client import BlockingClient
from app.web.server import DuetServer
from app.web.viser_internals import VISER_VERSION, ServerView, adapt_viser, serving_with, shared_messages


def replaced() -> tuple[Any, ...]:
    icons = tuple(vars(module)["svg_from_icon"] for module in (_gui_api, _gui_handles))
    return viser_infra._message_producer, vars(AssignablePropsBase)["_prop_hints"], *icons


def test_viser_is_the_version_that_the_file_fits() -> None:
    assert VISER_VERSION.startswith("1.1.")


def test_viser_is_adapted_once_however_often_it_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    adapt_viser()
    once = replaced()
    adapt_viser()
    assert replaced() == once and len({one.__module__ for one in once if hasattr(one, "__module__")}) == 1
    # Also after another program's change, in whatever order.
    monkeypatch.setattr(viser_infra, "_message_producer", None)
    adapt_viser()
    assert replaced() == once


def test_the_function_that_serves_is_given_back() -> None:
    def serve(*_: object) -> None: ...

    with pytest.raises(KeyError), serving_with(serve):
        assert vars(viser_infra)["websockets"].asyncio.server.serve is serve
        raise KeyError
    assert vars(viser_infra)["websockets"] is websockets


def test_a_view_has_messages_of_its_own(room: Any) -> None:
    server: DuetServer = room.server
    before = shared_messages(server)
    view = ServerView(server, before)
    view.scene.add_frame("/only here")
    names = [getattr(message, "name", "") for message in view.buffer.message_from_id.values()]
    assert "/hand" in names and "/only here" in names and shared_messages(server) == before
    with BlockingClient(server.url) as visitor:
        visitor.wait_for(lambda v: v.mirror.replayed)
        assert "/hand" in visitor.mirror.nodes and "/only here" not in visitor.mirror.nodes
