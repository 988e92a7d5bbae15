"""What we serve ourselves: the page, the one of a full room, and the headers of every answer."""

from __future__ import annotations

import gzip
import http
from pathlib import Path
from typing import Final

import viser
from websockets.datastructures import Headers
from websockets.http11 import Response

from app.web.index_page import patched_index
from app.web.page_assets import PageAssets

OWN_HEADERS: Final = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "X-Frame-Options": "SAMEORIGIN",
    "Cache-Control": "no-cache",
}
HTML: Final = "text/html; charset=utf-8"


def respond(status: int, content_type: str, body: bytes, extra: dict[str, str]) -> Response:
    """Return an answer with our headers, and `extra` ones."""
    headers = Headers({"Content-Type": content_type, "Content-Length": str(len(body)), "Connection": "close"})
    for name, value in {**OWN_HEADERS, **extra}.items():
        headers[name] = value
    return Response(status, http.HTTPStatus(status).phrase, headers, body)


def own_pages(label: str, run: str, full_html: str, assets: PageAssets, body: str) -> dict[str, bytes]:
    """Return the page of viser's client with our additions ("plain", and "packed" by gzip), and the one of a full room ("full")."""
    client = Path(viser.__file__).parent / "client" / "build" / "index.html"
    plain = patched_index(client.read_text(encoding="utf-8"), title=label, run=run, assets=assets, body=body).encode()
    return {"plain": plain, "packed": gzip.compress(plain, 6), "full": full_html.encode()}
