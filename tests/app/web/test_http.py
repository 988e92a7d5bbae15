"""The server's answers to requests, its errors at the start, and its clean stop."""

import json
import logging
import re
import socket
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import Any

import pytest
from prometheus_client.parser import text_string_to_metric_families
from viser import infra

from app.runtime.throttled_log import ThrottledLog
from app.settings import Language
from app.web.listening import PortInUse, port_answers
from app.web.origin_policy import OriginPolicy
from app.web.pages import QUESTION, ROOM_IS_FULL, full_page, page_query, patched_index
from app.web.server import DuetServer, log
from app.web.traffic_limits import TrafficLimits
from controllers.errors import BadSetting, DuetError
from tests.app.runtime.processes import until
from tests.app.web.conftest import Join, Room, Start, ended, get
from tests.blocking_client import BlockingClient


def test_a_pages_question_is_answered_only_while_the_server_works(room: Room, join: Join) -> None:
    visitor = join()
    before = visitor.received.frames
    for at_work in (True, False, True):
        asked: list[bool] = []
        room.server.is_at_work = lambda at_work=at_work, asked=asked: asked.append(at_work) or at_work
        visitor.send({"type": QUESTION})
        visitor.wait_for(lambda _, asked=asked: asked)
    visitor.wait_for(lambda v: v.received.frames >= before + 2)
    assert visitor.received.frames == before + 2 and visitor.closed is None


def test_pages_have_the_headers_and_the_server_reports_its_health(room: Room, join: Join) -> None:
    for path in ("/", "/?dm=0.1", "/healthz"):
        status, headers, _ = get(room.server.url + path)
        assert status == 200
        assert (
            headers["x-content-type-options"] == "nosniff"
            and headers["content-security-policy"] == "frame-ancestors 'self'"
        )
        assert headers["referrer-policy"] == "no-referrer" and headers["cache-control"] in (
            "no-cache",
            "no-store",
        )
    assert get(room.server.url + "/nothing")[0] == 404
    assert get(room.server.url + "/../../../etc/passwd")[0] == 404
    assert get(room.server.url + "/index.html?dm=1")[0] == 200
    join().wait_for(lambda _: room.server.count_clients() == 1)
    _, headers, body = get(room.server.url + "/healthz")
    state = json.loads(body)
    assert headers["content-type"] == "application/json"
    assert (
        state["ok"] is True
        and state["clients"] == 1
        and state["room"] is True
        and re.match(r"\d", state["version"])
    )


def test_only_listed_origins_may_embed_the_page(start: Start) -> None:
    server = start(embed_origins=("https://moodle.example.org", "http://slides.example.org:8000"))
    for path in ("/", "/healthz", "/nothing", "/robots.txt"):
        _, headers, _ = get(server.url + path)
        allowed = "frame-ancestors 'self' https://moodle.example.org http://slides.example.org:8000"
        assert headers["content-security-policy"] == allowed and "x-frame-options" not in headers
    with pytest.raises(
        BadSetting, match=r"embed origin .*/course' has a path; give https://moodle\.example\.org$"
    ):
        start(embed_origins=("https://moodle.example.org/course",))


def measured(body: bytes) -> dict[str, float]:
    return {
        sample.name: sample.value
        for family in text_string_to_metric_families(body.decode())
        for sample in family.samples
    }


STATE = {
    "store": {
        "lasting": True,
        "problem": "the disk is full",
        "set_aside": "visitors.sqlite.damaged-20260101-000000",
    },
    "sessions": 7,
    "frames": 21,
    "load": 95,
    "places": 8,
}


@pytest.fixture
def measured_server(start: Start) -> Callable[..., DuetServer]:
    """Function that starts a server with the app state `STATE`, measurable from other computers by a key."""

    def make(**options: Any) -> DuetServer:
        server = start(**options)
        server.app_state = lambda: dict(STATE)
        server.may_measure = lambda query: query.get("key") == "chalk-dust"
        return server

    return make


def test_the_health_has_the_state_of_the_app(measured_server: Callable[..., DuetServer]) -> None:
    health = json.loads(get(measured_server(host="0.0.0.0").url + "/healthz")[2])
    assert [health[name] for name in ("sessions", "frames", "load")] == [7, 21, 95]
    assert health["store"]["problem"] == "the disk is full"


