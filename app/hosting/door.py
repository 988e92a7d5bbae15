"""The process that listens: it looks at the first line of every request, and hands the connection to the worker that has the tab.

What goes over a connection never passes here. Imports nothing slow, so that a single visitor pays nothing for it.
"""

import logging
import re
import secrets
import selectors
import shutil
import socket
import subprocess
import tempfile
from collections import OrderedDict
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from time import monotonic
from typing import Any, Final

from app.hosting.worker_process import (
    ClientCount,
    Failed,
    ForAll,
    ForgetTabs,
    ForTab,
    Ready,
    Relayed,
    Replaced,
    StartJobs,
    Stop,
    ToStage,
    WorkerProcess,
    WorkerStart,
)
from app.runtime.job_address import JobAddress, start_job_server
from controllers.errors import DuetError

log = logging.getLogger("duet.door")

FEW: Final = 2
"""Browsers at every worker from which on another worker is started."""

CROWD: Final = 4
"""Browsers at a worker from which on new ones wait for a worker that is just starting."""

LINE: Final = 8192
"""What is read of a request to find its first line [bytes]."""

SLOW: Final = 10.0
"""Time in which the first line has to arrive [s]."""

GLANCE: Final = 0.05
"""Time between two looks at a first line that has arrived in part [s]."""

MOST_UNREAD: Final = 500
"""Connections at once without a first line; the oldest makes room."""

MOST_TABS: Final = 20_000
"""Tabs that are remembered."""

SHORT_LIFE: Final = 10.0
"""A worker that ends sooner than this is not replaced at once [s]."""

BREATHS: Final = (0.5, 1.0, 2.0, 5.0, 15.0)
"""How long each next replacement waits then [s]."""

PATIENCE: Final = 10.0
"""How long the workers may take to end [s]."""

_TAB: Final = re.compile(rb"^[A-Z]+ [^ ]*[?&]resume=([a-z0-9]{16,64})(?:[&# ]|$)")


def tab_of(line: bytes) -> str:
    """Return the id of the tab in the first line of a request; "" for none."""
    found = _TAB.match(line)
    return found[1].decode() if found else ""


