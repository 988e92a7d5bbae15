"""A long class with failures: `python -m tests.app.features.workers.survival --sessions 30 --minutes 10`
prints figures and ends with 1 after a loss.

Visitors in private sessions pull the arm and change the experiment while each worker is killed once, all
workers are renewed, connections break during a pull, and many tabs open and close. With `--kills 200` they
rest instead, act once, and all workers are killed at least two seconds later, until that number is reached.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import random
import signal
import sys
import tempfile
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import Final

from websockets.exceptions import WebSocketException

from app.settings import Settings
from scenes.settings import specs
from tests.app.features.workers.rests import kill_after_rests
from tests.app.features.workers.served import Served
from tests.blocking_client import OperatingClient

EXPERIMENTS: Final = ("master_slave", "hold", "ball", "imitation", "solo")
PLACE: Final = (0.3, 0.0, 1.0)
ACTIVE: Final = 3
"""One visitor in this number acts; others watch their autopilot, and their messages are not decoded."""


def memory(served: Served) -> float:
    """Memory of the server's processes, shared pages counted once [MB]."""
    total = 0
    for pid in (served.process.pid, *served.children("")):
        with suppress(OSError):
            rollup = Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="utf-8").splitlines()
            total += sum(int(line.split()[1]) for line in rollup if line.startswith("Pss:"))
    return total / 1000.0


@dataclass
class Tab:
    """One tab, which reconnects whenever its connection ends.

    Attributes:
        away: times without frames after each end of a connection [s].
        frames: number of frames received.
    """

    url: str
    number: int
    away: list[float] = field(default_factory=list)
    frames: int = 0
    client: OperatingClient | None = None

    async def live(self, until: float) -> None:
        chance = random.Random(self.number)
        acts = self.number % ACTIVE == 0
        lost: float | None = None
        while perf_counter() < until:
            client = OperatingClient(self.url, query=f"resume={self.number:032d}", decode=acts)
            try:
                await client.connect(60.0)
                await client.wait_for(lambda one: one.closed is not None or one.received.frames >= 3, 120.0)
                if lost is not None:
                    self.away.append(perf_counter() - lost)
                self.client, lost = client, None
                while perf_counter() < until and client.closed is None:
                    await asyncio.sleep(chance.uniform(0.5, 2.0))
                    if acts and client.closed is None:
                        await self.act(client, chance)
            except (OSError, WebSocketException, TimeoutError):
                pass
            self.client = None
            self.frames += client.received.frames
            lost = perf_counter() if lost is None else lost
            if perf_counter() < until:
                # As viser's client does.
                await asyncio.sleep(0.2)
            with suppress(Exception):
                await client.close()

    async def act(self, client: OperatingClient, chance: random.Random) -> None:
        """Pull the arm for a second or choose another experiment."""
        with suppress(KeyError, LookupError, ValueError):
            if chance.random() < 0.3:
                spec = specs(Settings)["scene"]
                label = spec.options()[chance.choice(EXPERIMENTS)]
                await client.set_value(spec.title(), label)
                return
            node = max(client.mirror.grabbable, key=len)
            await client.pull(node, "start", PLACE, PLACE)
            for _ in range(20):
                to = [value + chance.uniform(-0.15, 0.15) for value in PLACE]
                await client.pull(node, "update", PLACE, to)
                await asyncio.sleep(0.05)
            await client.pull(node, "end", PLACE, PLACE)


async def come_and_go(url: str, times: int) -> int:
    """Open and close tabs, ten at a time. Returns the number of tabs that received the page."""
    seen = 0
    for first in range(0, times, 10):
        tabs = [
            OperatingClient(url, query=f"resume={10**6 + first + k:032d}", decode=False)
            for k in range(min(10, times - first))
        ]
        for tab in tabs:
            with suppress(OSError, WebSocketException, TimeoutError):
                await tab.connect(60.0)
                await tab.wait_for(lambda one: one.received.frames >= 1, 120.0)
                seen += 1
        for tab in tabs:
            await tab.close()
    return seen


