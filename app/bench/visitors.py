"""What visitors cost the server: one of them, or many at once."""

from __future__ import annotations

import asyncio
import secrets
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from multiprocessing.connection import Connection
from typing import Final

from app.bench.headless_client import HeadlessClient
from app.bench.processes import PARTS, REQUEST, TIMEOUT, process, receive, request, run_async, serve_app, used_by_tree
from app.web.server import MOVED_CODE

WARM_UP: Final = 60
"""Frames that every visitor receives before the measurement: by then their pages have been built."""

SETTLING: Final = 2.0
"""Pause before the measurement of several visitors [s]."""

SERVE_WARM_UP: Final = 3.0
"""Pause before the measurement of one visitor [s]."""

FULL_PAGE: Final = "scene=imitation&plot=follow&ghost=unprotected"
"""Link to a page with a ghost and four plots over time."""

CLASS: Final = ("", "lang=de&picture=fast", "lang=sl", "screen=1&profile=projector&theme=dark&lang=de")
"""Links of the watchers of a lecture, in turn; the server draws each of these looks separately."""

CLIENT_PROCESSES: Final = 2


@contextmanager
def _served(sessions: int = 8) -> Iterator[tuple[int, str, float]]:
    """Run `lwr-duet serve` while open; gives its process, its address, and the time that it took to say so [s]."""
    command = [sys.executable, "-m", "app", "serve", "--port", "0", "--no-open", "--store", "memory", "--sessions", str(sessions)]
    begin = time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.PIPE, encoding="utf-8") as server:
        try:
            assert server.stdout is not None
            line = server.stdout.readline()
            yield server.pid, next(word for word in line.split() if word.startswith("http")), time.perf_counter() - begin
        finally:
            server.terminate()


def measure_visitor(seconds: float, query: str = "") -> dict[str, float]:
    """Return what one visitor costs a server that was started by `lwr-duet serve`: CPU, messages, bytes and frames.

    Args:
        seconds: duration of the measurement [s].

    Returns:
        Also the time from the command until the server answers, and until the visitor has the arms [s].
    """
    with _served() as (pid, url, started):
        return {"start_s": started, **asyncio.run(_watch(url, pid, seconds, query, time.perf_counter() - started))}


async def _watch(url: str, pid: int, seconds: float, query: str, started: float) -> dict[str, float]:
    visitor = await HeadlessClient(url, query=query).connect()
    await visitor.wait_for(lambda v: v.mirror.replayed and any(name.endswith("/j7") for name in v.mirror.nodes))
    seen = time.perf_counter() - started
    await asyncio.sleep(SERVE_WARM_UP)
    visitor.reset_counters()
    cpu, begin = used_by_tree(pid).seconds, time.perf_counter()
    await asyncio.sleep(seconds)
    cpu, elapsed = used_by_tree(pid).seconds - cpu, time.perf_counter() - begin
    received = visitor.received
    figures = {
        "arms_s": seen,
        "cpu_percent_of_a_core": 100.0 * cpu / elapsed,
        "frames_per_s": received.frames / elapsed,
        "messages_per_s": received.messages.total() / elapsed,
        "kB_per_s": received.bytes / elapsed / 1000.0,
    }
    await visitor.close()
    return figures


async def _visit(pipe: Connection, url: str, queries: tuple[str, ...]) -> None:
    # Every visitor is a separate tab.
    tabs = [f"{query}&resume={secrets.token_hex(16)}".lstrip("&") for query in queries]
    visitors = [await HeadlessClient(url, query=tab, decode=False).connect(TIMEOUT) for tab in tabs]
    # Those that are sent elsewhere begin at once, not one after the other.
    visitors = list(await asyncio.gather(*(_settled(visitor, url, tab) for visitor, tab in zip(visitors, tabs, strict=True))))
    pipe.send("ready")
    while await asyncio.to_thread(pipe.recv) == REQUEST:
        pipe.send([(visitor.received.frames, visitor.received.bytes, visitor.closed is None) for visitor in visitors])
    for visitor in visitors:
        await visitor.close()


async def _settled(visitor: HeadlessClient, url: str, tab: str) -> HeadlessClient:
    """Return the visitor once it has its page; as a page does, it comes again when it is sent to another process."""
    while True:
        await visitor.wait_for(lambda one: one.received.frames >= WARM_UP or one.closed is not None, TIMEOUT)
        if visitor.closed is None or visitor.closed.rcvd is None or visitor.closed.rcvd.code != MOVED_CODE:
            return visitor
        visitor = await HeadlessClient(url, query=tab, decode=False).connect(TIMEOUT)


