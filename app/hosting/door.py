"""The process that listens: it looks at the first line of every request, and hands the connection to the worker that has the tab.

What goes over a connection never passes here. Imports nothing slow, so that a single visitor pays nothing for it.
"""

import logging
import re
import selectors
import signal
import socket
import time
from collections import OrderedDict
from collections.abc import Callable
from contextlib import suppress
from time import monotonic
from typing import Final

from app.hosting.worker_group import WorkerGroup
from app.hosting.worker_process import WorkerStart

log = logging.getLogger("duet.workers")

LINE: Final = 8192
"""What is read of a request to find its first line [bytes]."""

SLOW: Final = 10.0
"""Time in which the first line has to arrive [s]."""

GLANCE: Final = 0.05
"""Time between two looks at a first line that has arrived in part [s]."""

MOST_UNREAD: Final = 300
"""Connections at once without a first line; the oldest makes room."""

_TAB: Final = re.compile(rb"^[A-Z]+ [^ ]*[?&]resume=([a-z0-9]{16,64})(?:[&# ]|$)")


def tab_of(line: bytes) -> str:
    """Return the id of the tab in the first line of a request; "" for none."""
    found = _TAB.match(line)
    return found[1].decode() if found else ""


class Door:
    """Listens for a group of workers.

    Args:
        listener: a socket that listens.
        start: what every worker serves.
        most: see `WorkerGroup`.
    """

    def __init__(self, listener: socket.socket, start: WorkerStart, most: int) -> None:
        self._listener = listener
        self._selector = selectors.DefaultSelector()
        self._unread: OrderedDict[socket.socket, tuple[float, float]] = OrderedDict()
        self._bell, ringing = socket.socketpair()
        for end in (listener, self._bell, ringing):
            end.setblocking(False)
        self._ringing = ringing
        self._selector.register(self._bell, selectors.EVENT_READ, self._renew)
        self._selector.register(listener, selectors.EVENT_READ, self._accept)
        self._group = WorkerGroup(self._selector, start, most)

    def run(self, ready: Callable[[int], None]) -> None:
        """Serve until an exception, such as Ctrl+C; renew the workers at every SIGUSR1.

        Args:
            ready: called once, when the first worker serves, with the number of places.

        Raises:
            DuetError: the first worker cannot start.
        """
        signal.signal(signal.SIGUSR1, lambda number, frame: self.renew())
        announced = False
        while True:
            for key, _ in self._selector.select(self._wait()):
                key.data()
            if not announced and self._group.is_serving:
                announced = True
                ready(self._group.places)
            self._group.look_after(monotonic())
            self._look_again(monotonic())

    def renew(self) -> None:
        """Have all workers replaced, one after the other; from a signal's handler."""
        with suppress(OSError):
            self._ringing.send(b"r")

    def close(self, goes_on: bool = False) -> None:
        """Stop to listen, and end the workers when they have saved everything. `goes_on`: see `Stop`."""
        for end in (self._listener, self._bell, self._ringing, *self._unread):
            end.close()
        self._group.close(goes_on)
        self._selector.close()

    def _renew(self) -> None:
        self._bell.recv(LINE)
        self._group.renew()

    def _accept(self) -> None:
        try:
            connection, _ = self._listener.accept()
        except (BlockingIOError, ConnectionAbortedError):
            return
        except OSError as error:
            # Without a free descriptor this would be tried again at once, and again.
            log.warning("a connection cannot be accepted: %s", error)
            time.sleep(GLANCE)
            return
        connection.setblocking(False)
        if len(self._unread) >= MOST_UNREAD:
            self._drop(next(iter(self._unread)))
        self._unread[connection] = monotonic() + SLOW, 0.0
        self._selector.register(connection, selectors.EVENT_READ, lambda: self._read(connection))

    def _read(self, connection: socket.socket) -> None:
        """Look at what has arrived, which stays to be read by the worker."""
        if connection not in self._unread:
            # It has made room in this very round.
            return
        try:
            found = connection.recv(LINE, socket.MSG_PEEK)
        except BlockingIOError:
            return
        except OSError:
            found = b""
        if not found:
            self._drop(connection)
            return
        line, end, _ = found.partition(b"\n")
        self._forget(connection)
        if not end and len(found) < LINE:
            # It would be readable all the time.
            self._unread[connection] = self._unread[connection][0], monotonic() + GLANCE
            return
        del self._unread[connection]
        tab = tab_of(line)
        self._group.worker_of(tab).take(connection, monotonic(), stays=bool(tab))

    def _forget(self, connection: socket.socket) -> None:
        with suppress(KeyError):
            self._selector.unregister(connection)

    def _drop(self, connection: socket.socket) -> None:
        self._forget(connection)
        del self._unread[connection]
        connection.close()

    def _look_again(self, now: float) -> None:
        """Look again at requests that have arrived in part, and drop those that are too slow."""
        for connection, (end, look) in list(self._unread.items()):
            if end <= now:
                self._drop(connection)
            elif 0.0 < look <= now:
                self._read(connection)

    def _wait(self) -> float:
        """Return how long to wait for an event [s]."""
        times = [look or end for end, look in self._unread.values()]
        return max(min([self._group.next_due, *times]) - monotonic(), 0.0)
