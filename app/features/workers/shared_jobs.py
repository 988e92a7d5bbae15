"""One pool of jobs for several processes."""

import logging
import os
import pickle
import socket
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import AuthenticationError
from multiprocessing.connection import Client, Connection, Listener
from queue import SimpleQueue
from time import monotonic
from typing import Any, Final, NamedTuple

from app.features.workers.job_address import JobAddress
from app.runtime.job_pool import BUSY, ENDED, FAILED, MOST_WAITING, Job, JobPool, Jobs, State
from app.runtime.terminal import write_log
from scenes.given_robots import given_at_start, take_over

log = logging.getLogger("duet.background")

PATIENCE: Final = 60.0
"""Longest wait for the job server, which may start slowly [s]."""

LOST: Final = (EOFError, OSError)
"""Exceptions at the end of a connection."""


class _Ask(NamedTuple):
    ticket: int
    owner: int
    kind: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    urgent: bool


class _Cancel(NamedTuple):
    owner: int
    kind: str | None


class _Answer(NamedTuple):
    ticket: int
    state: State
    result: Any
    message: str


class JobClient(Jobs):
    """Client of the shared pool. `start`: starts the server, for the first job and again after its end."""

    def __init__(self, address: JobAddress, start: Callable[[], None]) -> None:
        super().__init__()
        self._address, self._start = address, start
        self._lock, self._closed = threading.RLock(), threading.Event()
        self._jobs: dict[int, Job] = {}
        # The asking frame loop waits for no other process. Each request has the ticket of its job; None to
        # cancel, and at the end.
        self._unsent: SimpleQueue[tuple[int | None, bytes] | None] = SimpleQueue()
        self._connection: Connection[Any, Any] | None = None
        threading.Thread(target=self._send, name="duet-jobs", daemon=True).start()

    def _queue(self, job: Job) -> None:
        with self._lock:
            self._drop(job.owner, job.kind)
            if self._closed.is_set() or len(self._jobs) >= MOST_WAITING:
                job.state, job.message = "failed", BUSY
                return
            try:
                asked = pickle.dumps(
                    _Ask(job.ticket, id(job.owner), job.kind, job.function, job.arguments, job.urgent)
                )
            except Exception:
                log.exception("a job cannot be sent")
                job.state, job.message = "failed", FAILED
                return
            self._jobs[job.ticket] = job
            self._unsent.put((job.ticket, asked))

    def cancel(self, owner: object, kind: str | None = None) -> None:
        with self._lock:
            if self._drop(owner, kind):
                self._unsent.put((None, pickle.dumps(_Cancel(id(owner), kind))))

    def close(self) -> None:
        with self._lock:
            self._closed.set()
            for job in self._jobs.values():
                job.state = "dropped"
            self._jobs.clear()
            self._hang_up()
        self._unsent.put(None)

    def _drop(self, owner: object, kind: str | None) -> bool:
        dropped = [job for job in self._jobs.values() if job.owner == owner and kind in (None, job.kind)]
        for job in dropped:
            job.state = "dropped"
            del self._jobs[job.ticket]
        return bool(dropped)

    # ---- in the threads ----------------------------------------------------------------------------------------------------

    def _send(self) -> None:
        for ticket, message in iter(self._unsent.get, None):
            if ticket is not None and ticket not in self._jobs:
                # No longer wanted.
                continue
            connection = self._connection
            if connection is None and ticket is not None:
                connection = self._connect()
            if connection is not None:
                # Its end is noticed by the reader.
                with suppress(*LOST):
                    connection.send_bytes(message)
        with self._lock:
            self._hang_up()

    def _connect(self) -> "Connection[Any, Any] | None":
        self._start()
        until = monotonic() + PATIENCE
        while not self._closed.is_set() and monotonic() < until:
            try:
                connection = Client(self._address.path, authkey=self._address.secret)
                connection.send(given_at_start())
            except LOST:
                # The server is just starting.
                self._closed.wait(0.05)
                continue
            self._connection = connection
            threading.Thread(
                target=self._read, args=(connection,), name="duet-job-results", daemon=True
            ).start()
            return connection
        self._end()
        return None

    def _read(self, connection: "Connection[Any, Any]") -> None:
        try:
            with suppress(*LOST):
                while True:
                    self._take(connection.recv())
        finally:
            self._end()

    def _hang_up(self) -> None:
        """Shut down both sides; closing alone does not wake the reading thread."""
        if self._connection is not None:
            with suppress(OSError), socket.socket(fileno=os.dup(self._connection.fileno())) as end:
                end.shutdown(socket.SHUT_RDWR)

    def _take(self, answer: _Answer) -> None:
        with self._lock:
            job = self._jobs.get(answer.ticket)
            if job is None:
                return
            job.result, job.message, job.state = answer.result, answer.message, answer.state
            if answer.state not in ("waiting", "running"):
                del self._jobs[answer.ticket]
        job.wake()

    def _end(self) -> None:
        """The next job opens a new connection."""
        with self._lock:
            lost = list(self._jobs.values())
            self._jobs.clear()
            self._hang_up()
            # Closed once the sending thread has released it, too.
            self._connection = None
            for job in lost:
                job.message, job.state = ENDED, "failed"
        for job in lost:
            job.wake()


class JobServer:
    """Runs the jobs of all clients."""

    def __init__(self, address: JobAddress, workers: int | None = None) -> None:
        self._listener = Listener(address.path, family="AF_UNIX", backlog=64, authkey=address.secret)
        self.pool = JobPool(workers)
        self._closed = False
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self) -> None:
        self._closed = True
        self._listener.close()
        self.pool.close()

    def _accept(self) -> None:
        while not self._closed:
            try:
                connection = self._listener.accept()
            except (*LOST, AuthenticationError):
                continue
            threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection: "Connection[Any, Any]") -> None:
        owners: set[tuple[object, int]] = set()
        lock = threading.Lock()
        try:
            with connection, suppress(*LOST):
                take_over(connection.recv())
                while True:
                    message = pickle.loads(connection.recv_bytes())
                    owner = connection, message.owner
                    if isinstance(message, _Cancel):
                        self.pool.cancel(owner, message.kind)
                        continue
                    owners.add(owner)
                    self._submit(owner, message, connection, lock)
        finally:
            for owner in owners:
                self.pool.cancel(owner)

    def _submit(
        self, owner: tuple[object, int], ask: _Ask, connection: "Connection[Any, Any]", lock: threading.Lock
    ) -> None:
        jobs: list[Job] = []

        def report() -> None:
            if not jobs:
                # A finished job is reported below.
                return
            job = jobs[0]
            with lock, suppress(*LOST):
                connection.send(
                    _Answer(ask.ticket, job.state, job.result if job.state == "done" else None, job.message)
                )

        jobs.append(
            self.pool.submit(owner, ask.kind, ask.function, *ask.arguments, urgent=ask.urgent, wake=report)
        )
        report()


def main() -> None:
    """Serve until standard input ends; its first line has path and secret."""
    write_log()
    path, secret = sys.stdin.buffer.readline().split()
    server = JobServer(JobAddress(path.decode(), bytes.fromhex(secret.decode())))
    sys.stdin.buffer.read()
    server.close()
