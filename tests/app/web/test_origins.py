"""Pages and programs that the locked-down server admits."""

import pytest
import websockets
from websockets.datastructures import Headers

from app.web.origin_policy import PROOF, VOUCHED, OriginPolicy, check_origin
from controllers.errors import BadSetting
from tests.app.web.conftest import Room
from tests.blocking_client import BlockingClient

LISTED = "https://lab.example.org"
ORIGINS: list[tuple[str, str, list[str | None], list[str | None]]] = [
    # bound address, Host, admitted origins, refused origins
    (
        "127.0.0.1",
        "127.0.0.1:8080",
        [None, "http://127.0.0.1:8080", "https://localhost:8080", LISTED, "https://LAB.example.org:443"],
        [
            *(
                "http://lab.example.org",
                f"{LISTED}:8443",
                f"{LISTED}/duet",
                "https://evil.example",
                "http://localhost:3000",
                "",
            ),
            *(
                "http://localhost",
                "null",
                "file://",
                "http://127.0.0.1:8080.evil.example",
                "http://127.0.0.1:8080@evil.example",
            ),
            "http://evil.example#127.0.0.1:8080",
        ],
    ),
    ("127.0.0.1", "localhost:8080", ["http://localhost:8080"], []),
    ("127.0.0.1", "[::1]:8080", ["http://[::1]:8080"], []),
    ("127.0.0.1", "LOCALHOST:8080", ["http://LocalHost:8080"], []),
    ("127.0.0.1", "localhost:9000", ["http://localhost:9000"], []),  # ssh -L 9000:localhost:8080
    ("127.0.0.1", "upstream", [LISTED], []),  # a proxy that writes another Host
    (
        "127.0.0.1",
        "evil.example:8080",
        [],
        ["http://evil.example:8080", "http://127.0.0.1:8080"],
    ),  # DNS rebinding
    ("0.0.0.0", "192.168.1.5:8080", ["http://192.168.1.5:8080"], ["http://evil.example"]),
    ("0.0.0.0", "lab-pc-7:8080", ["http://lab-pc-7:8080"], []),
    ("0.0.0.0", "lab-pc.local:8080", ["http://lab-pc.local:8080"], []),
    ("0.0.0.0", "localhost:8080", ["http://localhost:8080"], []),
    ("0.0.0.0", "evil.example:8080", [], ["http://evil.example:8080"]),
    ("192.168.1.5", "192.168.1.5:8080", ["http://192.168.1.5:8080"], ["http://192.168.1.6:8080"]),
]


@pytest.mark.parametrize(("bound", "host", "admitted", "refused"), ORIGINS)
def test_origin_rules(bound: str, host: str, admitted: list[str | None], refused: list[str | None]) -> None:
    policy = OriginPolicy(bound, 8080, (LISTED,))
    taken = [o for o in (*admitted, *refused) if policy.admits([] if o is None else [o], [host], "127.0.0.1")]
    assert taken == admitted


NO_ADDRESS = (
    "duet.example.org",
    "ftp://duet.example.org",
    "https://",
    "https://me@duet.example.org",
    "https://a.org:port/lab",
    "*",
)


@pytest.mark.parametrize(
    ("address", "remedy"),
    [
        ("https://duet.example.org/lab", "has a path; give https://duet.example.org$"),
        ("https://duet.example.org:8443/lab/?n=1", "give https://duet.example.org:8443$"),
        ("https://duet.example.org?n=1", "give https://duet.example.org$"),
        *((address, "not a web address; valid: http://name:port or https://name$") for address in NO_ADDRESS),
    ],
)
def test_a_bad_origin_is_an_error_that_names_a_valid_one(address: str, remedy: str) -> None:
    for origin in ("https://duet.example.org", "http://duet.example.org:8443/", "http://[::1]:80"):
        check_origin(origin)
    with pytest.raises(BadSetting, match=remedy):
        check_origin(address)


