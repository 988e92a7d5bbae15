"""The process that listens: it looks at the head of every request, and hands the connection to the worker that has the tab.

What goes over a connection never passes here. Imports nothing slow, so that a single visitor pays nothing for it.
"""

import logging
import re
import selectors
import signal
import socket
import time
from collections.abc import Callable
from contextlib import suppress
from time import monotonic
from typing import Final, NamedTuple

from app.hosting.worker_group import WorkerGroup
from app.hosting.worker_messages import WorkerStart
from app.web.traffic_limits import BoundedQueue

log = logging.getLogger("duet.workers")

HEAD: Final = 8192
"""What is read of a request to find the end of its head [bytes]; the worker gets a longer one as it is."""

SLOW: Final = 10.0
"""Time in which the head has to arrive [s]."""

GLANCE: Final = 0.05
"""Time between two looks at a head that has arrived in part [s]."""

MOST_UNREAD, MOST_OF_ADDRESS, MOST_OF_TAB = 300, 150, 8
"""Connections at once without a whole head: in all, from one address, and of one tab; the oldest makes room."""

_WORD: Final = {
    key: re.compile(rb"^[A-Z]+ [^ ]*[?&]" + key.encode() + rb"=([a-z0-9]{16,64})(?:[&# ]|$)") for key in ("resume", "guest")
}
_REQUEST: Final = re.compile(rb"[A-Z-]+ [^ ]+ HTTP/1\.1\r?")
_END: Final = re.compile(rb"\n\r?\n")


def tab_of(line: bytes, key: str = "resume") -> str:
    """Return the id of the tab in the first line of a request, or, with the key "guest", the word of an invitation; "" for none."""
    found = _WORD[key].match(line)
    return found[1].decode() if found else ""


class _Unread(NamedTuple):
    """A connection without a whole head: where it comes from, when it is dropped, and when it is looked at again, 0 for at an event [s]."""

    address: str
    end: float
    look: float = 0.0


class Dispatcher:
    """Listens for a group of workers.

    Args:
        listener: a socket that listens.
        start: what every worker serves.
        most: see `WorkerGroup`.
    """

    def __init__(self, listener: socket.socket, start: WorkerStart, most: int) -> None:
        self._listener = listener
        self._selector = selectors.DefaultSelector()
        self._unread: dict[socket.socket, _Unread] = {}
        self._unread_queue = BoundedQueue[socket.socket](MOST_UNREAD, MOST_OF_ADDRESS, MOST_OF_TAB)
        self._bell, self._ringing = socket.socketpair()
        for end in (listener, self._bell, self._ringing):
            end.setblocking(False)
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
            times = [unread.look or unread.end for unread in self._unread.values()]
            for key, _ in self._selector.select(max(min([self._group.next_due, *times]) - monotonic(), 0.0)):
                key.data()
            if not announced and self._group.places:
                announced = True
                ready(self._group.places)
            self._group.look_after(monotonic())
            self._look_again(monotonic())

    def renew(self) -> None:
        """Ask for all workers to be replaced, one after the other; may be called in a signal's handler."""
        with suppress(OSError):
            self._ringing.send(b"r")

    def close(self, goes_on: bool = False) -> None:
        """Stop to listen, and end the workers when they have saved everything. `goes_on`: see `Stop`."""
        for end in (self._listener, self._bell, self._ringing, *self._unread):
            end.close()
        self._group.close(goes_on)
        self._selector.close()

    def _renew(self) -> None:
        self._bell.recv(HEAD)
        self._group.renew()

    def _accept(self) -> None:
        try:
            connection, (address, *_) = self._listener.accept()
        except (BlockingIOError, ConnectionAbortedError):
            return
        except OSError as error:
            # Without a free descriptor this would be tried again at once, and again.
            log.warning("a connection cannot be accepted: %s", error)
            time.sleep(GLANCE)
            return
        connection.setblocking(False)
        self._unread[connection] = _Unread(address, monotonic() + SLOW)
        self._selector.register(connection, selectors.EVENT_READ, lambda: self._read(connection))
        self._enter(connection)

    def _enter(self, connection: socket.socket, tab: str = "") -> None:
        oldest = self._unread_queue.enter(connection, self._unread[connection].address, tab)
        if oldest is not None:
            self._drop(oldest)

    def _read(self, connection: socket.socket) -> None:
        """Look at what has arrived, which stays to be read by the worker."""
        if connection not in self._unread:
            # It has made room in this very round.
            return
        try:
            found = connection.recv(HEAD, socket.MSG_PEEK)
        except BlockingIOError:
            return
        except OSError:
            found = b""
        if not found:
            self._drop(connection)
            return
        line, end, _ = found.partition(b"\n")
        tab = tab_of(line)
        self._forget(connection)
        # What is no request has no head; the worker refuses it.
        if not (_END.search(found) or (end and not _REQUEST.fullmatch(line)) or len(found) == HEAD):
            # It would be readable all the time.
            self._unread[connection] = self._unread[connection]._replace(look=monotonic() + GLANCE)
            self._enter(connection, tab)
            return
        address = self._unread.pop(connection).address
        self._unread_queue.leave(connection)
        self._group.worker_of(tab, tab_of(line, "guest")).take(connection, monotonic(), address, tab)

    def _forget(self, connection: socket.socket) -> None:
        with suppress(KeyError):
            self._selector.unregister(connection)

    def _drop(self, connection: socket.socket) -> None:
        self._forget(connection)
        self._unread_queue.leave(connection)
        del self._unread[connection]
        connection.close()

    def _look_again(self, now: float) -> None:
        """Look again at requests that have arrived in part, and drop those that are too slow."""
        for connection, unread in list(self._unread.items()):
            if unread.end <= now:
                self._drop(connection)
            elif 0.0 < unread.look <= now:
                self._read(connection)
