"""Connections that one process accepts and hands over to another one."""

from __future__ import annotations

import asyncio
import errno
import socket
from typing import Any


class HandedOverListener(socket.socket):
    """Stands in for a listening socket in a server that does not accept connections itself.

    Args:
        channel: descriptor of the Unix socket from which the connections' descriptors are read.
        address: at which the other process listens.
    """

    def __init__(self, channel: int, address: tuple[str, int]) -> None:
        super().__init__(fileno=channel)
        self._address = address

    def getsockname(self) -> tuple[str, int]:
        """Return the address at which browsers connect."""
        return self._address

    def listen(self, backlog: int = 0, /) -> None:
        """Do nothing: the other process listens."""

    def accept(self) -> tuple[socket.socket, Any]:
        """Return the next connection and where it comes from, as `socket.accept` does.

        Raises:
            BlockingIOError: no connection waits now.
            ConnectionAbortedError: the browser has gone meanwhile.
            OSError: this process has no free descriptor.
        """
        data, descriptors, _, _ = socket.recv_fds(self, 1, 1)
        if not data:
            # The other process has ended; the event loop would be called for this without end.
            asyncio.get_running_loop().remove_reader(self.fileno())
            raise BlockingIOError
        if not descriptors:
            # The system keeps what this process has no free descriptor for; asyncio pauses for this error.
            raise OSError(errno.EMFILE, "no descriptor is free")
        connection = socket.socket(fileno=descriptors[0])
        try:
            return connection, connection.getpeername()
        except OSError as error:
            connection.close()
            raise ConnectionAbortedError from error


def hand_over(connection: socket.socket, channel: socket.socket) -> None:
    """Give a connection to the process at the other end of a Unix socket, and let go of it.

    Raises:
        OSError: the other process has ended.
    """
    with connection:
        socket.send_fds(channel, [b"c"], [connection.fileno()])
