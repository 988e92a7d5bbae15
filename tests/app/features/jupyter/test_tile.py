"""The tile in a real Jupyter server: listed, with page and websocket, and closed without the login."""

import json
import socket
import subprocess
import sys
from urllib.parse import urlsplit

import msgspec
import pytest
import websockets
from websockets.sync.client import connect
from websockets.typing import Origin, Subprotocol

from app.web.headless_client import CAMERA
from app.web.viser_internals import VISER_VERSION
from tests.app.features.jupyter.conftest import TOKEN, JupyterServer
from tests.blocking_client import BlockingClient
from tests.browser import PageAt, until, wait_ready

LOAD = """
import sys
from importlib.metadata import entry_points
(entry,) = entry_points(group="jupyter_serverproxy_servers", name="duet")
assert entry.load()()["command"]
print(*({name.partition(".")[0] for name in sys.modules} & {"viser", "numpy", "tornado", "jupyter_server", "IPython", "traitlets"}))
"""
"""Prints the packages that the tile imports into a Jupyter server."""

START = "import sys, app.start, app.cli.main; print(*({'IPython', 'jupyter_server', 'tornado', 'traitlets'} & set(sys.modules)))"
"""Prints the packages of Jupyter that Duet imports at its start."""


@pytest.mark.parametrize("code", [LOAD, START])
def test_tile_and_start_do_not_import_each_others_packages(code: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True
    )
    assert done.stdout.strip() == ""


def test_the_launcher_shows_the_tile_with_our_icon(jupyter: JupyterServer) -> None:
    _, _, answer = jupyter.get("server-proxy/servers-info")
    (tile,) = [one for one in json.loads(answer)["server_processes"] if one["name"] == "duet"]
    assert tile["launcher_entry"]["title"] == "Duet"
    # JupyterLab shows an icon for these categories only.
    assert tile["launcher_entry"]["category"] in ("Notebook", "Console")
    path = urlsplit(tile["launcher_entry"]["icon_url"]).path.removeprefix(jupyter.folder)
    status, _, icon = jupyter.get(path)
    assert status == 200 and icon.startswith(b"<svg")


@pytest.mark.parametrize("token", ["", "wrong"])
def test_without_the_login_page_and_websocket_are_closed(jupyter: JupyterServer, token: str) -> None:
    _, url, page = jupyter.get("duet/", token)
    assert "/login?" in url and b"duet-loading" not in page
    with pytest.raises(websockets.InvalidStatus, match="403"):
        BlockingClient(jupyter.url + "duet", query=f"token={token}")


@pytest.mark.thorough
def test_the_tile_shows_the_arms_under_the_hubs_name_but_not_to_a_foreign_page(
    jupyter: JupyterServer, page_at: PageAt
) -> None:
    page = page_at(700, 500)
    page.goto(f"{jupyter.origin}{jupyter.folder}duet/?n=8&panel=all&token={TOKEN}")
    wait_ready(page, "/room")
    link = page.locator(".duet-link input")
    link.wait_for(state="attached")
    until(page, lambda: link.input_value().startswith(f"{jupyter.origin}{jupyter.folder}duet/?"), "the link")
    # A login brings the tile's proof, which permits writing a law.
    page.get_by_role("tab", name="Compare").click()
    page.locator(".duet-law textarea").wait_for(state="attached")
    cookies = "; ".join(f"{one.get('name')}={one.get('value')}" for one in page.context.cookies())
    assert first_message(jupyter, jupyter.origin, cookies)
    for origin, brought in ((jupyter.origin, ""), ("http://evil.example", cookies)):
        with pytest.raises(websockets.InvalidStatus, match="403"):
            first_message(jupyter, origin, brought)


def first_message(jupyter: JupyterServer, origin: str, cookies: str) -> bytes | str:
    """First message to a browser that opens the tile's websocket under the hub's name."""
    with connect(
        f"{jupyter.origin.replace('http', 'ws')}{jupyter.folder}duet/",
        sock=socket.create_connection(("127.0.0.1", jupyter.port)),
        origin=Origin(origin),
        subprotocols=[Subprotocol(f"viser-v{VISER_VERSION}")],
        additional_headers={"Cookie": cookies},
        open_timeout=60.0,
        proxy=None,
    ) as connection:
        # A silent client is disconnected.
        connection.send(msgspec.msgpack.encode(CAMERA))
        return connection.recv(60.0)