async def drop_lines(tabs: list[Tab], count: int) -> int:
    """Break connections during a pull. Returns their number."""
    dropped = 0
    for tab in [one for one in tabs if one.number % ACTIVE == 0] * 8:
        client = tab.client
        if dropped < count and client is not None and client.closed is None and client.mirror.grabbable:
            with suppress(Exception):
                await client.pull(max(client.mirror.grabbable, key=len), "start", PLACE, PLACE)
            await client.break_off()
            dropped += 1
            await asyncio.sleep(1.0)
    return dropped


def worst(tabs: list[Tab]) -> str:
    """Longest absence of the tabs since the last call, as text."""
    away = [seconds for tab in tabs for seconds in tab.away]
    for tab in tabs:
        tab.away.clear()
    return f"{len(away)} tabs were away, at most {max(away, default=0.0):.1f} s"


async def survive(
    served: Served, sessions: int, minutes: float, lines: int = 15, visits: int = 200
) -> list[str]:
    """Losses, as text.

    Args:
        sessions: simultaneous visitors.
        minutes: length of the visit.
        lines: connections broken during a pull.
        visits: tabs that open and close meanwhile.
    """
    tabs = [Tab(served.url, number) for number in range(sessions)]
    begin = perf_counter()
    lives = [asyncio.create_task(tab.live(begin + 60.0 * minutes)) for tab in tabs]
    used: list[float] = []

    def report(text: str) -> None:
        print(f"{(perf_counter() - begin) / 60.0:5.1f} min  {text}", flush=True)

    async def reach(share: float) -> None:
        """Wait until this share of the time has passed, and note the memory once a minute."""
        while (now := (perf_counter() - begin) / 60.0) < share * minutes:
            if now >= len(used):
                used.append(memory(served))
                report(
                    f"{used[-1]:.0f} MB, {served.health()['clients']} tabs at {len(served.workers)} workers"
                )
            await asyncio.sleep(1.0)

    await reach(0.1)
    victims = served.workers
    for number, pid in enumerate(victims, 1):
        worst(tabs)
        os.kill(pid, signal.SIGKILL)
        report(f"a worker of {len(victims)} is killed")
        await reach(0.1 + 0.15 * number / len(victims))
        report(worst(tabs))
    served.process.send_signal(signal.SIGUSR1)
    report("all workers are renewed")
    await reach(0.3)
    report(worst(tabs))
    report(f"{await drop_lines(tabs, lines)} lines have broken off in the middle of a pull")
    report(worst(tabs))
    report(f"{await come_and_go(served.url, visits)} of {visits} tabs came and went")
    # The rest shows the growth of the memory: every run keeps its last ten minutes.
    await reach(1.0)
    await asyncio.gather(*lives)
    seconds = perf_counter() - begin
    report(
        f"{worst(tabs)}; the slowest had {min(tab.frames for tab in tabs) / seconds:.1f} frames/s on average"
    )
    said = served.said()
    wrong = [line for line in said.splitlines() if "ERROR" in line or "Traceback" in line]
    return wrong + ([] if all(tab.frames for tab in tabs) else ["a tab has never received a frame"])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sessions", type=int, default=30)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--workers", default="auto")
    parser.add_argument("--kills", type=int, default=0)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        served = Served(
            Path(folder), "--workers", arguments.workers, "--sessions", str(arguments.sessions + 12)
        )
        try:
            if arguments.kills:
                rests = kill_after_rests(served, Path(folder) / "store", arguments.kills, arguments.sessions)
                lost = asyncio.run(rests)
            else:
                lost = asyncio.run(survive(served, arguments.sessions, arguments.minutes))
        finally:
            served.close()
    for line in lost:
        print(f"LOST {line}")
    return bool(lost)


if __name__ == "__main__":
    sys.exit(main())
