"""A worker process. Imports nothing slow."""

import contextlib
import socket
import subprocess
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any, Final

from app.features.workers.handed_over import hand_over
from app.features.workers.worker_messages import ClientCount, WorkerStart
from app.web.traffic_limits import BoundedQueue, remember
from controllers.own_packages import own_command

LATELY: Final = 3.0
"""Time for which a handed-over tab counts as a browser [s]."""

MOST_WAITING, MOST_OF_ADDRESS, MOST_OF_TAB = 300, 200, 8
"""Most waiting connections: in all, per address and per tab; the oldest is dropped."""


class WorkerProcess:
    """A running worker. `now`: time [s].

    Raises:
        OSError: no process can be started.

    Attributes:
        ready: it serves.
        has_served: it lives and has something to save.
        has_started: it could serve.
        report: its load; () before the first report.
        silent: consecutive checks without a sign of work.
        waiting: connections until it is ready.
    """

    def __init__(self, start: WorkerStart, now: float) -> None:
        with contextlib.ExitStack() as opened:
            channel, theirs = map(opened.enter_context, socket.socketpair())
            control, other = map(opened.enter_context, Pipe())
            numbers = theirs.fileno(), other.fileno()
            # In its own process group: Ctrl+C in the terminal is for the dispatcher.
            command = own_command("app.features.workers.serve_worker", *map(str, numbers))
            self.process = subprocess.Popen(
                command, pass_fds=numbers, stdin=subprocess.DEVNULL, process_group=0
            )
            theirs.close()
            other.close()
            opened.pop_all()
        # A worker that hangs must not hold up the dispatcher.
        channel.setblocking(False)
        self._channel = channel
        self.control: Connection[Any, Any] = control
        self.ready = self.has_served = self.has_started = False
        self.began, self.clients, self.silent, self._others = now, 0, 0, 0
        self.report: tuple[int, ...] = ()
        self.waiting = BoundedQueue[socket.socket](MOST_WAITING, MOST_OF_ADDRESS, MOST_OF_TAB)
        self._lately: dict[str, float] = {}
        self.send(start)

    def load(self, now: float) -> int:
        """Browsers that it has, or soon will have."""
        self._lately = {tab: since for tab, since in self._lately.items() if now - since <= LATELY}
        return max(self.clients, len(self._lately)) + len(self.waiting)

    def take(self, connection: socket.socket, now: float, address: str, tab: str) -> None:
        """Hand over a connection once the worker is ready. `tab`: "" if it has no websocket."""
        if tab:
            remember(self._lately, tab, now, MOST_WAITING)
        if self.ready:
            self._hand_over(connection)
        elif (oldest := self.waiting.enter(connection, address, tab)) is not None:
            oldest.close()

    def _hand_over(self, connection: socket.socket) -> None:
        # A worker that has just ended is noticed by its messages; the browser reconnects.
        with contextlib.suppress(OSError):
            hand_over(connection, self._channel)

    def serve(self) -> None:
        self.ready = self.has_served = True
        for connection in self.waiting:
            self.waiting.leave(connection)
            self._hand_over(connection)

    def count_others(self, count: int) -> None:
        if count != self._others:
            self._others = count
            self.send(ClientCount(count))

    def send(self, message: object) -> None:
        with contextlib.suppress(OSError):
            self.control.send(message)

    def close(self, patience: float) -> None:
        """Kill the process if it has not ended after `patience` [s]."""
        if not self.has_served:
            self.process.kill()
        try:
            self.process.wait(patience)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self._channel.close()
        self.control.close()