METRICS = {
    "duet_ok": 1.0,
    "duet_clients": 0.0,
    "duet_room": 1.0,
    "duet_sessions": 7.0,
    "duet_frames_per_second": 21.0,
    "duet_load_ratio": 0.95,
    "duet_store_lasting": 1.0,
    "duet_store_ok": 0.0,
    "duet_store_set_aside": 1.0,
}


def see_metrics(server: DuetServer, query: str = "", **headers: str) -> None:
    status, answer, body = get(f"{server.url}/metrics{query}", **headers)
    assert status == 200
    assert answer["content-type"].startswith("text/plain; version=0.0.4")
    assert answer["cache-control"] == "no-store"
    values = measured(body)
    assert {name: values[name] for name in METRICS} == METRICS


FROM_ELSEWHERE = {"X-Forwarded-For": "203.0.113.9"}


def test_prometheus_reads_the_metrics_locally_or_with_the_key(
    measured_server: Callable[..., DuetServer],
) -> None:
    open_to_all = measured_server(host="0.0.0.0")
    see_metrics(open_to_all)
    see_metrics(open_to_all, "?key=chalk-dust", **FROM_ELSEWHERE)
    assert get(open_to_all.url + "/metrics", **FROM_ELSEWHERE)[0] == 403
    assert not OriginPolicy("0.0.0.0", 8080).is_local("192.168.1.5", ())


def test_prometheus_needs_the_key_behind_a_proxy(measured_server: Callable[..., DuetServer]) -> None:
    behind = measured_server(allowed_origins=("https://duet.example.org",))
    see_metrics(behind, "?key=chalk-dust")
    for query in ("", "?key=chalk"):
        assert get(f"{behind.url}/metrics{query}")[0] == 403, query


def test_index_is_patched_once_and_safely(room: Room) -> None:
    plain = get(room.server.url + "/")[2].decode()
    assert plain.count("duet-connection") > 1 and "<title>Duet</title>" in plain
    client = "<head><title>Viser</title><script>viser</script></head><body><p></p></body>"
    hostile = patched_index(client, title="</title><script>1</script>", body="<i>")
    assert "<script>1" not in hostile and hostile.count("</script>") == 2
    # `body` comes first in the body, before viser's program.
    assert hostile.endswith("</head><body><i><script>viser</script><p></p></body>")
    with pytest.raises(ValueError, match="title"):
        patched_index("<html></html>", title="Duet")


@pytest.mark.parametrize(
    ("path", "query"),
    [
        *(
            ("/?dm=0.1&n=10", {"dm": "0.1", "n": "10"}),
            ("/", {}),
            ("?a=1", {"a": "1"}),
            ("/?a=1&a=2", {"a": "1"}),
        ),
        *(("/?empty=", {"empty": ""}), ("/?x=%3Cscript%3E&y=a+b", {"x": "<script>", "y": "a b"})),
        *(("/?" + "k" * 41 + "=1&ok=2", {"ok": "2"}), ("/?long=" + "v" * 401 + "&ok=2", {"ok": "2"})),
        *(
            ("/?" + "&".join(f"k{i}=1" for i in range(65)), {}),
            ("//evil.example/?a=1", {"a": "1"}),
            ("//[?a=1", {"a": "1"}),
        ),
    ],
)
def test_page_query(path: str, query: dict[str, str]) -> None:
    assert page_query(path) == query


def test_the_ninth_visitor_gets_the_full_page_and_later_a_place(start: Start) -> None:
    server = start(max_clients=8)
    eight = [BlockingClient(server.url) for _ in range(8)]
    try:
        eight[-1].wait_for(lambda v: server.count_clients() == 8)
        status, headers, body = get(server.url + "/?dm=0.1")
        assert status == 503 and headers["retry-after"] == "10" and body.decode() == full_page(8)
        assert "8 places" in full_page(8) and "one place" in full_page(1)
        assert not re.search(r"(href|src)=.https?:|@import|url\(", full_page(8)), (
            "the page needs another server"
        )
        assert json.loads(get(server.url + "/healthz")[2])["room"] is False
        with BlockingClient(server.url) as late:
            assert ended(late) == (1013, ROOM_IS_FULL)
        eight.pop().close()
        eight[0].wait_for(lambda v: server.count_clients() == 7)
        assert get(server.url + "/")[0] == 200
        eight.append(BlockingClient(server.url))
        eight[-1].wait_for(lambda v: v.mirror.replayed)
        assert eight[-1].closed is None
    finally:
        for visitor in eight:
            visitor.close()


