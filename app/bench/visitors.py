"""A house full of visitors, for the benchmark: the server in a process of its own, which notes what takes its time, and the visitors
in further ones, so that what they cost themselves is not counted."""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import secrets
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection
from typing import Any, Final

from scenes.children import deaf, leave_with_parent

WARM_UP: Final = 60
"""Frames that every visitor has had before they are watched: their pages have been built by then."""

SETTLING: Final = 2.0
"""Time they are left alone then [s]."""

PATIENCE: Final = 120.0
"""How long a process may take for its start [s]."""

PARTS: Final[tuple[str, ...]] = ("step", "drawing", "packing", "sending")
"""What the server's time is divided into; the rest is "other": asyncio, viser's windows, threads that take turns."""

CLASS: Final = ("", "lang=de&picture=fast", "lang=sl", "screen=1&profile=projector&theme=dark&lang=de")
"""Links of those who watch a lecture, in turn: each of these looks is drawn for itself."""

ASIDE: Final = 2
"""Processes that play visitors."""


class Shares:
    """Processor time of the server by what it is used for; takes the place of the functions that do it.

    Attributes:
        seconds: of every part so far [s].
        longest: one call that counts for the frames has taken, with all that it called, since this was set to 0 [s].
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = dict.fromkeys(PARTS, 0.0)
        self.longest = 0.0
        self._open = threading.local()

    def timed(self, function: Callable[..., Any], part: str) -> Callable[..., Any]:
        """Return a function whose time counts for a part, but for what another part takes of it."""
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
        """Time the program from now on; there is no way back, so only in a process that is made for it."""
        from app.classroom.lecture import LectureHost
        from app.hosting.private_host import PrivateHost
        from app.session.session import Session
        from app.web import sending
        from app.web.connection import FilteredConnection

        for host in (PrivateHost, LectureHost):
            host.frame = self.timed(host.frame, "drawing")
        Session.advance = self.timed(Session.advance, "step")
        sending.pack = self.timed(sending.pack, "packing")
        FilteredConnection.send_data = self.timed(FilteredConnection.send_data, "sending")


def keep_house(pipe: Connection, lecture: bool, sessions: int) -> None:
    leave_with_parent()
    from app.settings import Settings
    from app.start import start_app

    shares = Shares()
    shares.watch()
    house = start_app("127.0.0.1", 0, Settings(), sessions, lecture, ahead=True)
    pipe.send(house.url)
    while pipe.recv() == "tell":
        pipe.send((time.process_time(), dict(shares.seconds), shares.longest))
        shares.longest = 0.0
    house.close()
    pipe.send("closed")
    os._exit(0)


def _visit(pipe: Connection, url: str, queries: tuple[str, ...]) -> None:
    leave_with_parent()
    asyncio.run(_visit_all(pipe, url, queries))


async def _visit_all(pipe: Connection, url: str, queries: tuple[str, ...]) -> None:
    from app.bench.headless_client import HeadlessClient

    # Each is a tab of its own, as it is in a class.
    tabs = [f"{query}&resume={secrets.token_hex(16)}".lstrip("&") for query in queries]
    visitors = [await HeadlessClient(url, query=tab, decode=False).connect(PATIENCE) for tab in tabs]
    for visitor in visitors:
        await visitor.wait_for(lambda one: one.received.frames >= WARM_UP, PATIENCE)
    pipe.send("here")
    while await asyncio.to_thread(pipe.recv) == "tell":
        pipe.send([(visitor.received.frames, visitor.received.bytes, visitor.closed is None) for visitor in visitors])
    for visitor in visitors:
        await visitor.close()


@contextmanager
def process(work: Callable[..., None], *given: Any) -> Iterator[Connection]:
    # Nothing of this process may be in the server's, whose time is measured.
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=work, args=(theirs, *given), daemon=False)
    try:
        with deaf():
            process.start()
        theirs.close()
        yield ours
        with suppress(OSError):
            ours.send("leave")
            process.join(10.0)
    finally:
        if process.pid is not None:
            process.kill()
            process.join()


def answer(pipe: Connection) -> Any:
    if not pipe.poll(PATIENCE):
        raise TimeoutError("a process of the benchmark does not answer")
    return pipe.recv()


def ask(pipe: Connection) -> Any:
    pipe.send("tell")
    return answer(pipe)


def measure_crowd(visitors: int, seconds: float, *, lecture: bool) -> dict[str, float]:
    """Return what visitors cost a server, what reaches them, and what takes the time.

    Args:
        visitors: how many at once.
        seconds: how long they are watched.
        lecture: whether they watch one stage, in the looks of `CLASS`; otherwise each has a session.

    Returns:
        CPU of the server in percent of one core, and for one update of all pages (which a busy machine changes least);
        frames a second at the average visitor and at the worst; kB a second of each; the
        percents of a core of every part of `PARTS`, and of the rest. The server's clocks cost it about half a percent.
    """
    with process(keep_house, lecture, visitors) as house:
        url = answer(house)
        queries = tuple(CLASS[i // ASIDE % len(CLASS)] if lecture else "" for i in range(visitors))
        share = [queries[i::ASIDE] for i in range(ASIDE)]
        with process(_visit, url, share[0]) as here, process(_visit, url, share[1]) as there:
            crowds = here, there
            for crowd in crowds:
                answer(crowd)
            time.sleep(SETTLING)
            (cpu, parts, _), got, begin = ask(house), [one for crowd in crowds for one in ask(crowd)], time.perf_counter()
            time.sleep(seconds)
            (cpu_end, parts_end, _), got_end = ask(house), [one for crowd in crowds for one in ask(crowd)]
            elapsed = time.perf_counter() - begin
    lost = sum(not alive for *_, alive in got_end)
    if lost:
        raise RuntimeError(f"{lost} of {visitors} visitors lost their connection while they were watched")
    frames = [(after[0] - before[0]) / elapsed for before, after in zip(got, got_end, strict=True)]
    sizes = [(after[1] - before[1]) / elapsed for before, after in zip(got, got_end, strict=True)]
    used = {part: 100.0 * (parts_end[part] - parts[part]) / elapsed for part in PARTS}
    total = 100.0 * (cpu_end - cpu) / elapsed
    return {
        "cpu_percent_of_a_core": total,
        "cpu_ms_per_frame": 10.0 * total * visitors / max(sum(frames), 1e-9),
        "frames_per_s": sum(frames) / visitors,
        "least_frames_per_s": min(frames),
        "kB_per_s": sum(sizes) / visitors / 1000.0,
        **{f"{part}_percent": value for part, value in used.items()},
        "other_percent": total - sum(used.values()),
    }


def limit_of(figures: dict[str, float]) -> str:
    """Return in words which part takes most of the server's time; "" of figures without parts."""
    parts = {name: figures.get(f"{name}_percent") for name in (*PARTS, "other")}
    known = {name: value for name, value in parts.items() if value is not None}
    total = figures.get("cpu_percent_of_a_core", 0.0)
    if not known or total <= 0.0:
        return ""
    shares = sorted(known.items(), key=lambda entry: -entry[1])
    words = ", ".join(f"{name} {100.0 * value / total:.0f} %" for name, value in shares)
    return f"of {total:.0f} % of a core: {words}"
