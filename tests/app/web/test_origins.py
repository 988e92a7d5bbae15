"""Who may connect: which pages' and which programs' connections the locked-down server takes."""

import pytest
import websockets

from app.bench.blocking_client import BlockingClient
from app.web.origin_policy import OriginPolicy, check_origin
from controllers.errors import BadSetting
from tests.app.web.conftest import Room

ORIGINS = [
    # bound to, Host, Origin, admitted; {} stands for the port
    ("127.0.0.1", "127.0.0.1:{}", "http://127.0.0.1:{}", True),
    ("127.0.0.1", "localhost:{}", "http://localhost:{}", True),
    ("127.0.0.1", "[::1]:{}", "http://[::1]:{}", True),
    ("127.0.0.1", "127.0.0.1:{}", "https://localhost:{}", True),
    ("127.0.0.1", "LOCALHOST:{}", "http://LocalHost:{}", True),
    ("127.0.0.1", "localhost:9000", "http://localhost:9000", True),  # ssh -L 9000:localhost:8080
    ("127.0.0.1", "127.0.0.1:{}", None, True),
    ("127.0.0.1", "127.0.0.1:{}", "https://lab.example.org", True),  # listed explicitly
    ("127.0.0.1", "upstream", "https://lab.example.org", True),  # a proxy that writes another Host
    ("127.0.0.1", "127.0.0.1:{}", "https://LAB.example.org:443", True),
    ("127.0.0.1", "127.0.0.1:{}", "http://lab.example.org", False),
    ("127.0.0.1", "127.0.0.1:{}", "https://lab.example.org:8443", False),
    ("127.0.0.1", "127.0.0.1:{}", "https://lab.example.org/duet", False),
    ("127.0.0.1", "127.0.0.1:{}", "https://evil.example", False),
    ("127.0.0.1", "127.0.0.1:{}", "http://localhost:3000", False),
    ("127.0.0.1", "127.0.0.1:{}", "http://localhost", False),
    ("127.0.0.1", "127.0.0.1:{}", "null", False),
    ("127.0.0.1", "127.0.0.1:{}", "", False),
    ("127.0.0.1", "127.0.0.1:{}", "file://", False),
    ("127.0.0.1", "127.0.0.1:{}", "http://127.0.0.1:{}.evil.example", False),
    ("127.0.0.1", "127.0.0.1:{}", "http://127.0.0.1:{}@evil.example", False),
    ("127.0.0.1", "127.0.0.1:{}", "http://evil.example#127.0.0.1:{}", False),
    ("127.0.0.1", "evil.example:{}", "http://evil.example:{}", False),  # DNS rebinding
    ("127.0.0.1", "evil.example:{}", "http://127.0.0.1:{}", False),
    ("0.0.0.0", "192.168.1.5:{}", "http://192.168.1.5:{}", True),
    ("0.0.0.0", "lab-pc-7:{}", "http://lab-pc-7:{}", True),
    ("0.0.0.0", "lab-pc.local:{}", "http://lab-pc.local:{}", True),
    ("0.0.0.0", "localhost:{}", "http://localhost:{}", True),
    ("0.0.0.0", "192.168.1.5:{}", "http://evil.example", False),
    ("0.0.0.0", "evil.example:{}", "http://evil.example:{}", False),  # DNS rebinding on the network
    ("192.168.1.5", "192.168.1.5:{}", "http://192.168.1.5:{}", True),
    ("192.168.1.5", "192.168.1.5:{}", "http://192.168.1.6:{}", False),
]


@pytest.mark.parametrize(("bound", "host", "origin", "admitted"), ORIGINS)
def test_origin_rules(bound: str, host: str, origin: str | None, admitted: bool) -> None:
    policy = OriginPolicy(bound, 8080, ("https://lab.example.org",))
    origins = [] if origin is None else [origin.replace("{}", "8080")]
    assert policy.admits(origins, [host.replace("{}", "8080")], "127.0.0.1") is admitted


@pytest.mark.parametrize(
    ("address", "remedy"),
    [
        ("https://duet.example.org/lab", "has a path; give https://duet.example.org$"),
        ("https://duet.example.org:8443/lab/?n=1", "give https://duet.example.org:8443$"),
        ("https://duet.example.org?n=1", "give https://duet.example.org$"),
        ("duet.example.org", "not a web address; valid: http://name:port or https://name$"),
        ("ftp://duet.example.org", "not a web address"),
        ("https://", "not a web address"),
        ("https://me@duet.example.org", "not a web address"),
        ("https://duet.example.org:port/lab", "not a web address"),
        ("*", "not a web address"),
    ],
)
def test_what_is_no_origin_is_an_error_that_names_one(address: str, remedy: str) -> None:
    for origin in ("https://duet.example.org", "http://duet.example.org:8443/", "http://[::1]:80"):
        check_origin(origin)
    with pytest.raises(BadSetting, match=remedy):
        check_origin(address)


def test_a_program_without_origin_is_let_in_from_this_computer_only() -> None:
    policy = OriginPolicy("0.0.0.0", 8080)
    assert policy.admits([], ["192.168.1.5:8080"], "127.0.0.1")
    assert not policy.admits([], ["192.168.1.5:8080"], "192.168.1.77")
    assert not policy.admits(["http://localhost:8080"] * 2, ["localhost:8080"], "127.0.0.1")
    assert not policy.admits(["http://localhost:8080"], [], "127.0.0.1")


@pytest.mark.parametrize(
    ("origin", "admitted"), [(None, True), ("http://localhost:{}", True), ("https://evil.example", False), ("null", False)]
)
def test_origin_is_asked_at_the_door(room: Room, origin: str | None, admitted: bool) -> None:
    asked = None if origin is None else origin.replace("{}", str(room.server.get_port()))
    if admitted:
        with BlockingClient(room.server.url, asked) as visitor:
            visitor.wait_for(lambda v: v.mirror.replayed)
            return
    with pytest.raises(websockets.InvalidStatus) as refusal:
        BlockingClient(room.server.url, asked)
    assert refusal.value.response.status_code == 403
    assert b"--allow-origin" in refusal.value.response.body
    assert room.server.count_clients() == 0
