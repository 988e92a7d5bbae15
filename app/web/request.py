"""What a browser's own request says: its page's query, and the address under which it knows us."""

from __future__ import annotations

import re
from typing import Final, cast

import viser

from app.web.index_page import page_query
from app.web.server import DuetServer

_ADDRESS: Final = re.compile(r"https?://[A-Za-z0-9.\-]+(:\d{1,5})?|https?://\[[0-9A-Fa-f:.]+\](:\d{1,5})?")
_FOLDER: Final = re.compile(r"(/[\w.~%-]+)*", re.ASCII)


def request_query(client: viser.ClientHandle) -> dict[str, str]:
    """The query (`?dm=0.1&n=10`) of the page that this browser has open; empty if it has none or is gone.

    Anybody can write anything there: validate names and values.
    """
    connection = client._viser_server._websock_server._live_connections.get(client.client_id)
    return {} if connection is None or connection.request is None else page_query(connection.request.path)


def request_address(client: viser.ClientHandle) -> str:
    """The address under which this browser knows the page, such as http://localhost:8080 or https://example.org/duet.

    A proxy may have given it another name, and put it into a folder.
    """
    connection = client._viser_server._websock_server._live_connections.get(client.client_id)
    headers = {} if connection is None or connection.request is None else connection.request.headers
    origin, host = headers.get("Origin", ""), headers.get("Host", "")
    folder = request_query(client).get("folder", "")
    if _ADDRESS.fullmatch(origin):
        return origin + (folder if _FOLDER.fullmatch(folder) else "")
    return f"http://{host}" if _ADDRESS.fullmatch(f"http://{host}") else cast(DuetServer, client._viser_server).url