def test_a_program_without_origin_is_admitted_only_locally() -> None:
    policy = OriginPolicy("0.0.0.0", 8080)
    assert policy.admits([], ["192.168.1.5:8080"], "127.0.0.1")
    assert not policy.admits([], ["192.168.1.5:8080"], "192.168.1.77")
    assert not policy.admits(["http://localhost:8080"] * 2, ["localhost:8080"], "127.0.0.1")
    assert not policy.admits(["http://localhost:8080"], [], "127.0.0.1")


def test_pages_vouched_for_by_jupyter_are_admitted_only_locally() -> None:
    policy, hub = OriginPolicy("0.0.0.0", 8080, (LISTED,)), "hub.example.org"
    assert policy.admits([f"https://{hub}"], [hub], "127.0.0.1", vouched=True)
    assert not policy.admits([f"https://{hub}"], [hub], "127.0.0.1")
    assert not policy.admits([f"https://{hub}"], [hub], "192.168.1.77", vouched=True)
    assert policy.admits([LISTED], [hub], "192.168.1.77", vouched=True)


PROXIED = (
    "X-Forwarded-For",
    "x-forwarded-context",
    "Forwarded",
    "X-Real-IP",
    "Via",
    "CF-Connecting-IP",
    "True-Client-IP",
)
HERE = ["127.0.0.1:8080"]


def test_the_owner_is_local_and_not_behind_a_proxy() -> None:
    here, none = OriginPolicy("127.0.0.1", 8080), Headers()
    for origins, hosts in (
        ([], HERE),
        (["http://127.0.0.1:8080"], HERE),
        (["http://localhost:9000"], ["localhost:9000"]),
    ):
        assert here.is_owners(origins, hosts, "127.0.0.1", none, "")
    for name in PROXIED:
        assert not here.is_owners([], HERE, "127.0.0.1", Headers({name: "127.0.0.1"}), "")
    for origin in ("https://duet.example.org", "http://localhost.evil.example", "null", ""):
        assert not here.is_owners([origin], HERE, "127.0.0.1", none, "")
    assert not here.is_owners([], ["duet.example.org"], "127.0.0.1", none, "")
    assert not here.is_owners([], HERE, "192.168.1.77", none, "")
    assert not OriginPolicy("127.0.0.1", 8080, (LISTED,)).is_owners([], HERE, "127.0.0.1", none, "")
    assert not OriginPolicy("0.0.0.0", 8080).is_owners([], HERE, "127.0.0.1", none, "")


def test_behind_a_notebook_server_only_the_owner_has_the_proof() -> None:
    here, hub = OriginPolicy("127.0.0.1", 8080), (["https://hub.example.org"], ["hub.example.org"])
    forwarded = {"X-Forwarded-For": "203.0.113.5", VOUCHED: "/user/ann/"}
    assert here.is_owners(*hub, "127.0.0.1", Headers({**forwarded, PROOF: "secret"}), "secret")
    twice = Headers(forwarded)
    twice[PROOF], twice[PROOF] = "wrong", "secret"
    for headers in (
        Headers(forwarded),
        Headers({**forwarded, PROOF: "wrong"}),
        Headers({**forwarded, PROOF: ""}),
        twice,
    ):
        assert not here.is_owners(*hub, "127.0.0.1", headers, "secret")
    assert not here.is_owners([], HERE, "127.0.0.1", Headers(), "secret")
    assert not here.is_owners(*hub, "192.168.1.77", Headers({PROOF: "secret"}), "secret")


def test_the_origin_is_checked_at_connection(room: Room) -> None:
    for origin in (None, f"http://localhost:{room.server.get_port()}"):
        with BlockingClient(room.server.url, origin) as visitor:
            visitor.wait_for(lambda v: v.mirror.replayed)
            visitor.wait_for(lambda v: room.server.count_clients() == 1)
    for origin in ("https://evil.example", "null"):
        with pytest.raises(websockets.InvalidStatus) as refusal:
            BlockingClient(room.server.url, origin)
        assert refusal.value.response.status_code == 403 and b"--allow-origin" in refusal.value.response.body
