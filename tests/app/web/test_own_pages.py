"""The server's own pages: the index with its headers and its query, the state of health, and the page of a full room."""

from __future__ import annotations

import json
import re
from collections.abc import Callable

import pytest
import viser

from app.bench.blocking_client import BlockingClient
from app.web.index_page import QUESTION, ROOM_IS_FULL, full_page, page_query, patched_index
from app.web.request import request_query
from app.web.server import DuetServer
from tests.app.web.conftest import Room, get


def test_health(room: Room, join: Callable[..., BlockingClient]) -> None:
    join()
    status, headers, body = get(room.server.url + "/healthz")
    state = json.loads(body)
    assert (status, headers["content-type"]) == (200, "application/json")
    assert state["ok"] is True and state["clients"] == 1 and state["room"] is True and re.match(r"\d", state["version"])


def test_a_page_that_asks_is_answered_while_the_server_is_at_work(room: Room, join: Callable[..., BlockingClient]) -> None:
    visitor = join()
    before = visitor.received.frames
    for at_work in (True, False, True):
        asked: list[bool] = []
        room.server.is_at_work = lambda at_work=at_work, asked=asked: asked.append(at_work) or at_work
        visitor.send({"type": QUESTION})
        visitor.wait_for(lambda _, asked=asked: asked)
    visitor.wait_for(lambda v: v.received.frames >= before + 2)
    assert visitor.received.frames == before + 2 and visitor.closed is None


def test_pages_carry_the_headers(room: Room) -> None:
    for path in ("/", "/?dm=0.1", "/healthz"):
        status, headers, _ = get(room.server.url + path)
        assert status == 200
        assert headers["x-content-type-options"] == "nosniff" and headers["x-frame-options"] == "SAMEORIGIN"
        assert headers["referrer-policy"] == "no-referrer" and headers["cache-control"] in ("no-cache", "no-store")
    assert get(room.server.url + "/nothing")[0] == 404
    assert get(room.server.url + "/../../../etc/passwd")[0] == 404
    assert get(room.server.url + "/index.html?dm=1")[0] == 200


def test_index_is_patched_once_and_safely(room: Room) -> None:
    plain = get(room.server.url + "/")[2].decode()
    assert plain.count("duet-connection") > 1 and "<title>Duet</title>" in plain
    client = "<head><title>Viser</title><script>viser</script></head><body><p></p></body>"
    hostile = patched_index(client, title="</title><script>1</script>", run="</script>", body="<i>")
    assert "<script>1" not in hostile and hostile.count("</script>") == 2
    # What the body begins with is read before viser's program.
    assert hostile.endswith("</head><body><i><script>viser</script><p></p></body>")
    with pytest.raises(ValueError, match="title"):
        patched_index("<html></html>", title="Duet", run="")


@pytest.mark.parametrize(
    ("path", "query"),
    [
        ("/?dm=0.1&n=10", {"dm": "0.1", "n": "10"}),
        ("/", {}),
        ("?a=1", {"a": "1"}),
        ("/?a=1&a=2", {"a": "1"}),
        ("/?empty=", {"empty": ""}),
        ("/?x=%3Cscript%3E&y=a+b", {"x": "<script>", "y": "a b"}),
        ("/?" + "k" * 41 + "=1&ok=2", {"ok": "2"}),
        ("/?long=" + "v" * 401 + "&ok=2", {"ok": "2"}),
        ("/?" + "&".join(f"k{i}=1" for i in range(65)), {}),
        ("//evil.example/?a=1", {"a": "1"}),
    ],
)
def test_page_query(path: str, query: dict[str, str]) -> None:
    assert page_query(path) == query


def test_query_arrives_with_the_client(room: Room, join: Callable[..., BlockingClient]) -> None:
    arrived: dict[int, dict[str, str]] = {}

    @room.server.on_client_connect
    async def _(client: viser.ClientHandle) -> None:
        arrived[client.client_id] = request_query(client)

    join(query="dm=0.1&n=10").wait_for(lambda v: len(arrived) == 1)
    join().wait_for(lambda v: len(arrived) == 2)
    assert list(arrived.values()) == [{"dm": "0.1", "n": "10"}, {}]


def test_the_ninth_gets_the_friendly_page_and_later_a_place(start: Callable[..., DuetServer]) -> None:
    server = start(max_clients=8)
    eight = [BlockingClient(server.url) for _ in range(8)]
    try:
        eight[-1].wait_for(lambda v: server.count_clients() == 8)
        status, headers, body = get(server.url + "/?dm=0.1")
        assert status == 503 and headers["retry-after"] == "10" and "8 places" in body.decode()
        assert json.loads(get(server.url + "/healthz")[2])["room"] is False
        # Somebody whose page was loaded while there was room.
        late = BlockingClient(server.url)
        late.wait_for(lambda v: v.closed)
        assert late.closed is not None and late.closed.rcvd is not None
        assert (late.closed.rcvd.code, late.closed.rcvd.reason) == (1013, ROOM_IS_FULL)
        late.close()
        eight.pop().close()
        eight[0].wait_for(lambda v: server.count_clients() == 7)
        assert get(server.url + "/")[0] == 200
        eight.append(BlockingClient(server.url))
        eight[-1].wait_for(lambda v: v.mirror.replayed)
        assert eight[-1].closed is None
    finally:
        for visitor in eight:
            visitor.close()


def test_full_page_needs_nothing_from_elsewhere() -> None:
    page = full_page(8)
    assert "8 places" in page and "one place" in full_page(1)
    assert not re.search(r"(href|src)=.https?:|@import|url\(", page)
