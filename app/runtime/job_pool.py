"""Runs jobs longer than a frame in a few worker processes for all visitors."""

import itertools
import logging
import os
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from ctypes import c_longlong
from dataclasses import dataclass
from typing import Any, Final, Literal

from controllers.errors import DuetError, LazyText
from controllers.system_libraries import naming_missing_library
from scenes.children import SPAWN, inheriting, leave_with_parent
from scenes.given_robots import GivenAtStart, given_at_start, take_over
from scenes.wanted import check_wanted, until

log = logging.getLogger("duet.background")

MOST_WAITING: Final = 256
"""Most waiting jobs; others are refused."""

NICENESS: Final = 3

ENDED: Final = LazyText("The computation was ended from outside; ask for it again.")
BUSY: Final = LazyText("Too many computations are waiting; ask again in a moment.")
FAILED: Final = LazyText("The computation failed; the server's log says why.")

State = Literal["waiting", "running", "done", "failed", "dropped"]


@dataclass(eq=False)
class Job:
    """One request, see `Jobs.submit`.

    Attributes:
        state: "dropped" if the result is no longer wanted; "waiting" also until its worker requeues it.
        message: reason of a failure, for the visitor.
    """

    ticket: int
    owner: object
    kind: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    urgent: bool
    wake: Callable[[], None]
    state: State = "waiting"
    result: Any = None
    message: str = ""


class Jobs(ABC):
    """Runs jobs in the background; any thread."""

    def __init__(self) -> None:
        self._tickets = itertools.count(1)

    def submit(
        self,
        owner: object,
        kind: str,
        function: Callable[..., Any],
        *arguments: Any,
        urgent: bool = False,
        wake: Callable[[], None] = lambda: None,
    ) -> Job:
        """Queue `function(*arguments)`; drop an older job of the same owner and kind.

        Args:
            function: at a module's top level. `scenes.wanted` ends it early if the result is no longer
                wanted.
            arguments: picklable.
            urgent: goes before others; a running job that is not urgent is requeued.
            wake: called after a change of state, from another thread.
        """
        job = Job(next(self._tickets), owner, kind, function, arguments, urgent, wake)
        self._queue(job)
        return job

    @abstractmethod
    def _queue(self, job: Job) -> None:
        """Queue a job, or fail it at once."""

    @abstractmethod
    def cancel(self, owner: object, kind: str | None = None) -> None:
        """Drop all jobs of an owner, or of one kind."""

    @abstractmethod
    def close(self) -> None:
        """Drop all jobs and release resources; later jobs fail."""


class JobWatch:
    """One owner's jobs with their handlers. Owner's thread only.

    Args:
        background: None to ignore submitted jobs.
        wake: called from any thread when a job's state changes.
        failed: called by `collect`.
    """

    def __init__(
        self, background: Jobs | None, wake: Callable[[], None], failed: Callable[[Job], None]
    ) -> None:
        self._background, self._wake, self._failed = background, wake, failed
        self.computes = background is not None
        self._jobs: dict[Job, Callable[[Any], None]] = {}

    @property
    def kinds(self) -> tuple[str, ...]:
        return tuple(job.kind for job in self._jobs)

    def submit(
        self,
        kind: str,
        done: Callable[[Any], None],
        function: Callable[..., Any],
        *arguments: Any,
        urgent: bool = False,
    ) -> None:
        """See `Jobs.submit`; `collect` calls `done` with the result."""
        self.drop(kind)
        if self._background is not None:
            self._jobs[
                self._background.submit(self, kind, function, *arguments, urgent=urgent, wake=self._wake)
            ] = done

    def drop(self, kind: str) -> None:
        if self._background is not None:
            self._background.cancel(self, kind)
        self._jobs = {job: done for job, done in self._jobs.items() if job.kind != kind}

    def collect(self) -> None:
        for job, done in list(self._jobs.items()):
            # Handing over one result may drop another job.
            if job.state in ("waiting", "running") or self._jobs.pop(job, None) is None:
                continue
            if job.state == "done":
                done(job.result)
            elif job.state == "failed":
                self._failed(job)

    def close(self) -> None:
        if self._background is not None:
            self._background.cancel(self)
        self._jobs.clear()