def test_documents_are_served_in_the_requested_language(start: Start) -> None:
    url = (
        start(documents={"/documents/model": lambda language: f"<p>{language}".encode()}).url
        + "/documents/model"
    )
    for address, accept, language in ((url, "sl", "sl"), (f"{url}?lang=de", "sl", "de")):
        status, headers, body = get(address, **{"Accept-Language": accept})
        assert (status, headers["vary"], body) == (200, "Accept-Language", f"<p>{language}".encode())
        assert (
            headers["content-type"].startswith("text/html") and headers["x-content-type-options"] == "nosniff"
        )
    assert get(f"{url}s")[0] == 404


def ask(room: Room, *pieces: bytes, closes: bool = False) -> tuple[int, dict[str, str], bytes]:
    with socket.create_connection(("127.0.0.1", room.server.get_port()), timeout=60) as line:
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for piece in pieces:
            line.sendall(piece)
        if closes:
            line.shutdown(socket.SHUT_WR)
        answer = b"".join(iter(lambda: line.recv(65536), b""))
    head, _, body = answer.partition(b"\r\n\r\n")
    first, *rest = head.decode().split("\r\n")
    headers = {name.lower(): value for name, _, value in (entry.partition(": ") for entry in rest)}
    return int(first.split()[1]), headers, body


def request(method: str, path: str = "/", *headers: str) -> bytes:
    return "\r\n".join((f"{method} {path} HTTP/1.1", "Host: localhost", *headers, "", "")).encode()


def test_head_is_get_without_a_body_and_may_arrive_byte_by_byte(room: Room) -> None:
    for path in ("/", "/?dm=0.1", "/healthz", "/nothing", "/index.html"):
        status, headers, body = ask(room, request("GET", path))
        assert ask(room, request("HEAD", path)) == (status, headers, b"")
        assert int(headers.get("content-length", len(body))) == len(body)
    whole = request("HEAD", "/healthz")
    status, headers, body = ask(room, *(whole[at : at + 1] for at in range(len(whole))))
    assert (status, headers["content-type"], body) == (200, "application/json", b"")


ODD_BODIES = (
    ((), b""),
    (("Content-Length: 9",), b"some=data"),
    (("Transfer-Encoding: chunked",), b"1\r\nx\r\n0\r\n\r\n"),
)


def test_other_methods_get_the_list_of_allowed_ones(room: Room) -> None:
    for method in ("POST", "PUT", "DELETE", "OPTIONS", "PATCH", "TRACE", "M-SEARCH"):
        for headers, sent in ODD_BODIES:
            status, answered, body = ask(room, request(method, "/", *headers) + sent[:3], sent[3:])
            assert (status, answered["allow"], body) == (
                405,
                "GET, HEAD",
                b"Only GET and HEAD are possible.\n",
            ), method
            assert answered["x-content-type-options"] == "nosniff"
    upgrade = (
        "Upgrade: websocket",
        "Connection: Upgrade",
        "Sec-WebSocket-Version: 13",
        "Sec-WebSocket-Key: " + "A" * 22 + "==",
    )
    for method in ("HEAD", "POST"):
        assert ask(room, request(method, "/", *upgrade))[0] == 405


HEAD = b"GET / HTTP/1.1\r\nHost: localhost\r\n"
FAULTS = {
    400: (
        *(b"\x16\x03\x01\x02\x00\x01\r\n", b"\r\n\r\n", b"HEAD\r\n\r\n", b"GET /\r\n\r\n", b"garbage\n" * 9),
        *(b"get / HTTP/1.1\r\n\r\n", b"GET / HTTP/1.1\nHost: localhost\n\n", b"GET /\x00 HTTP/1.1\r\n"),
        *(b"GET / HTTP/1.1\r\n\r\n", HEAD + b"Host: localhost\r\n\r\n"),
        *(HEAD + b"%b\r\n\r\n" % line for line in (b"colon", b"A : b", b" b", b"A: \x01")),
        *(HEAD + b"Content-Length: %b\r\n\r\n" % length for length in (b"x", b"5")),
        *(HEAD + b"A: b\n\r\n\r\n", HEAD + b"Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n"),
    ),
    414: (b"x" * 9000, b"GET /" + b"x" * 9000 + b" HTTP/1.1\r\nHost: localhost\r\n\r\n"),
    431: (HEAD + b"A: " + b"x" * 9000 + b"\r\n\r\n", HEAD + b"A: b\r\n" * 200 + b"\r\n"),
    505: (b"GET / HTTP/1.0\r\n\r\n", b"PRI * HTTP/2.0\r\n\r\n"),
}


