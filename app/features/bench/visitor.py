"""Cost of one visitor for the server."""

from __future__ import annotations

import asyncio
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Final

from app.features.bench.process_use import used_by_tree
from app.features.store import IN_MEMORY
from app.web.headless_client import HeadlessClient
from controllers.own_packages import own_command
from scenes.children import child_environment

SERVE_WARM_UP: Final = 3.0
"""Pause before a measurement [s]."""

FULL_PAGE: Final = "scene=imitation&plot=follow&ghost=unprotected"
"""Query of a page with a ghost and four plots."""


@contextmanager
def serving(sessions: int = 8) -> Iterator[tuple[int, str, float]]:
    """Run `lwr-duet serve` while open; gives process id, address, and start-up time [s]."""
    options = ("--port", "0", "--no-open", *IN_MEMORY, "--sessions", str(sessions))
    command = own_command("app.__main__", "serve", *options)
    begin = time.perf_counter()
    with ExitStack() as opened:
        # Ctrl+C ends this command, which ends the server; a half-started server would report an error.
        with child_environment():
            server = opened.enter_context(subprocess.Popen(command, stdout=subprocess.PIPE, encoding="utf-8"))
            opened.callback(server.terminate)
        assert server.stdout is not None
        line = server.stdout.readline()
        yield (
            server.pid,
            next(word for word in line.split() if word.startswith("http")),
            time.perf_counter() - begin,
        )


def measure_visitor(seconds: float, query: str = "") -> dict[str, float]:
    """Cost of one visitor for `lwr-duet serve`: CPU, messages, bytes and frames.

    `seconds`: duration [s]. Also the times from the command to the first answer and to the visitor's arms
    [s].
    """
    with serving() as (pid, url, started):
        return {
            "start_s": started,
            **asyncio.run(_watch(url, pid, seconds, query, time.perf_counter() - started)),
        }


async def _watch(url: str, pid: int, seconds: float, query: str, started: float) -> dict[str, float]:
    visitor = await HeadlessClient(url, query=query).connect()
    await visitor.wait_for(
        lambda v: v.mirror.replayed and any(name.endswith("/j7") for name in v.mirror.nodes)
    )
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
