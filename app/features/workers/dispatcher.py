"""The listening process, which hands connections over to workers. Imports nothing slow."""

import asyncio
import logging
import re
import signal
import socket
import time
from collections.abc import Callable
from time import monotonic
from typing import Any, Final

from app.features.workers.worker_group import WorkerGroup
from app.features.workers.worker_messages import WorkerStart
from app.settings import JOIN
from app.web.traffic_limits import BoundedQueue

log = logging.getLogger("duet.workers")

HEAD: Final = 8192
"""Most bytes of a head that are awaited."""

SLOW: Final = 10.0
"""Longest wait for the head [s]."""

GLANCE: Final = 0.05
"""Time between two reads of an incomplete head [s]."""

MOST_UNREAD, MOST_OF_ADDRESS, MOST_OF_TAB = 300, 150, 8
"""Most connections without a whole head: in all, per address and per tab; the oldest is dropped."""

_WORD: Final = {
    key: re.compile(rb"^[A-Z]+ [^ ]*[?&]" + key.encode() + rb"=([a-z0-9]{16,64})(?:[&# ]|$)")
    for key in ("resume", JOIN)
}
_REQUEST: Final = re.compile(rb"[A-Z-]+ [^ ]+ HTTP/1\.1\r?")
_END: Final = re.compile(rb"\n\r?\n")


def tab_of(line: bytes, key: str = "resume") -> str:
    """Id of the tab in a request's first line (with `JOIN`, the word of its link); "" without one."""
    found = _WORD[key].match(line)
    return found[1].decode() if found else ""


class Dispatcher:
    """Listens for a group of workers; arguments as in `WorkerGroup`."""

    def __init__(self, listener: socket.socket, start: WorkerStart, most: int) -> None:
        listener.setblocking(False)
        self._listener = listener
        self._unread = BoundedQueue["asyncio.Task[Any]"](MOST_UNREAD, MOST_OF_ADDRESS, MOST_OF_TAB)
        self._runner = asyncio.Runner()
        self._group = WorkerGroup(self._runner.get_loop(), start, most)

    def run(self, ready: Callable[[int], None]) -> None:
        """Serve until an exception, such as Ctrl+C; SIGUSR1 renews the workers.

        Args:
            ready: called with the number of places when the first worker serves.

        Raises:
            DuetError: the first worker cannot start.
        """
        loop = self._runner.get_loop()
        handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
        try:
            for number, handler in handlers.items():
                if callable(handler):
                    # Between two callbacks: an exception inside a task would be kept in the task, and logged.
                    loop.add_signal_handler(number, handler, number, None)
            self._runner.run(self._serve(ready))
        finally:
            for number, handler in handlers.items():
                if callable(handler):
                    loop.remove_signal_handler(number)
                    signal.signal(number, handler)

    def close(self, goes_on: bool = False) -> None:
        """Stop listening, and end the workers. `goes_on`: see `Stop`."""
        self._runner.get_loop().remove_reader(self._listener)
        self._runner.close()
        self._listener.close()
        # There is nothing to renew any more.
        signal.signal(signal.SIGUSR1, signal.SIG_IGN)
        self._group.close(goes_on)

    async def _serve(self, ready: Callable[[int], None]) -> None:
        loop = asyncio.get_running_loop()
        loop.add_signal_handler(signal.SIGUSR1, self._group.renew)
        loop.add_reader(self._listener, self._accept)
        ready(await self._group.places)
        await self._group.look_after()

    def _accept(self) -> None:
        try:
            connection, (address, *_) = self._listener.accept()
        except (BlockingIOError, ConnectionAbortedError):
            return
        except OSError as error:
            # Without a free descriptor this would be retried in a tight loop.
            log.warning("a connection cannot be accepted: %s", error)
            time.sleep(GLANCE)
            return
        connection.setblocking(False)
        self._enter(asyncio.get_running_loop().create_task(self._pass_on(connection, address)), address)

    def _enter(self, waiting: "asyncio.Task[Any]", address: str, tab: str = "") -> None:
        oldest = self._unread.enter(waiting, address, tab)
        if oldest is not None:
            oldest.cancel()

    async def _pass_on(self, connection: socket.socket, address: str) -> None:
        """Drops a slow connection, or one over a limit."""
        this = asyncio.current_task()
        assert this is not None
        try:
            async with asyncio.timeout(SLOW):
                await _readable(connection)
                line, whole = _begun(connection)
                while not whole:
                    self._enter(this, address, tab_of(line))
                    # It would be readable all the time.
                    await asyncio.sleep(GLANCE)
                    line, whole = _begun(connection)
        except (OSError, asyncio.CancelledError):
            connection.close()
            return
        finally:
            self._unread.leave(this)
        tab = tab_of(line)
        self._group.worker_of(tab, tab_of(line, JOIN)).take(connection, monotonic(), address, tab)


async def _readable(connection: socket.socket) -> None:
    loop, arrived = asyncio.get_running_loop(), asyncio.Event()
    loop.add_reader(connection, arrived.set)
    try:
        await arrived.wait()
    finally:
        loop.remove_reader(connection)


def _begun(connection: socket.socket) -> tuple[bytes, bool]:
    """First line, left unread, and True if the head is complete.

    Raises:
        OSError: the browser has gone.
    """
    found = connection.recv(HEAD, socket.MSG_PEEK)
    if not found:
        raise ConnectionAbortedError
    line, end, _ = found.partition(b"\n")
    # Data that are not a request have no head; the worker refuses them.
    return line, bool(_END.search(found) or (end and not _REQUEST.fullmatch(line)) or len(found) == HEAD)
