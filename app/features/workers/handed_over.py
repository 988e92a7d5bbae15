"""Connections handed over between processes."""

from __future__ import annotations

import asyncio
import errno
import socket
from typing import Any


class HandedOverListener(socket.socket):
    """Listening socket of a server whose connections another process accepts.

    Args:
        channel: descriptor of the Unix socket that delivers descriptors.
        address: at which the other process listens.
    """

    def __init__(self, channel: int, address: tuple[str, int]) -> None:
        super().__init__(fileno=channel)
        self._address = address

    def getsockname(self) -> tuple[str, int]:
        return self._address

    def listen(self, backlog: int = 0, /) -> None:
        """Do nothing: the other process listens."""

    def accept(self) -> tuple[socket.socket, Any]:
        """As `socket.accept`.

        Raises:
            BlockingIOError: no connection waits.
            ConnectionAbortedError: the browser has gone.
            OSError: this process has no free descriptor.
        """
        data, descriptors, _, _ = socket.recv_fds(self, 1, 1)
        if not data:
            # The other process has ended; otherwise the event loop would call this for ever.
            asyncio.get_running_loop().remove_reader(self.fileno())
            raise BlockingIOError
        if not descriptors:
            # The system keeps a connection for which this process has no free descriptor; asyncio pauses for
            # this error.
            raise OSError(errno.EMFILE, "no descriptor is free")
        connection = socket.socket(fileno=descriptors[0])
        try:
            return connection, connection.getpeername()
        except OSError as error:
            connection.close()
            raise ConnectionAbortedError from error


def hand_over(connection: socket.socket, channel: socket.socket) -> None:
    """Send a connection through a Unix socket, and close it here.

    Raises:
        OSError: the other process has ended.
    """
    with connection:
        socket.send_fds(channel, [b"c"], [connection.fileno()])
