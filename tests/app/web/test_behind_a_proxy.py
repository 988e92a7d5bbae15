"""Duet behind a proxy with a folder or another host name: it works, or names the missing option."""

import logging
import re
import shutil
import socket
import socketserver
import threading
from collections.abc import Iterator
from contextlib import suppress

import pytest
from playwright.sync_api import expect

from app.web.address import find_address
from scenes.settings import values
from tests.app.conftest import OpenHouse, live_sessions
from tests.blocking_client import BlockingClient
from tests.browser import PageAt, screenshot, until, wait_ready


class Proxy(socketserver.ThreadingTCPServer):
    """Proxy that forwards requests for one folder, without the folder's name.

    `host`: new Host header, None keeps it. `behind`: the server's port. `of_tabs`: port of another server
    for requests that name a tab; 0 for the same server.
    """

    allow_reuse_address = daemon_threads = True

    def __init__(self, folder: str, host: str | None) -> None:
        super().__init__(("127.0.0.1", 0), _Handing)
        self.folder, self.host, self.behind, self.of_tabs = folder, host, 0, 0

    @property
    def origin(self) -> str:
        """Origin in the browser; every name below `localhost` is this computer."""
        return f"http://duet.localhost:{self.server_address[1]}"


class _Handing(socketserver.StreamRequestHandler):
    def handle(self) -> None:
        proxy = self.server
        assert isinstance(proxy, Proxy)
        method, _, rest = self.rfile.readline().decode().partition(" ")
        if not rest.startswith(proxy.folder + "/"):
            return
        lines = [f"{method} {rest.removeprefix(proxy.folder)}"]
        while (line := self.rfile.readline().decode()).strip():
            rewritten = proxy.host is not None and line.lower().startswith("host:")
            lines.append(f"Host: {proxy.host}\r\n" if rewritten else line)
        port = proxy.of_tabs if proxy.of_tabs and "resume=" in rest else proxy.behind
        with socket.create_connection(("127.0.0.1", port)) as behind, suppress(OSError):
            behind.sendall("".join([*lines, "\r\n"]).encode())
            threading.Thread(target=self._hand_back, args=(behind,), daemon=True).start()
            while data := self.rfile.read1():
                behind.sendall(data)

    def _hand_back(self, behind: socket.socket) -> None:
        with suppress(OSError):
            with behind.makefile("rb", 0) as answer:
                shutil.copyfileobj(answer, self.wfile)
            self.connection.shutdown(socket.SHUT_RDWR)


@pytest.fixture
def proxies() -> Iterator[tuple[Proxy, Proxy]]:
    """One proxy with a folder and its own Host header, and one without changes."""
    with Proxy("/lab/duet", "upstream") as rewriting, Proxy("", None) as keeping:
        for proxy in (rewriting, keeping):
            threading.Thread(target=proxy.serve_forever, args=(0.01,), daemon=True).start()
        yield rewriting, keeping
        for proxy in (rewriting, keeping):
            proxy.shutdown()


@pytest.mark.thorough
def test_both_proxies_work_once_allowed_and_a_tab_stays_with_its_server(
    proxies: tuple[Proxy, Proxy], house: OpenHouse, page_at: PageAt, caplog: pytest.LogCaptureFixture
) -> None:
    strict, page, (rewriting, keeping) = house(), page_at(700, 500, fresh=True), proxies
    rewriting.behind = strict.server.get_port()
    page.goto(f"{rewriting.origin}/lab/duet/?lang=sl")
    expect(page.locator("#duet-connection")).to_have_text(
        f"Duet tega naslova ne pozna. Zaženite ga z --allow-origin {rewriting.origin}", timeout=60_000
    )
    screenshot(page, "address-not-known")
    assert f"start it with --allow-origin {rewriting.origin}" in caplog.text
    assert live_sessions(strict) == {}
    # Behind the second proxy, one server has the tab and the other one sends the page.
    first, open_to_both = (house(allowed_origins=tuple(one.origin for one in proxies)) for _ in range(2))
    rewriting.behind = keeping.of_tabs = open_to_both.server.get_port()
    keeping.behind = first.server.get_port()
    loads: list[int] = []
    page.on("load", lambda _: loads.append(1))
    for number, (one, folder) in enumerate(((rewriting, "/lab/duet"), (keeping, "")), 1):
        with page.expect_response(lambda answer: "healthz?resume=" in answer.url) as health:
            page.goto(f"{one.origin}{folder}/?n=8")
        assert health.value.json()["run"] == open_to_both.server.run != first.server.run
        wait_ready(page, "/room")
        until(
            page,
            lambda: any(values(s.settings)["n"] == 8.0 for s in live_sessions(open_to_both).values()),
            "its link",
        )
        assert page.evaluate("fetch('documents/model').then(answer => answer.status)") == 200
        link = page.locator(".duet-link input")
        expect(link).to_have_value(re.compile(rf"^{re.escape(one.origin + folder)}/\?"), timeout=60_000)
        assert len(loads) == number, "the page was reloaded to find its server"
    assert not live_sessions(first)


def test_a_program_of_another_origin_is_refused(
    proxies: tuple[Proxy, Proxy], house: OpenHouse, caplog: pytest.LogCaptureFixture
) -> None:
    rewriting, keeping = proxies
    keeping.behind = house(allowed_origins=(rewriting.origin,)).server.get_port()
    with caplog.at_level(logging.WARNING), pytest.raises(Exception, match="403"):
        BlockingClient(f"http://127.0.0.1:{keeping.server_address[1]}", "http://evil.example'$(x)")
    assert "refused origin" in caplog.text and "--allow-origin" not in caplog.text
    assert (
        find_address("https://duet.example.org/lab", "127.0.0.1", 8080).url == "https://duet.example.org/lab/"
    )
