"""A worker as the door sees it: a process that serves the connections that it is given. Imports nothing slow."""

import contextlib
import signal
import socket
import subprocess
import sys
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any, Final, NamedTuple

from app.runtime.job_address import JobAddress
from app.web.handed_over import hand_over

LATELY: Final = 1.0
"""How long a connection that was handed over counts, until the worker itself is sure to count it [s]."""

PULSE: Final = 2.0
"""Time between two messages of a worker that it is at work [s]."""

MOST_WAITING: Final = 200
"""Connections that wait for a worker; the oldest makes room."""


@dataclass(frozen=True)
class WorkerStart:
    """What a worker is to serve.

    Attributes:
        host, port: the address to which the door's socket is bound.
        app: further arguments of `app.start.start_app`.
        sources: arguments of `app.session.input_sources.find_input_sources`.
        given: what only the command line knows of robots; None for nothing.
        run: see `app.web.server.DuetServer`; chosen by the door.
        jobs: the pool of jobs that all workers share; chosen by the door.
        index: of the worker, from 0; chosen by the door.
    """

    host: str
    port: int
    app: Mapping[str, Any]
    sources: tuple[Any, ...]
    given: Any = None
    run: str = ""
    jobs: JobAddress | None = None
    index: int = 0


class Ready(NamedTuple):
    """A worker serves.

    Attributes:
        places: sessions that all workers have at once.
    """

    places: int


class Failed(NamedTuple):
    """A worker cannot start, for a reason that the user can remove."""

    message: str


class ClientCount(NamedTuple):
    """How many browsers are connected to a worker; or, to a worker, how many to all others."""

    browsers: int


class AtWork(NamedTuple):
    """A worker draws its pages; sent every `PULSE`."""


class StartJobs(NamedTuple):
    """A worker has a job, and the shared pool does not run."""


class ToStage(NamedTuple):
    """For the process with the stage of a lecture; like the next two, opaque to the door."""

    content: bytes


class ForTab(NamedTuple):
    """For the process with breakout sessions that gets a tab from now on."""

    tab: str
    content: bytes


class ForAll(NamedTuple):
    """For all processes with breakout sessions, also for those that start later."""

    content: bytes


class ForgetTabs(NamedTuple):
    """All tabs come to the stage when they connect again."""


class Relayed(NamedTuple):
    """What another process has sent."""

    content: bytes


class Replaced(NamedTuple):
    """Another process of a lecture has been replaced: the stage's, to all others; another one, to the stage's."""

    worker: int


class Stop(NamedTuple):
    """A worker is to save everything and to end. `goes_on`: whether a lecture goes on with the next server."""

    goes_on: bool = False


class WorkerProcess:
    """A running worker.

    Args:
        start: what it serves.
        now: the time [s].

    Raises:
        OSError: no process can be started.

    Attributes:
        control: its messages.
        ready: whether it serves.
        has_served: whether it lives and has served, so that it has something to save.
        has_started: whether it could serve.
        began: when it was started [s].
        clients: browsers that it has counted.
        silent: looks of the door in a row before which nothing was heard of its work.
        waiting: connections that it is given as soon as it is ready.
    """

    def __init__(self, start: WorkerStart, now: float) -> None:
        with contextlib.ExitStack() as opened:
            channel, theirs = map(opened.enter_context, socket.socketpair())
            control, other = map(opened.enter_context, Pipe())
            numbers = theirs.fileno(), other.fileno()
            # In a group of its own: Ctrl+C in the terminal is for the door.
            command = (sys.executable, "-m", "app.serve_worker", *map(str, numbers))
            self.process = subprocess.Popen(command, pass_fds=numbers, stdin=subprocess.DEVNULL, process_group=0)
            theirs.close()
            other.close()
            opened.pop_all()
        # A worker that hangs must not hold up the door.
        channel.setblocking(False)
        self._channel = channel
        self.control: Connection[Any, Any] = control
        self.ready = self.has_served = self.has_started = False
        self.began, self.clients, self.silent, self._others = now, 0, 0, 0
        self.waiting: deque[socket.socket] = deque()
        self._lately: deque[float] = deque(maxlen=MOST_WAITING)
        self.send(start)

    def load(self, now: float) -> int:
        """Return the number of browsers that it has, or soon will have."""
        while self._lately and now - self._lately[0] > LATELY:
            self._lately.popleft()
        return max(self.clients, len(self._lately)) + len(self.waiting)

    def take(self, connection: socket.socket, now: float, *, stays: bool) -> None:
        """Hand over a connection, as soon as the worker is ready. `stays`: whether it becomes a websocket."""
        if stays:
            self._lately.append(now)
        if not self.ready:
            if len(self.waiting) >= MOST_WAITING:
                self.waiting.popleft().close()
            self.waiting.append(connection)
            return
        # A worker that has just ended is noticed by its messages; the browser comes again.
        with contextlib.suppress(OSError):
            hand_over(connection, self._channel)

    def serve(self) -> None:
        """Hand over what has waited for the worker to be ready."""
        self.ready = self.has_served = True
        while self.waiting:
            self.take(self.waiting.popleft(), self.began, stays=False)

    def count_others(self, count: int) -> None:
        """Let the worker know how many browsers the others have."""
        if count != self._others:
            self._others = count
            self.send(ClientCount(count))

    def send(self, message: object) -> None:
        with contextlib.suppress(OSError):
            self.control.send(message)

    def close(self, patience: float) -> None:
        """Wait until the process has ended, and end it after so long [s]."""
        for connection in self.waiting:
            connection.close()
        if not self.has_served:
            self.process.kill()
        try:
            self.process.wait(patience)
        except subprocess.TimeoutExpired:
            self.process.send_signal(signal.SIGKILL)
            self.process.wait()
        self._channel.close()
        self.control.close()
