"""Group of workers. Imports nothing slow."""

import asyncio
import logging
import secrets
import subprocess
from collections import deque
from dataclasses import replace
from time import monotonic
from typing import Any, Final

from app.features.workers import worker_messages as messages
from app.features.workers.job_address import JobAddress, start_job_server
from app.features.workers.worker_messages import WorkerStart
from app.features.workers.worker_process import WorkerProcess
from app.runtime.temporary_folder import TemporaryFolder
from app.web.traffic_limits import remember
from controllers.errors import DuetError

log = logging.getLogger("duet.workers")

FEW: Final = 2
"""Browsers per worker at which another is started."""

MOST_TABS: Final = 20_000

SHORT_LIFE: Final = 10.0
"""Lifetime below which a worker is not replaced at once [s]."""

RESTART_DELAYS: Final = (0.5, 1.0, 2.0, 5.0, 15.0)
"""Delays of successive replacements of short-lived workers [s]."""

LOOK: Final = 5.0
"""Period of the checks [s]."""

LATE: Final = 1.0
"""A check later than this is skipped: the workers had no processor either [s]."""

MOST_SILENT, MOST_STOPPING = 3, 12
"""Most silent checks of a serving and of a stopping worker."""

MOST_STARTING: Final = 60
"""Checks after which a successor that has not started is ended; loops may have to be compiled."""

PATIENCE: Final = 10.0
"""Longest wait for the end of the workers [s]."""


