"""What we serve ourselves: the page, the page of a full server, and the headers of every answer."""

from __future__ import annotations

import gzip
import http
from typing import Final

from websockets.datastructures import Headers
from websockets.http11 import Response

from app.web.index_page import full_page, patched_index
from app.web.page_assets import PageAssets
from app.web.viser_internals import client_html

OWN_HEADERS: Final = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "X-Frame-Options": "SAMEORIGIN",
    "Cache-Control": "no-cache",
}
HTML: Final = "text/html; charset=utf-8"


def respond(status: int, content_type: str, body: bytes, extra: dict[str, str]) -> Response:
    """Return a response with our headers and `extra` ones."""
    headers = Headers({"Content-Type": content_type, "Content-Length": str(len(body)), "Connection": "close"})
    for name, value in {**OWN_HEADERS, **extra}.items():
        headers[name] = value
    return Response(status, http.HTTPStatus(status).phrase, headers, body)


def own_pages(run: str, max_clients: int | None, assets: PageAssets, body: str) -> dict[str, bytes]:
    """Return the page of viser's client with our additions ("plain", and "packed" by gzip), and the one of a full server ("full").

    Args:
        run: a word that is different for every start of the server.
        max_clients: places of the server; None for no limit.
        assets, body: see `app.web.index_page.patched_index`.
    """
    plain = patched_index(client_html(), title="Duet", run=run, assets=assets, body=body).encode()
    return {"plain": plain, "packed": gzip.compress(plain, 6), "full": full_page(max_clients or 0).encode()}
