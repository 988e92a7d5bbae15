"""HEAD is answered like GET without the body, other methods with 405; `websockets` knows GET only, and never reads another one."""

from __future__ import annotations

import dataclasses
import re
from typing import Final

from websockets.http11 import Response

ALLOWED: Final = ("GET", "HEAD")

_LINE: Final = re.compile(rb"([A-Z-]{1,20}) [^ \r\n]+ HTTP/1\.1\r\n")
_LONGEST: Final = 8192  # as the library's own


class FirstLine:
    """The first line of a connection's request.

    Attributes:
        method: of the request; GET until it is known.
    """

    def __init__(self) -> None:
        self.method = "GET"
        self._begun: bytes | None = b""

    def take(self, data: bytes) -> bytes:
        """Return the bytes for the library: a request by GET in place of one by another method."""
        if self._begun is None:
            # The rest of a refused request, such as its body.
            return data if self.method in ALLOWED else b""
        self._begun += data
        if b"\n" not in self._begun and len(self._begun) <= _LONGEST:
            return b""
        begun, self._begun = self._begun, None
        line = _LINE.match(begun)
        if line is None:
            return begun
        self.method = line[1].decode()
        return b"GET" + begun[line.end(1) :] if self.method in ALLOWED else b"GET / HTTP/1.1\r\n\r\n"

    def answer(self, response: Response) -> Response:
        """Return the response to send, given the one to a GET."""
        return dataclasses.replace(response, body=b"") if self.method == "HEAD" else response