class WorkerGroup:
    """Starts, replaces and renews workers. Belongs to the thread of `loop`.

    Args:
        start: `run`, `jobs` and `index` are set here.
        most: workers, without the one of a shared session.

    Attributes:
        workers: the first has the shared session, if any.
        places: sessions of all, once the first worker serves; a `DuetError` if it cannot start.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, start: WorkerStart, most: int) -> None:
        self._loop, self._most = loop, most
        self._folder = TemporaryFolder("serve")
        self._address = JobAddress(str(self._folder.path / "jobs"), secrets.token_bytes(16))
        self._start = replace(start, run=secrets.token_hex(8), jobs=self._address)
        self._jobs: subprocess.Popen[bytes] | None = None
        self._short: dict[int, int] = {}
        self._tabs: dict[str, int] = {}
        self._announced: dict[str, int] = {}
        self._shared = start.options.shared is not None
        self._exploring: dict[str, tuple[int, bytes]] = {}
        self._decided: bytes | None = None
        self._to_renew: deque[int] = deque()
        self.successor: tuple[int, WorkerProcess] | None = None
        self.places: asyncio.Future[int] = loop.create_future()
        self.workers: list[WorkerProcess] = []
        self._begin(0)

    def close(self, goes_on: bool = False) -> None:
        """End the workers after they have saved. `goes_on`: see `Stop`."""
        every = [*self.workers, *([] if self.successor is None else [self.successor[1]])]
        for worker in every:
            worker.send(messages.Stop(goes_on))
            for connection in worker.waiting:
                connection.close()
        until = monotonic() + PATIENCE
        for worker in every:
            worker.close(max(until - monotonic(), 0.1))
        if self._jobs is not None:
            assert self._jobs.stdin is not None
            self._jobs.stdin.close()
            try:
                self._jobs.wait(max(until - monotonic(), 1.0))
            except subprocess.TimeoutExpired:
                # An unfinished job is no longer useful.
                self._jobs.kill()
                self._jobs.wait()
        self._folder.remove()

    # ---- tabs --------------------------------------------------------------------------------------------------------------

    def worker_of(self, tab: str, word: str = "") -> WorkerProcess:
        """Always the same worker for a tab; a new tab gets the one with the fewest browsers.

        With a shared session it is the first, or that of the tab's own session.

        Args:
            tab: "" for other requests.
            word: of a link to the worker that announced it.
        """
        if word in self._announced:
            return self.workers[self._announced[word]]
        if self._shared:
            return self.workers[self._exploring[tab][0] if tab in self._exploring else 0]
        index = self._tabs.get(tab)
        if index is None:
            index = self._place()
        if tab:
            remember(self._tabs, tab, index, MOST_TABS)
        return self.workers[index]

    def _place(self) -> int:
        now = monotonic()
        loads = [worker.load(now) for worker in self.workers]
        if sum(loads) >= FEW * len(loads) and len(loads) < self._most and self._begin(len(loads)):
            loads.append(0)
        serving = [index for index, worker in enumerate(self.workers) if worker.ready]
        return min(serving or range(len(loads)), key=loads.__getitem__)

    def _place_explorer(self) -> int | None:
        """None if no worker can be started."""
        counts = [0] * (len(self.workers) - 1)
        for index, _ in self._exploring.values():
            counts[index - 1] += 1
        if min(counts, default=FEW) >= FEW and len(counts) < self._most and self._begin(len(self.workers)):
            return len(self.workers) - 1
        return 1 + counts.index(min(counts)) if counts else None

    # ---- what the workers say ----------------------------------------------------------------------------------------------

    def _hear(self, worker: WorkerProcess) -> None:
        try:
            message: Any = worker.control.recv()
        except (EOFError, OSError):
            self._ended(worker)
            return
        match message:
            case messages.Ready(places):
                if not self.places.done():
                    self.places.set_result(places)
                self._ready(worker)
            case messages.Failed(text):
                if not self.places.done():
                    self.places.set_exception(DuetError(text))
                else:
                    log.error("a worker cannot start: %s", text)
            case messages.ClientCount(count):
                worker.clients = count
                self._share_counts()
            case messages.Load(report, draws):
                worker.report = report
                if draws:
                    worker.silent = 0
                worker.send(
                    messages.LoadElsewhere(
                        tuple(one.report for one in self.workers if one is not worker and one.report)
                    )
                )
            case messages.LetGo(tab):
                self._tabs.pop(tab, None)
            case messages.Announced(word):
                remember(self._announced, word, self.workers.index(worker), MOST_TABS)
                for other in self.workers:
                    if other is not worker:
                        other.send(message)
            case messages.StartJobs():
                self._start_jobs()
            case messages.ToFirst(content):
                self.workers[0].send(content)
            case messages.ForTab(tab, group, content):
                # A group that has explored before may have a parked session there.
                index = self._tabs.get(group) or self._place_explorer()
                if index is not None:
                    remember(self._tabs, group, index, MOST_TABS)
                    self._exploring[tab] = index, content
                    self.workers[index].send(content)
            case messages.ForAll(content):
                self._decided = content
                for other in self.workers[1:]:
                    other.send(content)
            case messages.ForgetTabs():
                self._exploring.clear()
            case _:
                log.error("a worker says %r", message)

    def _start_jobs(self) -> None:
        if self._jobs is None or self._jobs.poll() is not None:
            try:
                self._jobs = start_job_server(self._address)
            except OSError as error:
                log.error("background jobs cannot be started: %s", error)

    def _share_counts(self) -> None:
        total = sum(worker.clients for worker in self.workers)
        for worker in self.workers:
            worker.count_others(total - worker.clients)

    # ---- their lives -------------------------------------------------------------------------------------------------------

    def _new(self, index: int) -> WorkerProcess:
        worker = WorkerProcess(replace(self._start, index=index), monotonic())
        self._loop.add_reader(worker.control, self._hear, worker)
        return worker

    def _begin(self, index: int) -> bool:
        """Start or replace a worker; false if the system could not."""
        try:
            worker = self._new(index)
        except OSError as error:
            if not self.workers:
                raise
            log.error("a worker cannot be started: %s", error)
            if index < len(self.workers):
                self._loop.call_later(RESTART_DELAYS[-1], self._begin, index)
            return False
        if index < len(self.workers):
            self._put(index, worker)
        else:
            self.workers.append(worker)
            self._inform(index)
        return True

    def _put(self, index: int, worker: WorkerProcess) -> None:
        worker.waiting = self.workers[index].waiting
        self.workers[index] = worker
        self._inform(index)

    def _inform(self, index: int) -> None:
        if index and self._decided is not None:
            for content in (
                self._decided,
                *(content for place, content in self._exploring.values() if place == index),
            ):
                self.workers[index].send(content)

    def _ready(self, worker: WorkerProcess) -> None:
        if self.successor is not None and worker is self.successor[1]:
            # Its connections wait until its predecessor has saved everything.
            worker.has_started, worker.silent = True, 0
            old = self.workers[self.successor[0]]
            old.ready = False
            old.send(messages.Stop())
            return
        self._serve(self.workers.index(worker))

    def _serve(self, index: int) -> None:
        self.workers[index].serve()
        if self._shared:
            for other in self.workers[:1] if index else self.workers[1:]:
                other.send(messages.Replaced(index))
            if len(self.workers) == 1:
                # A session beside the shared one need not wait for this start.
                self._begin(1)
        else:
            serving = [worker for worker in self.workers if worker.ready]
            share = sum(worker.load(monotonic()) for worker in serving) // len(serving) + 1
            for worker in serving:
                worker.send(messages.MakeRoom(share))
        self._share_counts()

    def _ended(self, worker: WorkerProcess) -> None:
        self._loop.remove_reader(worker.control)
        worker.close(1.0)
        worker.clients = 0
        worker.ready = worker.has_served = False
        code = worker.process.returncode
        if not self.places.done():
            self.places.set_exception(
                DuetError(f"The page cannot be served: its process has ended with code {code}.")
            )
        if self.places.exception() is not None:
            return
        if worker not in self.workers:
            log.error("a new worker has ended with code %s; the others continue", code)
            self.successor = None
            self._to_renew.clear()
            return
        self._share_counts()
        index = self.workers.index(worker)
        if self.successor is not None and self.successor[0] == index:
            successor, self.successor = self.successor[1], None
            self._put(index, successor)
            if successor.has_started:
                self._serve(index)
            self._renew_next()
            return
        self._short[index] = self._short.get(index, 0) + 1 if monotonic() - worker.began < SHORT_LIFE else 0
        short = self._short[index]
        self._loop.call_later(
            RESTART_DELAYS[min(short, len(RESTART_DELAYS)) - 1] if short else 0.0, self._begin, index
        )
        log.warning("worker %d has ended with code %s; another one takes its place", index + 1, code)

    def renew(self) -> None:
        """Replace all workers, one after the other."""
        begins = not self._to_renew and self.successor is None
        self._to_renew.extend(index for index in range(len(self.workers)) if index not in self._to_renew)
        if begins:
            log.info("all workers are replaced, one after the other")
            self._renew_next()

    def _renew_next(self) -> None:
        if not self._to_renew:
            if self._jobs is not None:
                # The next job starts one that has loaded the present program.
                self._jobs.kill()
                self._jobs.wait()
                self._jobs = None
            return
        index = self._to_renew.popleft()
        if self._shared and index == 0:
            # A shared session that ends by itself is over; one that breaks off continues.
            self.workers[0].process.kill()
        elif self.workers[index].process.returncode is None:
            # A successor loads the present program.
            try:
                self.successor = index, self._new(index)
            except OSError as error:
                log.error("a worker cannot be replaced: %s", error)
                self._to_renew.clear()
            return
        self._renew_next()

    async def look_after(self) -> None:
        while True:
            due = monotonic() + LOOK
            await asyncio.sleep(LOOK)
            if monotonic() - due <= LATE:
                self.look()

    def look(self) -> None:
        """End the workers that hang."""
        for worker in self.workers:
            # A stopping worker must also finish: its successor waits for that.
            worker.silent = worker.silent + 1 if worker.has_served else 0
            if worker.silent > (MOST_SILENT if worker.ready else MOST_STOPPING):
                log.error("a worker draws nothing any more, and is ended")
                worker.process.kill()
        if self.successor is not None and not (new := self.successor[1]).has_started:
            new.silent += 1
            if new.silent > MOST_STARTING:
                log.error("a new worker does not come to its start, and is ended")
                new.process.kill()
