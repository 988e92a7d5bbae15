"""`lwr-duet serve` in separate processes."""

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from urllib.request import urlopen

from app.runtime.terminal import TERMINATED
from app.web.headless_client import HeadlessClient
from app.web.server import MOVED_CODE
from tests.app.runtime.processes import until
from tests.app.served import is_whole
from tests.app.web.conftest import ended
from tests.blocking_client import BlockingClient

Serve = Callable[..., "Served"]


_TRACKER = re.compile(r"^.*resource_tracker: .*\n\s+warnings\.warn\(.*\n", re.MULTILINE)
"""Python's occasional warning about its own semaphores if a process ends while others still start."""


class Served:
    """A server with its store in a folder. `options`: of the command."""

    def __init__(self, folder: Path, *options: str) -> None:
        self.store = folder / "store"
        command = [
            sys.executable,
            "-m",
            "app",
            "serve",
            "--no-open",
            "--port",
            "0",
            "--store",
            str(self.store),
            *options,
        ]
        self.errors = (folder / "errors").open("a+")
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=self.errors, text=True)
        assert self.process.stdout is not None
        self.url = self.process.stdout.readline().split()[3].partition("/?")[0]

    def said(self) -> str:
        self.errors.seek(0)
        return self.errors.read()

    def children(self, of: str) -> list[int]:
        """Process ids of the dispatcher's children with `of` in their command."""
        found = (
            Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children")
            .read_text(encoding="utf-8")
            .split()
        )
        named: list[int] = []
        for pid in found:
            # A child may end between listing and reading.
            with suppress(FileNotFoundError, ProcessLookupError):
                if of in Path(f"/proc/{pid}/cmdline").read_text(encoding="utf-8"):
                    named.append(int(pid))
        return named

    @property
    def workers(self) -> list[int]:
        return self.children("app.features.workers.serve_worker")

    def come(self, query: str, whole: Callable[[HeadlessClient], object] = is_whole) -> BlockingClient:
        """A tab with a complete page; like a page, it reconnects when it is sent to another process."""
        while True:
            visitor = BlockingClient(self.url, query=query)
            visitor.wait_for(lambda v: v.closed or whole(v))
            if visitor.closed is None:
                return visitor
            assert ended(visitor)[0] == MOVED_CODE
            visitor.close()

    def replace(self, worker: int) -> None:
        """Kill a worker and wait for its successor."""
        count = len(self.workers)
        os.kill(worker, signal.SIGKILL)
        until(lambda: worker not in self.workers and len(self.workers) == count)

    def health(self) -> dict[str, object]:
        with urlopen(f"{self.url}/healthz", timeout=60.0) as answer:
            return json.load(answer)

    def terminate(self) -> str:
        """End it as a service manager does. Returns its messages about that."""
        before = self.said()
        self.process.terminate()
        assert self.process.wait(60.0) == TERMINATED
        return _TRACKER.sub("", self.said().removeprefix(before))

    def kill(self) -> None:
        workers = self.workers if self.process.poll() is None else []
        self.process.kill()
        for pid in workers:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        self.process.wait()
        assert self.process.stdout is not None
        self.process.stdout.close()

    def close(self) -> None:
        self.kill()
        self.errors.close()
