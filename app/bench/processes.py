"""Processes of the benchmark: the server, and the clients, so that their own cost is not counted as the server's."""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import time
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection
from typing import Any, Final

from scenes.children import deaf, leave_with_parent

TIMEOUT: Final = 120.0
"""Longest time for a process to start or to answer [s]."""

REQUEST: Final = "figures"
END: Final = "end"
"""What a process is sent."""


def serve_app(pipe: Connection, lecture: bool, sessions: int) -> None:
    """Serve the app; send the address, then (CPU time [s], CPU time of each part [s], longest frame [s]) for every request."""
    leave_with_parent()
    from app.bench.server_times import ServerTimes
    from app.settings import Settings
    from app.start import start_app

    times = ServerTimes()
    times.watch()
    app = start_app("127.0.0.1", 0, Settings(), sessions, lecture, ahead=True)
    pipe.send(app.url)
    while pipe.recv() == REQUEST:
        pipe.send((time.process_time(), dict(times.seconds), times.longest))
        times.longest = 0.0
    app.close()
    pipe.send("closed")
    os._exit(0)


@contextmanager
def process(work: Callable[..., None], *arguments: Any) -> Iterator[Connection]:
    """Run `work(pipe, *arguments)` in a new process while open; gives this end of the pipe."""
    # Nothing of this process may be part of the server's measured time.
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=work, args=(theirs, *arguments), daemon=False)
    try:
        with deaf():
            process.start()
        theirs.close()
        yield ours
        with suppress(OSError):
            ours.send(END)
            process.join(10.0)
    finally:
        if process.pid is not None:
            process.kill()
            process.join()


def run_async(pipe: Connection, work: Callable[..., Coroutine[Any, Any, None]], *arguments: Any) -> None:
    """Run `work(pipe, *arguments)` to its end, or that of the parent."""
    leave_with_parent()
    asyncio.run(work(pipe, *arguments))


def receive(pipe: Connection) -> Any:
    """Return the next message of a process.

    Raises:
        TimeoutError: there is none within `TIMEOUT`.
    """
    if not pipe.poll(TIMEOUT):
        raise TimeoutError("a process of the benchmark does not answer")
    return pipe.recv()


def request(pipe: Connection) -> Any:
    """Ask a process for its figures and return them."""
    pipe.send(REQUEST)
    return receive(pipe)
