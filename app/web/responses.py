"""The responses that we make ourselves, and the headers of every answer."""

from __future__ import annotations

import http
from typing import Final

from websockets.datastructures import Headers
from websockets.http11 import Response

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
