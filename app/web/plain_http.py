"""Plain HTTP: heads of requests, our own responses, and `/metrics`."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from http import HTTPStatus
from typing import Any, Final

from prometheus_client import CollectorRegistry, Gauge, Info, generate_latest
from websockets.datastructures import Headers
from websockets.exceptions import SecurityError
from websockets.http11 import Request, Response
from websockets.streams import StreamReader

ALLOWED: Final = ("GET", "HEAD")

_LINE: Final = re.compile(rb"([A-Z-]{1,20}) [!-~]+ HTTP/(\d\.\d)\r\n")
_END: Final = re.compile(rb"\n\r?\n")
_LONGEST_LINE: Final = 8192  # as the library's own
_LONGEST: Final = 64 * 1024
_STAND_IN: Final = b"GET / HTTP/1.1\r\n\r\n"


class RequestHead:
    """Received part of a request's head.

    Attributes:
        method: GET until it is known.
        fault: status of the answer to a faulty request, or None.
        complete: True once the library has a head.
    """

    def __init__(self) -> None:
        self.method, self.complete = "GET", False
        self.fault: HTTPStatus | None = None
        self._begun = bytearray()

    def take(self, data: bytes) -> bytes:
        """Bytes for the library: none before the head is complete, then GET in place of any method."""
        known = len(self._begun)
        self._begun += data
        line = self._begun.find(b"\n")
        if line > _LONGEST_LINE or (line < 0 and len(self._begun) > _LONGEST_LINE):
            return self._refuse(HTTPStatus.REQUEST_URI_TOO_LONG)
        if line >= known:
            found = _LINE.match(self._begun)
            if found is None:
                return self._refuse(HTTPStatus.BAD_REQUEST)
            if found[2] != b"1.1":
                return self._refuse(HTTPStatus.HTTP_VERSION_NOT_SUPPORTED)
            self.method = found[1].decode()
        end = None if line < 0 else _END.search(self._begun, max(known - 2, 0))
        if (len(self._begun) if end is None else end.end()) > _LONGEST:
            return self._refuse(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE)
        if end is None:
            return b""
        self.complete = True
        if self.method not in ALLOWED:
            return _STAND_IN
        head = b"GET" + self._begun[len(self.method) : end.end()]
        fault = _fault_of(head)
        return bytes(head) if fault is None else self._refuse(fault)

    def _refuse(self, fault: HTTPStatus) -> bytes:
        self.fault, self.complete = fault, True
        return _STAND_IN

    def answer(self, response: Response) -> Response:
        return dataclasses.replace(response, body=b"") if self.method == "HEAD" else response


def _fault_of(head: bytes) -> HTTPStatus | None:
    """Status by the library's rules, with exactly one Host (RFC 9112, section 3.2)."""
    reader = StreamReader()
    reader.feed_data(head)
    try:
        next(Request.parse(reader.read_line))
    except StopIteration as parsed:
        return None if len(parsed.value.headers.get_all("Host")) == 1 else HTTPStatus.BAD_REQUEST
    except SecurityError:
        return HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE
    except (ValueError, EOFError, NotImplementedError):
        pass
    return HTTPStatus.BAD_REQUEST


OWN_HEADERS: Final = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-cache",
}


HTML: Final = "text/html; charset=utf-8"


def respond(status: int, content_type: str, body: bytes, extra: dict[str, str]) -> Response:
    headers = Headers({"Content-Type": content_type, "Content-Length": str(len(body)), "Connection": "close"})
    for name, value in {**OWN_HEADERS, **extra}.items():
        headers[name] = value
    return Response(status, HTTPStatus(status).phrase, headers, body)


def metrics_text(state: Mapping[str, Any]) -> bytes:
    """Prometheus' text format. `state`: as in `/healthz`."""
    registry = CollectorRegistry()
    Info("duet", "The program that serves.", registry=registry).info(
        {name: state[name] for name in ("version", "run")}
    )
    store = state.get("store", {})
    for name, meaning, value in (
        ("ok", "Whether pages are drawn.", state["ok"]),
        ("clients", "Browsers that are connected.", state["clients"]),
        ("room", "Whether a newcomer gets a place.", state["room"]),
        ("sessions", "Sessions at work.", state.get("sessions", 0)),
        ("frames_per_second", "Frames a second of the slowest process.", state.get("frames", 0)),
        (
            "load_ratio",
            "Load of the busiest process; at 1 its pages have 20 frames a second.",
            state.get("load", 0) / 100.0,
        ),
        ("store_lasting", "Whether visitors' work outlives the server.", store.get("lasting", False)),
        ("store_ok", "Whether visitors' work can be written.", not store.get("problem")),
        (
            "store_set_aside",
            "Whether a damaged file of visitors' work lies beside the store.",
            bool(store.get("set_aside")),
        ),
    ):
        Gauge(f"duet_{name}", meaning, registry=registry).set(value)
    return generate_latest(registry)
