"""Connections that one process accepts and hands over to another."""

from __future__ import annotations

import asyncio
import errno
import socket
from typing import Any


class HandedOverListener(socket.socket):
    """Replacement of the listening socket in a server that does not accept connections itself.

    Args:
        channel: descriptor of the Unix socket that delivers the connections' descriptors.
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
            BlockingIOError: no connection waits now.
            ConnectionAbortedError: the browser has gone meanwhile.
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
    """Give a connection to the process at the other end of a Unix socket, and close it here.

    Raises:
        OSError: the other process has ended.
    """
    with connection:
        socket.send_fds(channel, [b"c"], [connection.fileno()])
