"""The page's address, also as a QR code."""

import html
import io
import socket
from functools import lru_cache
from typing import NamedTuple
from urllib.parse import urlsplit

import segno
import viser
from markupsafe import Markup

from app.theme import PALETTES
from app.web.listening import url_of
from app.web.origin_policy import is_loopback
from app.web.request import request_address
from app.web.viser_internals import server_of


class Address(NamedTuple):
    """`private`: True if only this computer can open it."""

    url: str
    private: bool

    @property
    def short(self) -> str:
        return self.url.removeprefix("http://")


def find_address(origin: str, listening: str, port: int) -> Address:
    """Address for the students.

    Args:
        origin: of the teacher's page, with a proxy's folder; "" if unknown.
        listening, port: to which the server is bound.
    """
    name = _name(origin)
    if name and not is_loopback(name):
        return Address(origin.rstrip("/") + "/", False)
    host = (
        own_address()
        if listening in ("", "0.0.0.0", "::")
        else "localhost"
        if listening == "::1"
        else listening
    )
    return Address(f"{url_of(host, port)}/", is_loopback(host))


def address_known_to(client: viser.ClientHandle) -> Address:
    """Address for others, from a browser with the page; a private one as that browser knows it."""
    server, origin = server_of(client), request_address(client)
    address = find_address(origin, server.get_host(), server.get_port())
    return address._replace(url=f"{origin}/") if address.private else address


def own_address() -> str:
    """This computer's address in its network; 127.0.0.1 without one. Sends no packet."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            # Choosing a route needs no packet; the address is reserved for documentation (RFC 5737).
            probe.connect(("192.0.2.1", 9))
            return str(probe.getsockname()[0])
        except OSError:
            return "127.0.0.1"


@lru_cache(maxsize=8)
def qr_svg(text: str, label: str = "QR code of the address") -> Markup:
    """SVG without a size, with the quiet zone that cameras need."""
    out = io.BytesIO()
    # Error correction M, as a projector blurs.
    segno.make(text, error="m", micro=False).save(
        out,
        kind="svg",
        border=4,
        dark=PALETTES["light"].ink,
        light="white",
        omitsize=True,
        xmldecl=False,
        svgns=True,
        nl=False,
    )
    return Markup(
        out.getvalue().decode().replace("<svg ", f'<svg role="img" aria-label="{html.escape(label)}" ', 1)
    )


def _name(origin: str) -> str:
    try:
        parts = urlsplit(origin)
    except ValueError:
        return ""
    return (parts.hostname or "") if parts.scheme in ("http", "https") else ""
