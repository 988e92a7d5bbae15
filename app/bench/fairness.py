"""What one visitor's actions leave for the others: a neighbour's frames while another visitor disturbs the server."""

from __future__ import annotations

import asyncio
import itertools
import time
from multiprocessing.connection import Connection
from typing import Final

from app.bench.disturbances import CLASS_SIZE, DISTURBANCES
from app.bench.headless_client import HeadlessClient
from app.bench.processes import REQUEST, TIMEOUT, process, receive, request, run_async, serve_app
from app.bench.visitors import SETTLING, WARM_UP

LEAST_FRAMES: Final = 24.0
"""A neighbour receives at least so many frames a second …"""

LONGEST_GAP: Final = 0.150
"""… and never waits longer for the next one [s]."""


async def _watch(pipe: Connection, url: str, seconds: float) -> None:
    visitor = await HeadlessClient(url, decode=False).connect(TIMEOUT)
    await visitor.wait_for(lambda one: one.received.frames >= WARM_UP, TIMEOUT)
    pipe.send("ready")
    while await asyncio.to_thread(pipe.recv) == REQUEST:
        visitor.reset_counters()
        begin = time.perf_counter()
        await asyncio.sleep(seconds)
        pipe.send((visitor.received.times, begin, time.perf_counter(), visitor.closed is None))
    await visitor.close()


async def _disturb(pipe: Connection, url: str, name: str, seconds: float) -> None:
    visitor = await HeadlessClient(url).connect(TIMEOUT)
    await visitor.wait_for(lambda one: len(one.received.times) >= WARM_UP or one.mirror.commands, TIMEOUT)
    await asyncio.sleep(SETTLING)
    pipe.send("ready")
    while await asyncio.to_thread(pipe.recv) == REQUEST:
        problem = ""
        try:
            await DISTURBANCES[name](visitor, seconds)
        except Exception as error:
            problem = f"{type(error).__name__}: {error}"
        pipe.send(problem)
    await visitor.close()


def measure_neighbour(name: str, seconds: float) -> dict[str, float]:
    """Return what a neighbour sees during one of `DISTURBANCES`.

    Args:
        seconds: duration [s].

    Returns:
        Frames a second at the neighbour, and the longest time without one [ms]; processor time of the server's longest frame [ms], which
        a busy machine changes least, and of the whole server in percent of a core; 1 if the first two are within the limits, else 0.

    Raises:
        RuntimeError: the disturbance failed, or the neighbour lost the connection.
    """
    lecture = name.endswith("lecture")
    with process(serve_app, lecture, CLASS_SIZE + 2) as server:
        url = receive(server)
        with process(run_async, _watch, url, seconds) as neighbour:
            receive(neighbour)
            with process(run_async, _disturb, url, name, seconds) as other:
                receive(other)
                cpu = request(server)[0]
                neighbour.send(REQUEST)
                problem = request(other)
                times, begin, end, alive = receive(neighbour)
                cpu_end, _, longest = request(server)
    if problem or not alive:
        raise RuntimeError(f"{name}: {problem or 'the neighbour lost the connection'}")
    stops = [begin, *times, end]
    gap = max(b - a for a, b in itertools.pairwise(stops))
    frames = len(times) / (end - begin)
    return {
        "frames_per_s": frames,
        "longest_gap_ms": 1000.0 * gap,
        "longest_work_ms": 1000.0 * longest,
        "cpu_percent_of_a_core": 100.0 * (cpu_end - cpu) / (end - begin),
        "fair": float(frames >= LEAST_FRAMES and gap <= LONGEST_GAP),
    }
