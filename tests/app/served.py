"""`lwr-duet serve` in processes of its own."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from urllib.request import urlopen

Serve = Callable[..., "Served"]


class Served:
    """A server with its store in a folder. `options`: of the command."""

    def __init__(self, folder: Path, *options: str) -> None:
        command = [sys.executable, "-m", "app", "serve", "--no-open", "--port", "0", "--store", str(folder / "store"), *options]
        self.errors = (folder / "errors").open("a+")
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=self.errors, text=True)
        assert self.process.stdout is not None
        self.url = self.process.stdout.readline().split()[3].partition("/?")[0]

    def said(self) -> str:
        self.errors.seek(0)
        return self.errors.read()

    def children(self, of: str) -> list[int]:
        """Process ids of the dispatcher's children whose command holds a word."""
        found = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text(encoding="utf-8").split()
        named: list[int] = []
        for pid in found:
            # One may end between the two looks.
            with suppress(FileNotFoundError, ProcessLookupError):
                if of in Path(f"/proc/{pid}/cmdline").read_text(encoding="utf-8"):
                    named.append(int(pid))
        return named

    @property
    def workers(self) -> list[int]:
        return self.children("app.serve_worker")

    def health(self) -> dict[str, object]:
        with urlopen(f"{self.url}/healthz", timeout=60.0) as answer:
            return json.load(answer)

    def kill(self) -> None:
        """Kill all its processes at once."""
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
