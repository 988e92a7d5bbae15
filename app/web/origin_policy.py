"""Check of connecting web pages: `Origin` reveals a foreign page, `Host` a tricked name server."""

from __future__ import annotations

import ipaddress
import re
import socket
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from hmac import compare_digest
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from controllers.errors import BadSetting

if TYPE_CHECKING:
    from websockets.datastructures import Headers

LOOPBACK_NAMES = ("localhost", "127.0.0.1", "::1")
VOUCHED = "X-Forwarded-Context"
"""Header of jupyter-server-proxy, which has checked Origin; no web page can send it with a websocket's
request."""

PROOF = "X-Duet-Proof"
"""Secret of a notebook server, in requests that passed its login."""

_OF_PROXIES = re.compile("(x-)?forwarded|x-(real|client|cluster|original|proxy)|via|true-client|cf-")
_PORTS = {"http": 80, "https": 443}
_NAME = re.compile(r"[\w.:-]+", re.ASCII)


def _host_and_port(address: str, default_port: int | None) -> tuple[str, int | None] | None:
    """Split `host[:port]`, also `[::1]:80`; None for another text."""
    try:
        parts = urlsplit(f"//{address}")
        name, port = parts.hostname, parts.port
    except ValueError:
        return None
    if (
        not name
        or not _NAME.fullmatch(name)
        or parts.path
        or parts.query
        or parts.fragment
        or parts.username is not None
    ):
        return None
    return name, default_port if port is None else port


def _parse(origin: str) -> tuple[str, str, int | None] | None:
    """Scheme, name and port; None if it is not a web page's."""
    scheme, _, rest = origin.strip().lower().partition("://")
    address = _host_and_port(rest.removesuffix("/"), _PORTS[scheme]) if scheme in _PORTS else None
    return address and (scheme, *address)


def check_origin(address: str, what: str = "allowed origin") -> None:
    """Raises `BadSetting` unless the address is scheme, name, and perhaps a port. `what`: its name in the
    message."""
    if _parse(address) is not None:
        return
    parts = urlsplit(address) if address.startswith(("http://", "https://")) else None
    short = f"{parts.scheme}://{parts.netloc}" if parts is not None else ""
    if short and _parse(short) is not None:
        raise BadSetting(f"{what} {address!r} has a path; give {short}")
    raise BadSetting(f"{what} {address!r} is not a web address; valid: http://name:port or https://name")


def _may_name_us(name: str) -> bool:
    """True for a machine nearby, so that DNS rebinding cannot use the name."""
    if (
        name in LOOPBACK_NAMES
        or "." not in name
        or name.endswith(".local")
        or name == socket.gethostname().lower()
    ):
        return True
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def is_loopback(name: str) -> bool:
    return name in LOOPBACK_NAMES or name.startswith("127.")


def _is_here(peer: str) -> bool:
    return peer in ("", "::1") or peer.startswith(("127.", "::ffff:127."))


@dataclass(frozen=True)
class OriginPolicy:
    """Web pages that may connect to the server at `host`. `extra`: further origins, such as
    `https://duet.example.org` behind a proxy."""

    host: str
    port: int
    extra: tuple[str, ...] = ()

    @property
    def is_private(self) -> bool:
        return is_loopback(self.host)

    def remedy(self, origins: Sequence[str]) -> str:
        """Option that admits a refused page, or ""."""
        if len(origins) != 1 or _parse(origins[0]) is None:
            return ""
        return f"; if this is where Duet is opened, start it with --allow-origin {origins[0].strip()}"

    def is_local(self, peer: str, headers: Iterable[str]) -> bool:
        """True for a program on this computer; False for a proxy, whose clients share its address.
        `headers`: names."""
        return (
            _is_here(peer) and not self.extra and not any(_OF_PROXIES.match(name.lower()) for name in headers)
        )

    def is_owners(
        self, origins: Sequence[str], hosts: Sequence[str], peer: str, headers: Headers, proof: str
    ) -> bool:
        """True if the request comes from the person who started this server.

        Args:
            proof: value of `PROOF` from a notebook server; "" if only loopback names count.
        """
        if not (self.is_private and _is_here(peer)):
            return False
        if proof:
            given = headers.get_all(PROOF)
            return len(given) == 1 and compare_digest(given[0].encode(), proof.encode())
        pages = [origin[1:] if (origin := _parse(one)) else ("", None) for one in origins]
        asked = [_host_and_port(host.strip().lower(), None) or ("", None) for host in hosts]
        return self.is_local(peer, headers) and all(name in LOOPBACK_NAMES for name, _ in (*pages, *asked))

    def admits(self, origins: Sequence[str], hosts: Sequence[str], peer: str, vouched: bool = False) -> bool:
        """True if a websocket request is admitted.

        Args:
            origins: `Origin` headers; a browser sends one, a program usually none.
            vouched: True with the header `VOUCHED`.
        """
        if len(origins) > 1 or len(hosts) != 1:
            return False
        here = _is_here(peer)
        if not origins:
            return here
        if vouched and here:
            return True
        origin = _parse(origins[0])
        if origin is None:
            return False
        if origin in map(_parse, self.extra):
            return True
        page, asked = origin[1:], _host_and_port(hosts[0].strip().lower(), _PORTS[origin[0]])
        if asked is None:
            return False
        # A loopback server addressed by another name is the target of DNS rebinding.
        if self.is_private and not (asked[0] in LOOPBACK_NAMES or asked[0] == self.host):
            return False
        if page[1] == self.port and (page[0] in LOOPBACK_NAMES or page[0] == self.host):
            return True
        # Same origin: also behind an ssh tunnel or a forwarded port, where the address bar shows another port
        # than ours.
        return page == asked and _may_name_us(page[0])
