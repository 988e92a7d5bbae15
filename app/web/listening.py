"""The listening socket, bound before viser starts, so that a failure can be reported."""

from __future__ import annotations

import contextlib
import errno
import socket
import sys
from typing import Final

from controllers.errors import BadSetting, DuetError

MOST_TRIED: Final = 20


class PortInUse(DuetError):
    """The port is taken; the message names another one."""


def port_answers(host: str, port: int) -> bool:
    with contextlib.suppress(OSError), socket.create_connection((host, port), timeout=0.25):
        return True
    return False


def listen(host: str, port: int) -> socket.socket:
    """Listening socket.

    Raises:
        PortInUse: another program has the port.
        BadSetting: unusable host or port.
    """
    if not isinstance(port, int) or not 0 <= port <= 65535:
        raise BadSetting(f"port {port!r} is out of range; valid: 1 to 65535, or 0 for any free one")
    in_use = PortInUse(
        f"port {port} on {host} is already in use, perhaps by another Duet; choose another one: --port {port % 65535 + 1}"
    )
    try:
        family, _, _, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
    except (OSError, UnicodeError) as error:
        raise BadSetting(
            f"host {host!r} is unknown; valid: 127.0.0.1, 0.0.0.0 or an address of this computer"
        ) from error
    # macOS lets a second program take the loopback side of a port that is held for all addresses.
    if (
        port
        and sys.platform == "darwin"
        and port_answers("127.0.0.1" if host in ("0.0.0.0", "::", "") else host, port)
    ):
        raise in_use
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        if sys.platform == "win32":
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
        else:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        # A listener is what makes Linux refuse the next bind on this port.
        listener.listen(128)
    except OSError as error:
        listener.close()
        # Windows names a port that is held exclusively by its own number, as a lack of permission.
        if error.errno == errno.EADDRINUSE or getattr(error, "winerror", None) in (10013, 10048):
            raise in_use from error
        if isinstance(error, PermissionError):
            raise BadSetting(
                f"port {port} needs administrator rights; choose one from 1024 on: --port 8080"
            ) from error
        raise BadSetting(
            f"host {host!r} is not an address of this computer; valid: 127.0.0.1, 0.0.0.0 or an address of its own"
        ) from error
    return listener


def listen_near(host: str, first: int) -> socket.socket:
    """Listening socket on the first free port from `first` on.

    Raises:
        PortInUse: all `MOST_TRIED` ports are taken.
        BadSetting: unusable host.
    """
    for port in range(first, first + MOST_TRIED - 1):
        with contextlib.suppress(PortInUse):
            return listen(host, port)
    return listen(host, first + MOST_TRIED - 1)


def url_of(host: str, port: int) -> str:
    name = "localhost" if host in ("0.0.0.0", "::", "") else f"[{host}]" if ":" in host else host
    return f"http://{name}:{port}"
