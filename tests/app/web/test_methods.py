"""The methods of HTTP on real sockets: HEAD is GET without a body, others are answered with what is possible."""

from __future__ import annotations

import contextlib
import socket

import pytest

from tests.app.web.conftest import Room


def ask(room: Room, *pieces: bytes) -> tuple[int, dict[str, str], bytes]:
    """Send pieces of a request, one by one, and return status, headers and body of what comes until the server closes."""
    with socket.create_connection(("127.0.0.1", room.server.get_port()), timeout=60) as line:
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for piece in pieces:
            line.sendall(piece)
        answer = b"".join(iter(lambda: line.recv(65536), b""))
    head, _, body = answer.partition(b"\r\n\r\n")
    first, *rest = head.decode().split("\r\n")
    headers = {name.lower(): value for name, _, value in (entry.partition(": ") for entry in rest)}
    return int(first.split()[1]), headers, body


def request(method: str, path: str = "/", *headers: str) -> bytes:
    return "\r\n".join((f"{method} {path} HTTP/1.1", "Host: localhost", *headers, "", "")).encode()


@pytest.mark.parametrize("path", ["/", "/?dm=0.1", "/healthz", "/nothing", "/index.html"])
def test_head_is_get_without_the_body(room: Room, path: str) -> None:
    status, headers, body = ask(room, request("GET", path))
    empty = ask(room, request("HEAD", path))
    assert empty == (status, headers, b"")
    assert int(headers.get("content-length", len(body))) == len(body)


def test_a_request_may_come_letter_by_letter(room: Room) -> None:
    whole = request("HEAD", "/healthz")
    status, headers, body = ask(room, *(whole[at : at + 1] for at in range(len(whole))))
    assert (status, headers["content-type"], body) == (200, "application/json", b"")


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "PATCH", "TRACE", "M-SEARCH"])
def test_other_methods_are_answered_with_what_is_possible(room: Room, method: str) -> None:
    for headers, sent in (
        ((), b""),
        (("Content-Length: 9",), b"some=data"),
        (("Transfer-Encoding: chunked",), b"1\r\nx\r\n0\r\n\r\n"),
    ):
        status, answered, body = ask(room, request(method, "/", *headers) + sent[:3], sent[3:])
        assert (status, answered["allow"], body) == (405, "GET, HEAD", b"Only GET and HEAD are possible.\n")
        assert answered["x-content-type-options"] == "nosniff"


def test_only_get_becomes_a_websocket(room: Room) -> None:
    upgrade = ("Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: " + "A" * 22 + "==")
    for method in ("HEAD", "POST"):
        assert ask(room, request(method, "/", *upgrade))[0] == 405


def test_what_is_no_request_is_not_answered(room: Room) -> None:
    for noise in (b"\x16\x03\x01\x02\x00\x01\r\n\r\n", b"HEAD\r\n\r\n", b"get / HTTP/1.1\r\n\r\n", b"x" * 9000):
        with socket.create_connection(("127.0.0.1", room.server.get_port()), timeout=60) as line:
            line.sendall(noise)
            with contextlib.suppress(ConnectionResetError):
                assert line.recv(100) == b""
    assert ask(room, request("HEAD"))[0] == 200