class Door:
    """Listens for the workers, starts them as they are needed, and replaces those that have ended.

    Args:
        listener: a socket that listens.
        start: what every worker serves; `run` and `jobs` are filled in here.
        most: workers at once; in a lecture, besides the one with the stage.

    Raises:
        DuetError: the first worker cannot start; its message.
    """

    def __init__(self, listener: socket.socket, start: WorkerStart, most: int) -> None:
        self._listener, self._most = listener, most
        self._folder = Path(tempfile.mkdtemp(prefix="duet-"))
        self._address = JobAddress(str(self._folder / "jobs"), secrets.token_bytes(16))
        self._start = replace(start, run=secrets.token_hex(8), jobs=self._address)
        self._jobs: subprocess.Popen[bytes] | None = None
        self._selector = selectors.DefaultSelector()
        self.workers: list[WorkerProcess] = []
        self._due: dict[int, float] = {}
        self._short: dict[int, int] = {}
        self._tabs: OrderedDict[str, int] = OrderedDict()
        self._lecture = start.app.get("lecture", False)
        self._sent: dict[str, tuple[int, bytes]] = {}
        self._decided: bytes | None = None
        self._unread: OrderedDict[socket.socket, tuple[float, float]] = OrderedDict()
        self._announced = False
        listener.setblocking(False)
        self._begin(0)
        self._selector.register(listener, selectors.EVENT_READ, self._accept)

    def run(self, ready: Callable[[], None]) -> None:
        """Serve until an exception, such as Ctrl+C. `ready`: called once, when the first worker serves.

        Raises:
            DuetError: the first worker cannot start.
        """
        while True:
            for key, _ in self._selector.select(self._wait()):
                key.data()
            if not self._announced and self.workers[0].ready:
                self._announced = True
                ready()
            self._look_after(monotonic())

    def close(self) -> None:
        """Stop to listen, let the workers save everything, and end them."""
        self._listener.close()
        for connection in self._unread:
            connection.close()
        for worker in self.workers:
            worker.send(Stop())
        until = monotonic() + PATIENCE
        for worker in self.workers:
            worker.close(max(until - monotonic(), 0.1))
        if self._jobs is not None:
            self._jobs.communicate()
        self._selector.close()
        shutil.rmtree(self._folder, ignore_errors=True)

    # ---- connections -------------------------------------------------------------------------------------------------------

    def _accept(self) -> None:
        with suppress(BlockingIOError, ConnectionAbortedError):
            connection, _ = self._listener.accept()
            connection.setblocking(False)
            if len(self._unread) >= MOST_UNREAD:
                self._drop(next(iter(self._unread)))
            now = monotonic()
            self._unread[connection] = now + SLOW, 0.0
            self._selector.register(connection, selectors.EVENT_READ, lambda: self._read(connection))

    def _read(self, connection: socket.socket) -> None:
        """Look at what has arrived, which stays to be read by the worker."""
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
        if not end and len(found) < LINE:
            # It would be readable all the time.
            self._forget(connection)
            self._unread[connection] = self._unread[connection][0], monotonic() + GLANCE
            return
        self._forget(connection)
        del self._unread[connection]
        tab = tab_of(line)
        self._worker_of(tab).take(connection, monotonic(), stays=bool(tab))

    def _forget(self, connection: socket.socket) -> None:
        with suppress(KeyError):
            self._selector.unregister(connection)

    def _drop(self, connection: socket.socket) -> None:
        self._forget(connection)
        del self._unread[connection]
        connection.close()

    def _worker_of(self, tab: str) -> WorkerProcess:
        """Return the worker of a tab: always the same one; a new tab's has the fewest browsers. In a lecture it is that of the stage, or
        of the tab's breakout session."""
        if self._lecture:
            return self.workers[self._sent[tab][0] if tab in self._sent else 0]
        index = self._tabs.pop(tab, None) if tab else None
        if index is None:
            index = self._place()
        if tab:
            self._tabs[tab] = index
            if len(self._tabs) > MOST_TABS:
                self._tabs.popitem(last=False)
        return self.workers[index]

    def _place(self) -> int:
        now = monotonic()
        loads = [worker.load(now) for worker in self.workers]
        if min(loads) >= FEW and len(loads) < self._most:
            self._begin(len(loads))
            loads.append(0)
        serving = [index for index, worker in enumerate(self.workers) if worker.ready]
        best = min(serving, key=loads.__getitem__, default=0)
        if serving and loads[best] < CROWD:
            return best
        return min(range(len(loads)), key=loads.__getitem__)

    # ---- workers -----------------------------------------------------------------------------------------------------------

    def _begin(self, index: int) -> None:
        """Start a worker, in the place of one that has ended or as one more."""
        worker = WorkerProcess(replace(self._start, index=index), monotonic())
        if index < len(self.workers):
            worker.waiting = self.workers[index].waiting
            self.workers[index] = worker
        else:
            self.workers.append(worker)
        self._selector.register(worker.control, selectors.EVENT_READ, lambda: self._hear(worker))
        if index and self._decided is not None:
            worker.send(Relayed(self._decided))
            for content in [content for place, content in self._sent.values() if place == index]:
                worker.send(Relayed(content))

    def _place_student(self) -> int:
        """Return the worker for one more breakout session: that with the fewest, or a new one."""
        counts = [0] * (len(self.workers) - 1)
        for index, _ in self._sent.values():
            counts[index - 1] += 1
        if min(counts, default=FEW) >= FEW and len(counts) < self._most:
            self._begin(len(self.workers))
            return len(self.workers) - 1
        return 1 + counts.index(min(counts))

    def _hear(self, worker: WorkerProcess) -> None:
        try:
            message: Any = worker.control.recv()
        except (EOFError, OSError):
            self._replace(worker)
            return
        match message:
            case Ready():
                worker.serve()
                index = self.workers.index(worker)
                if self._lecture:
                    for other in self.workers[:1] if index else self.workers[1:]:
                        other.send(Replaced(index))
                    if len(self.workers) == 1:
                        # A class that is sent to explore does not wait for its start.
                        self._begin(1)
            case Failed(text):
                if not self._announced:
                    raise DuetError(text)
                log.error("a worker cannot start: %s", text)
            case ClientCount(count):
                worker.clients = count
                self._tell_counts()
            case StartJobs():
                self._start_jobs()
            case ToStage(content):
                self.workers[0].send(Relayed(content))
            case ForTab(tab, content):
                index = self._sent[tab][0] if tab in self._sent else self._place_student()
                self._sent[tab] = index, content
                self.workers[index].send(Relayed(content))
            case ForAll(content):
                self._decided = content
                for other in self.workers[1:]:
                    other.send(Relayed(content))
            case ForgetTabs():
                self._sent.clear()
            case _:
                log.error("a worker says %r", message)

    def _tell_counts(self) -> None:
        total = sum(worker.clients for worker in self.workers)
        for worker in self.workers:
            worker.count_others(total - worker.clients)

    def _start_jobs(self) -> None:
        if self._jobs is None or self._jobs.poll() is not None:
            self._jobs = start_job_server(self._address)

    def _replace(self, worker: WorkerProcess) -> None:
        """Start another worker in the place of one that has ended; its tabs come to that one."""
        self._selector.unregister(worker.control)
        waiting, worker.waiting = worker.waiting, type(worker.waiting)()
        worker.close(1.0)
        worker.waiting, worker.ready, worker.clients = waiting, False, 0
        self._tell_counts()
        index, now = self.workers.index(worker), monotonic()
        if not self._announced:
            raise DuetError(f"The page cannot be served: its process has ended with code {worker.process.returncode}.")
        self._short[index] = self._short.get(index, 0) + 1 if now - worker.began < SHORT_LIFE else 0
        short = self._short[index]
        self._due[index] = now + (BREATHS[min(short, len(BREATHS)) - 1] if short else 0.0)
        log.warning("worker %d has ended with code %s; another one takes its place", index + 1, worker.process.returncode)

    def _wait(self) -> float | None:
        """Return how long to wait for an event [s]; None without limit."""
        times = [*self._due.values(), *(look or end for end, look in self._unread.values())]
        return max(min(times) - monotonic(), 0.0) if times else None

    def _look_after(self, now: float) -> None:
        """Start the workers that are due, look again at requests that have arrived in part, and drop those that are too slow."""
        for index in [index for index, due in self._due.items() if due <= now]:
            del self._due[index]
            self._begin(index)
        for connection, (end, look) in list(self._unread.items()):
            if end <= now:
                self._drop(connection)
            elif 0.0 < look <= now:
                self._read(connection)