class JobPool(Jobs):
    """Processes start with the first job. `workers`: None for all cores but one, at most four."""

    def __init__(self, workers: int | None = None) -> None:
        super().__init__()
        self.workers = workers or max(1, min((os.cpu_count() or 1) - 1, 4))
        # Ticket to stop in each place; read by the workers.
        self._stop: Any = None
        self._pool: ProcessPoolExecutor | None = None
        self._lock = threading.RLock()
        self._waiting: list[Job] = []
        self._running: dict[int, Job] = {}
        self._closed = False

    def _queue(self, job: Job) -> None:
        with self._lock:
            place = len(self._waiting)
            for old in [
                j
                for j in (*self._waiting, *self._running.values())
                if (j.owner, j.kind) == (job.owner, job.kind)
            ]:
                # A new request takes the old one's place in the queue.
                place = min(place, self._drop(old))
            if self._closed or len(self._waiting) >= MOST_WAITING:
                job.message, job.state = BUSY, "failed"
                return
            self._waiting.insert(place, job)
            self._pump()

    def cancel(self, owner: object, kind: str | None = None) -> None:
        with self._lock:
            for job in [*self._waiting, *self._running.values()]:
                if job.owner == owner and kind in (None, job.kind):
                    self._drop(job)

    def close(self) -> None:
        with self._lock:
            self._closed = True
            for job in [*self._waiting, *self._running.values()]:
                self._drop(job)
            pool, self._pool = self._pool, None
        if pool is not None:
            pool.shutdown(wait=True, cancel_futures=True)

    def _drop(self, job: Job) -> int:
        job.state = "dropped"
        if job in self._waiting:
            place = self._waiting.index(job)
            self._waiting.remove(job)
            return place
        for place, running in self._running.items():
            if running is job:
                self._stop[place] = job.ticket
        return len(self._waiting)

    def _pump(self) -> None:
        while self._waiting and not self._closed:
            job = next((j for j in self._waiting if j.urgent), self._waiting[0])
            place = next((i for i in range(self.workers) if i not in self._running), None)
            if place is None:
                if job.urgent:
                    self._preempt()
                return
            self._waiting.remove(job)
            self._start(job, place)

    def _preempt(self) -> None:
        if any(job.state != "running" for job in self._running.values()):
            return  # A worker is about to be free.
        for place, job in self._running.items():
            if not job.urgent:
                # It begins again once its worker has noticed.
                job.state = "waiting"
                self._stop[place] = job.ticket
                return

    def _start(self, job: Job, place: int) -> None:
        job.state = "running"
        self._running[place] = job
        try:
            if self._pool is None:
                self._stop = SPAWN.RawArray(c_longlong, self.workers)
                with inheriting():
                    # Its locks start a process, too.
                    self._pool = ProcessPoolExecutor(
                        self.workers, SPAWN, _begin, (self._stop, given_at_start())
                    )
            pool = self._pool
            self._stop[place] = 0  # The job may be the one that was put back here.
            with inheriting():
                future = pool.submit(_work, job.ticket, place, job.function, job.arguments)
        except BrokenProcessPool:
            # A worker had died unnoticed.
            self._pool = None
            del self._running[place]
            job.state = "waiting"
            self._waiting.insert(0, job)
            self._pump()
            return
        future.add_done_callback(lambda f: self._finish(job, place, pool, f))

    def _finish(self, job: Job, place: int, pool: ProcessPoolExecutor, future: "Future[Any]") -> None:
        with self._lock:
            if self._running.get(place) is job:
                del self._running[place]
            error = None if future.cancelled() else future.exception()
            if isinstance(error, BrokenProcessPool) and self._pool is pool:
                # It cannot be used any more, and shuts itself down.
                self._pool = None
            if job.state != "dropped":
                self._settle(job, future, error)
            with suppress(RuntimeError):
                # The interpreter is about to end.
                self._pump()
        job.wake()

    def _settle(self, job: Job, future: "Future[Any]", error: BaseException | None) -> None:
        if future.cancelled():
            job.state = "dropped"
        elif error is None:
            job.result, job.state = future.result(), "done"
        elif job.state == "waiting" and not isinstance(error, BrokenProcessPool):
            self._waiting.insert(0, job)
        else:
            if isinstance(error, BrokenProcessPool):
                log.warning("a worker was ended from outside")
                job.message = ENDED
            elif isinstance(error, DuetError):
                job.message = str(error)
            else:
                log.error("a computation failed", exc_info=error)
                job.message = FAILED
            # Last: its owner reads without the lock, and the message when it has failed.
            job.state = "failed"


# --- in the worker -------------------------------------------------------------------------------------------------------------

_stop: Any = None


def _begin(stop: Any, given: GivenAtStart) -> None:
    """Make a process a worker with low priority, which ignores Ctrl+C and ends with its parent."""
    global _stop
    _stop = stop
    take_over(given)
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    leave_with_parent()


def _work(ticket: int, place: int, function: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
    with until(lambda: _stop[place] == ticket), naming_missing_library():
        check_wanted()
        return function(*arguments)
