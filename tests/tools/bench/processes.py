"""Processes of the benchmark: the server with its times by part, and clients outside its measurement."""

from __future__ import annotations

import asyncio
import os
import threading
import time
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection
from typing import Any, Final

from scenes.children import SPAWN, child_environment, leave_with_parent

PARTS: Final[tuple[str, ...]] = ("step", "drawing", "packing", "sending")
"""Parts of the server's time; the rest is "other": asyncio, viser's windows, switches between threads."""


class ServerTimes:
    """CPU time of the server by part.

    Attributes:
        seconds: part → time so far [s].
        longest: longest frame since the last reset to 0, including all calls [s].
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = dict.fromkeys(PARTS, 0.0)
        self.longest = 0.0
        self._open = threading.local()

    def timed(self, function: Callable[..., Any], part: str) -> Callable[..., Any]:
        """The function, adding its time to a part, without the time of timed functions that it calls."""
        seconds, open_parts, clock = self.seconds, self._open, time.thread_time

        def call(*args: Any, **kwargs: Any) -> Any:
            around: float = getattr(open_parts, "inside", 0.0)
            open_parts.inside = 0.0
            begin = clock()
            try:
                return function(*args, **kwargs)
            finally:
                whole = clock() - begin
                seconds[part] += whole - open_parts.inside
                open_parts.inside = around + whole
                if part == "drawing":
                    self.longest = max(self.longest, whole)

        return call

    def watch(self) -> None:
        """Replace functions of the program by timed ones, for the rest of the process."""
        from app.features.lecture.lecture import LectureHost
        from app.hosting.private_host import PrivateHost
        from app.session.run_control import RunControl
        from app.web import sending
        from app.web.connection import FilteredConnection

        for host in (PrivateHost, LectureHost):
            host.frame = self.timed(host.frame, "drawing")
        RunControl.step = self.timed(RunControl.step, "step")
        sending.pack = self.timed(sending.pack, "packing")
        FilteredConnection.send_data = self.timed(FilteredConnection.send_data, "sending")


def limit_of(figures: dict[str, float]) -> str:
    """Line with the parts of the server's time, largest first; "" for figures without parts."""
    known = {name: figures[f"{name}_percent"] for name in (*PARTS, "other") if f"{name}_percent" in figures}
    total = figures.get("cpu_percent_of_a_core", 0.0)
    if not known or total <= 0.0:
        return ""
    shares = sorted(known.items(), key=lambda entry: -entry[1])
    words = ", ".join(f"{name} {100.0 * value / total:.0f} %" for name, value in shares)
    return f"of {total:.0f} % of a core: {words}"


TIMEOUT: Final = 120.0
"""Longest time for a process to start or answer [s]."""

REQUEST: Final = "figures"
END: Final = "end"
"""Messages to a process: `REQUEST` and `END`."""


def serve_app(pipe: Connection, lecture: bool, sessions: int) -> None:
    """Serve the app. Sends its address; for each request CPU time, CPU time by part, longest frame [s]."""
    leave_with_parent()
    from app.features import FEATURES
    from app.features.lecture.lecture_options import LectureOptions
    from app.hosting.serve_options import ServeOptions
    from app.start import start_app

    times = ServerTimes()
    times.watch()
    app = start_app(
        ServeOptions(sessions=sessions, ahead=True, features=(LectureOptions(lecture=lecture),)),
        features=FEATURES,
    )
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
    # Nothing of this process may be in the server's measured time.
    ours, theirs = SPAWN.Pipe()
    process = SPAWN.Process(target=work, args=(theirs, *arguments), daemon=False)
    try:
        with child_environment():
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
    """Run `work(pipe, *arguments)` until it, or the parent, ends."""
    leave_with_parent()
    asyncio.run(work(pipe, *arguments))


def receive(pipe: Connection) -> Any:
    """Next message of a process.

    Raises:
        TimeoutError: no message within `TIMEOUT`.
    """
    if not pipe.poll(TIMEOUT):
        raise TimeoutError("a process of the benchmark does not answer")
    return pipe.recv()


def request(pipe: Connection) -> Any:
    """Figures of a process."""
    pipe.send(REQUEST)
    return receive(pipe)