@contextmanager
def _crowd(url: str, queries: tuple[str, ...]) -> Iterator[Callable[[], list[tuple[int, int, bool]]]]:
    """Run visitors with these queries in their own processes while open; gives a function that counts the frames and bytes of each."""
    shares = [queries[i::CLIENT_PROCESSES] for i in range(CLIENT_PROCESSES)]
    with ExitStack() as opened:
        crowds = [opened.enter_context(process(run_async, _visit, url, share)) for share in shares]
        for crowd in crowds:
            receive(crowd)
        time.sleep(SETTLING)
        yield lambda: [one for crowd in crowds for one in request(crowd)]


def _received(before: list[tuple[int, int, bool]], after: list[tuple[int, int, bool]], elapsed: float) -> dict[str, float]:
    """Return what visitors received in a time [s].

    Raises:
        RuntimeError: a visitor lost the connection.
    """
    lost = sum(not alive for *_, alive in after)
    if lost:
        raise RuntimeError(f"{lost} of {len(after)} visitors lost their connection during the measurement")
    frames = [(new[0] - old[0]) / elapsed for old, new in zip(before, after, strict=True)]
    sizes = [(new[1] - old[1]) / elapsed for old, new in zip(before, after, strict=True)]
    return {
        "frames_per_s": sum(frames) / len(frames),
        "least_frames_per_s": min(frames),
        "kB_per_s": sum(sizes) / len(sizes) / 1000.0,
    }


def measure_sessions(sessions: int, seconds: float) -> dict[str, float]:
    """Return what visitors with a session each cost a server that was started by `lwr-duet serve`, with all its processes.

    Args:
        sessions: number of visitors at once.
        seconds: duration of the measurement [s].

    Returns:
        Processor time in percent of one core, and for one update of all pages; memory, where pages that processes share count once [MB];
        the number of processes; frames a second at the average visitor and at the slowest; kB a second of each. Processor time and memory
        are nan without /proc.

    Raises:
        RuntimeError: a visitor lost the connection.
    """
    with _served(sessions) as (pid, url, _), _crowd(url, ("",) * sessions) as count:
        used, got, begin = used_by_tree(pid), count(), time.perf_counter()
        time.sleep(seconds)
        used_end, got_end, elapsed = used_by_tree(pid), count(), time.perf_counter() - begin
    received = _received(got, got_end, elapsed)
    total = 100.0 * (used_end.seconds - used.seconds) / elapsed
    return {
        "cpu_percent_of_a_core": total,
        "cpu_ms_per_frame": 10.0 * total / max(received["frames_per_s"], 1e-9),
        "memory_MB": used_end.memory / 1e6,
        "processes": float(used_end.processes),
        **received,
    }


def measure_crowd(visitors: int, seconds: float, *, lecture: bool) -> dict[str, float]:
    """Return what visitors cost a server, what they receive, and what takes the time.

    Args:
        visitors: number of visitors at once.
        seconds: duration of the measurement [s].
        lecture: whether they watch one stage, in the looks of `CLASS`; otherwise each has a session.

    Returns:
        CPU of the server in percent of one core, and for one update of all pages (which a busy machine changes least);
        frames a second at the average visitor and at the worst; kB a second of each; the
        percents of a core of every part of `PARTS`, and of the rest. The server's clocks cost it about half a percent.

    Raises:
        RuntimeError: a visitor lost the connection.
    """
    with process(serve_app, lecture, visitors) as server:
        url = receive(server)
        queries = tuple(CLASS[i // CLIENT_PROCESSES % len(CLASS)] if lecture else "" for i in range(visitors))
        with _crowd(url, queries) as count:
            (cpu, parts, _), got, begin = request(server), count(), time.perf_counter()
            time.sleep(seconds)
            (cpu_end, parts_end, _), got_end, elapsed = request(server), count(), time.perf_counter() - begin
    received = _received(got, got_end, elapsed)
    used = {part: 100.0 * (parts_end[part] - parts[part]) / elapsed for part in PARTS}
    total = 100.0 * (cpu_end - cpu) / elapsed
    return {
        "cpu_percent_of_a_core": total,
        "cpu_ms_per_frame": 10.0 * total / max(received["frames_per_s"], 1e-9),
        **received,
        **{f"{part}_percent": value for part, value in used.items()},
        "other_percent": total - sum(used.values()),
    }
