"""Server costs of many simultaneous visitors."""

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
"""Frames per visitor before the measurement, until the pages are built."""

SETTLING: Final = 2.0
"""Pause before a measurement of several visitors [s]."""

CLASS: Final = ("", "lang=de&picture=fast", "lang=sl", "screen=1&profile=projector&theme=dark&lang=de")
"""Queries of a lecture's watchers, in turn; the server draws each look separately."""

WATCHERS: Final = 30
"""Watchers of the measured lecture."""

SESSIONS: Final = 8
"""Private sessions in the measurement by parts of the server's time."""

T = TypeVar("T")


def measure_crowds(seconds: float) -> BenchRows:
    """Costs of a lecture and of private sessions, by parts of the server's time; `seconds` [s] each."""
    yield f"lecture with {WATCHERS} watchers", measure_crowd(WATCHERS, seconds, lecture=True)
    yield f"{SESSIONS} private sessions", measure_crowd(SESSIONS, seconds, lecture=False)


def measure_capacity(sessions: Iterable[int], seconds: float) -> BenchRows:
    """Costs of each number of private sessions in `lwr-duet serve`; `seconds` [s] each."""
    for count in sessions:
        yield f"{count} private sessions", measure_sessions(count, seconds)


async def _settled(visitor: HeadlessClient, url: str, tab: str) -> HeadlessClient:
    """The visitor with a complete page. Like a page, it reconnects when sent to another process."""
    while True:
        await visitor.wait_for(lambda one: one.received.frames >= WARM_UP or one.closed is not None, TIMEOUT)
        if visitor.closed is None or visitor.closed.rcvd is None or visitor.closed.rcvd.code != MOVED_CODE:
            return visitor
        visitor = await HeadlessClient(url, query=tab, decode=False).connect(TIMEOUT)


async def _crowd(
    url: str, queries: tuple[str, ...], seconds: float, used: Callable[[], T]
) -> tuple[T, T, float, dict[str, float]]:
    """Measure visitors with these queries, each in its own tab.

    Args:
        seconds: duration of the measurement after all pages are complete [s].
        used: gives the server's use so far.

    Returns:
        Use at the beginning and at the end, the time between [s], and the visitors' received data.

    Raises:
        RuntimeError: a visitor lost the connection.
    """
    tabs = [f"{query}&resume={secrets.token_hex(16)}".lstrip("&") for query in queries]
    visitors = [await HeadlessClient(url, query=tab, decode=False).connect(TIMEOUT) for tab in tabs]
    # Redirected visitors reconnect at once, not one after the other.
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
    """Cost of visitors with private sessions for all processes of `lwr-duet serve`.

    Args:
        sessions: number of simultaneous visitors.
        seconds: duration of the measurement [s].

    Returns:
        CPU time in percent of one core, and per update of all pages (both nan without /proc); memory with
        shared pages counted once [MB] (nan without /proc); number of processes; frames per second of the
        average and of the slowest visitor; kB per second of each.

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
    """Cost of visitors, received data, and parts of the server's time.

    Args:
        visitors: number of simultaneous visitors.
        seconds: duration of the measurement [s].
        lecture: True: they watch one lecture, in the looks of `CLASS`; False: each has a session.

    Returns:
        CPU in percent of one core, and per update of all pages (least affected by a busy machine); frames per
        second of the average and of the slowest visitor; kB per second of each; percent of a core for every
        part of `PARTS` and for the rest. The server's clocks cost about half a percent.

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
