"""A server that starts says what it can't, and one that stops leaves neither port nor thread nor visitor behind."""

import socket
import threading
from typing import Any

import pytest
from viser import infra

from app.bench.blocking_client import BlockingClient
from app.web.listening import PortInUse, port_answers
from app.web.server import DuetServer
from controllers.errors import BadSetting, DuetError
from tests.app.web.conftest import Start


@pytest.mark.parametrize("other_host", ["127.0.0.1", "0.0.0.0"])
def test_a_busy_port_is_an_error_that_names_the_remedy(other_host: str) -> None:
    with socket.socket() as other:
        other.bind((other_host, 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(PortInUse, match=rf"port {port} .*--port {port % 65535 + 1}") as error:
            DuetServer(port=port)
        assert isinstance(error.value, DuetError) and "\n" not in str(error.value)
        # What macOS needs; the rule itself is the same everywhere.
        assert port_answers("127.0.0.1", port)
    assert not port_answers("127.0.0.1", port)
    DuetServer(port=port).stop()


@pytest.mark.parametrize(
    "options", [{"port": 70000}, {"port": -1}, {"host": "203.0.113.9"}, {"host": "no such host"}, {"max_clients": 0}]
)
def test_impossible_settings_are_explained(options: dict[str, Any]) -> None:
    with pytest.raises(BadSetting, match="valid: "):
        DuetServer(**{"port": 0, **options})


def test_stopping_releases_port_thread_and_page(start: Start, capfd: pytest.CaptureFixture[str]) -> None:
    before = set(threading.enumerate())
    server = start()
    port, visitor = server.get_port(), BlockingClient(server.url)
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


def test_a_visitor_at_the_door_during_construction_is_served(start: Start, monkeypatch: pytest.MonkeyPatch) -> None:
    early: list[BlockingClient] = []
    original = infra.WebsockServer.start

    def start_and_be_met(self: infra.WebsockServer) -> None:
        original(self)
        # viser listens already, but has yet to build its scene and its GUI.
        early.append(BlockingClient(f"http://127.0.0.1:{self._port}"))

    monkeypatch.setattr(infra.WebsockServer, "start", start_and_be_met)
    server = start()
    early[0].wait_for(lambda v: v.mirror.replayed and server.get_clients())
    early[0].close()
    assert early[0].closed is not None and early[0].closed.rcvd is not None and early[0].closed.rcvd.code == 1000