def test_a_faulty_request_gets_its_status_and_is_logged_with_its_address(
    room: Room, caplog: pytest.LogCaptureFixture
) -> None:
    room.server.log = ThrottledLog(log, (0.0,))
    for status, requests in FAULTS.items():
        for one in requests:
            with caplog.at_level(logging.WARNING):
                caplog.clear()
                answered, headers, _ = ask(room, one)
                assert (answered, headers["x-content-type-options"]) == (status, "nosniff"), one
                (line,) = caplog.messages
                assert line.startswith(f"faulty request: {status} ") and line.endswith(", from 127.0.0.1")
    # No file can have these names.
    for path in (f"/{'x' * 3000}", "//[", "/%00"):
        assert ask(room, request("GET", path))[0] == 404
    assert ask(room, request("HEAD"))[0] == 200


def test_half_a_request_is_closed_and_a_slow_document_is_not(start: Start) -> None:
    asked, drawn = threading.Event(), threading.Event()

    def render(_: Language) -> bytes:
        asked.set()
        assert drawn.wait(60.0)
        return b"<p>drawn"

    server = start(limits=TrafficLimits(head_seconds=0.2), documents={"/documents/slow": render})
    with ThreadPoolExecutor(1) as reader:
        answer = reader.submit(get, server.url + "/documents/slow")
        assert asked.wait(60.0)
        with socket.create_connection(("127.0.0.1", server.get_port()), 60.0) as line:
            line.sendall(b"GET /hea")
            with suppress(ConnectionResetError):
                assert line.recv(1) == b""
        drawn.set()
        status, _, body = answer.result(60.0)
    assert (status, body) == (200, b"<p>drawn")


def test_unfinished_requests_and_surplus_data_log_no_warning(
    room: Room, caplog: pytest.LogCaptureFixture
) -> None:
    room.server.log = ThrottledLog(log, (0.0,))
    asked = request("GET", "/healthz")
    with caplog.at_level(logging.DEBUG):
        for sent in (b"", b"GET /hea", asked[:-2]):
            before = caplog.text.count("opening handshake failed")
            with socket.create_connection(("127.0.0.1", room.server.get_port())) as line:
                line.sendall(sent)
            until(lambda before=before: caplog.text.count("opening handshake failed") > before)
        # The client may close its end, and surplus data is not parsed as websocket frames.
        for more in (b"", b"more" * 1000, asked * 3):
            assert ask(room, asked + more, closes=True)[0] == 200
    assert not [record for record in caplog.records if record.levelno >= logging.WARNING], caplog.text


@pytest.mark.parametrize("other_host", ["127.0.0.1", "0.0.0.0"])
def test_a_busy_port_is_an_error_that_names_the_remedy(other_host: str) -> None:
    with socket.socket() as other:
        other.bind((other_host, 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(PortInUse, match=rf"port {port} .*--port {port % 65535 + 1}") as error:
            DuetServer(port=port)
        assert isinstance(error.value, DuetError) and "\n" not in str(error.value)
        # Only macOS needs this check; the rule is the same on all systems.
        assert port_answers("127.0.0.1", port)
    assert not port_answers("127.0.0.1", port)
    DuetServer(port=port).stop()


@pytest.mark.parametrize(
    "options",
    [{"port": 70000}, {"port": -1}, {"host": "203.0.113.9"}, {"host": "no such host"}, {"max_clients": 0}],
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
    # The threads of callbacks end by themselves.
    until(lambda: set(threading.enumerate()) <= before)
    assert capfd.readouterr().out == ""


def test_a_visitor_who_connects_during_construction_is_served(
    start: Start, monkeypatch: pytest.MonkeyPatch
) -> None:
    early: list[BlockingClient] = []
    original = infra.WebsockServer.start

    def start_and_be_met(self: infra.WebsockServer) -> None:
        original(self)
        # viser listens already, but its scene and GUI are not built yet.
        early.append(BlockingClient(f"http://127.0.0.1:{self._port}"))

    monkeypatch.setattr(infra.WebsockServer, "start", start_and_be_met)
    server = start()
    early[0].wait_for(lambda v: v.mirror.replayed and server.get_clients())
    early[0].close()
    assert (
        early[0].closed is not None and early[0].closed.rcvd is not None and early[0].closed.rcvd.code == 1000
    )
