"""What many visitors at once cost the server."""

from __future__ import annotations

import asyncio
import secrets
import time
from collections.abc import Callable, Iterable
from typing import Final, TypeVar

from app.features.bench.figures_table import BenchRows
from app.features.bench.process_use import used_by_tree
from app.features.bench.visitor import serving
from app.web.headless_client import HeadlessClient
from app.web.server import MOVED_CODE
from tests.tools.bench.processes import PARTS, TIMEOUT, process, receive, request, serve_app

WARM_UP: Final = 60
"""Frames that every visitor receives before the measurement: by then their pages have been built."""

SETTLING: Final = 2.0
"""Pause before the measurement of several visitors [s]."""

CLASS: Final = ("", "lang=de&picture=fast", "lang=sl", "screen=1&profile=projector&theme=dark&lang=de")
"""Links of the watchers of a lecture, in turn; the server draws each of these looks separately."""

WATCHERS: Final = 30
"""Watchers of the measured lecture."""

SESSIONS: Final = 8
"""Private sessions whose server is measured by parts of its time."""

T = TypeVar("T")


def measure_crowds(seconds: float) -> BenchRows:
    """Yield what a lecture and private sessions cost, with the parts of the server's time. `seconds`: duration of each [s]."""
    yield f"lecture with {WATCHERS} watchers", measure_crowd(WATCHERS, seconds, lecture=True)
    yield f"{SESSIONS} private sessions", measure_crowd(SESSIONS, seconds, lecture=False)


def measure_capacity(sessions: Iterable[int], seconds: float) -> BenchRows:
    """Yield what each number of private sessions costs `lwr-duet serve`.

    Args:
        seconds: duration of each [s].
    """
    for count in sessions:
        yield f"{count} private sessions", measure_sessions(count, seconds)


async def _settled(visitor: HeadlessClient, url: str, tab: str) -> HeadlessClient:
    """Return the visitor once it has its page; as a page does, it comes again when it is sent to another process."""
    while True:
        await visitor.wait_for(lambda one: one.received.frames >= WARM_UP or one.closed is not None, TIMEOUT)
        if visitor.closed is None or visitor.closed.rcvd is None or visitor.closed.rcvd.code != MOVED_CODE:
            return visitor
        visitor = await HeadlessClient(url, query=tab, decode=False).connect(TIMEOUT)


async def _crowd(
    url: str, queries: tuple[str, ...], seconds: float, used: Callable[[], T]
) -> tuple[T, T, float, dict[str, float]]:
    """Have visitors with these queries, each a separate tab.

    Args:
        seconds: how long they are measured once all have their pages [s].
        used: asked what the server has used so far.

    Returns:
        What it had used at the beginning and at the end, the time between [s], and what the visitors received.

    Raises:
        RuntimeError: a visitor lost the connection.
    """
    tabs = [f"{query}&resume={secrets.token_hex(16)}".lstrip("&") for query in queries]
    visitors = [await HeadlessClient(url, query=tab, decode=False).connect(TIMEOUT) for tab in tabs]
    # Those that are sent elsewhere begin at once, not one after the other.
    visitors = list(
        await asyncio.gather(
            *(_settled(visitor, url, tab) for visitor, tab in zip(visitors, tabs, strict=True))
        )
    )
    await asyncio.sleep(SETTLING)
    for visitor in visitors:
        visitor.reset_counters()
    before, begin = used(), time.perf_counter()
    await asyncio.sleep(seconds)
    after, elapsed = used(), time.perf_counter() - begin
    lost = sum(visitor.closed is not None for visitor in visitors)
    if lost:
        raise RuntimeError(f"{lost} of {len(visitors)} visitors lost their connection during the measurement")
    frames = [visitor.received.frames / elapsed for visitor in visitors]
    received = {
        "frames_per_s": sum(frames) / len(frames),
        "least_frames_per_s": min(frames),
        "kB_per_s": sum(visitor.received.bytes for visitor in visitors) / len(visitors) / elapsed / 1000.0,
    }
    for visitor in visitors:
        await visitor.close()
    return before, after, elapsed, received


def measure_sessions(sessions: int, seconds: float) -> dict[str, float]:
    """Cost of visitors with a session each to a server that was started by `lwr-duet serve`, with all its processes.

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
    with serving(sessions) as (pid, url, _):
        crowd = _crowd(url, ("",) * sessions, seconds, lambda: used_by_tree(pid))
        used, used_end, elapsed, received = asyncio.run(crowd)
    total = 100.0 * (used_end.seconds - used.seconds) / elapsed
    return {
        "cpu_percent_of_a_core": total,
        "cpu_ms_per_frame": 10.0 * total / max(received["frames_per_s"], 1e-9),
        "memory_MB": used_end.memory / 1e6,
        "processes": float(used_end.processes),
        **received,
    }


def measure_crowd(visitors: int, seconds: float, *, lecture: bool) -> dict[str, float]:
    """Cost of visitors to a server, what they receive, and what takes the time.

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
        queries = tuple(CLASS[i % len(CLASS)] if lecture else "" for i in range(visitors))
        crowd = _crowd(url, queries, seconds, lambda: request(server))
        (cpu, parts, _), (cpu_end, parts_end, _), elapsed, received = asyncio.run(crowd)
    used = {part: 100.0 * (parts_end[part] - parts[part]) / elapsed for part in PARTS}
    total = 100.0 * (cpu_end - cpu) / elapsed
    return {
        "cpu_percent_of_a_core": total,
        "cpu_ms_per_frame": 10.0 * total / max(received["frames_per_s"], 1e-9),
        **received,
        **{f"{part}_percent": value for part, value in used.items()},
        "other_percent": total - sum(used.values()),
    }
