"""Visitors rest and act once, then their workers are killed: data older than 2 s must be in the store."""

from __future__ import annotations

import asyncio
import json
import os
import random
import re
import signal
import time
from collections import Counter
from contextlib import closing, suppress
from pathlib import Path
from typing import Final

from websockets.exceptions import WebSocketException

from app.features.lessons.progress import StepProgress
from app.features.store.record_bytes import visitor_from_bytes
from app.features.store.store_file import StoreFile
from app.hosting.visitor_record import VisitorRecord
from app.page.panels.hotkeys import hotkeys
from app.plots.curve_chart import COLUMNS
from tests.app.features.lessons.helpers import progress_in
from tests.app.features.workers.served import Served
from tests.app.page.helpers import bodies, buttons, shown
from tests.blocking_client import OperatingClient

ALLOWED: Final = 2.0
"""Largest age of data that a kill may lose [s]."""

RESTS: Final = (3.0, 60.0)
KILLED_AFTER: Final = (ALLOWED, ALLOWED + 3.0)
"""Shortest and longest rest, and time from an action to the kill [s]."""

LINKS: Final = {
    "answer": "lesson=3&step=2",
    "words": "lesson=3&step=2",
    "curve": "lesson=4&step=2",
    "pull": "autopilot=0",
}
PLACE: Final = (0.3, 0.0, 1.0)


class RestingVisitor:
    """A tab that acts once after a rest.

    Attributes:
        acted: time of the action [s since 1970].
    """

    def __init__(self, url: str, kind: str, tab: str) -> None:
        self.kind, self.tab, self.acted = kind, tab, 0.0
        self._address = url, f"{LINKS[kind]}&resume={tab}"
        self.client = OperatingClient(url)

    async def come(self) -> None:
        """Connect, repeatedly if needed, until the page is complete; pause the run before a later pull."""
        while self.client.closed is not None or not self._is_ready():
            await self.client.close()
            self.client = OperatingClient(self._address[0], query=self._address[1])
            with suppress(OSError, WebSocketException):
                await self.client.connect(60.0)
                await self.client.wait_for(lambda one: one.closed is not None or self._is_ready(), 240.0)
        if self.kind == "pull":
            await self._press("pause")

    def _is_ready(self) -> bool:
        client = self.client
        match self.kind:
            case "answer":
                return any(label.startswith("2 ") for label in buttons(client))
            case "words":
                return bool(self._boxes("Because …"))
            case "curve":
                return "data-at=" in shown(client)
            case _:
                return len(client.mirror.commands) >= 14 and bool(client.mirror.grabbable)

    def _boxes(self, label: str) -> list[str]:
        found = [element for element in self.client.mirror.gui.values() if element.get("label") == label]
        return [str(element["uuid"]) for element in found if element.get("visible", True)]

    async def _press(self, action: str) -> None:
        text = next(one.text for one in hotkeys() if one.name == action).capitalize()
        uuid = next(uuid for uuid, command in self.client.mirror.commands.items() if command["label"] == text)
        await self.client.send({"type": "CommandTriggerMessage", "uuid": uuid})

    async def _type(self, label: str, text: str) -> None:
        await self.client.send(
            {"type": "GuiUpdateMessage", "uuid": self._boxes(label)[0], "updates": {"value": text}}
        )

    async def act(self) -> None:
        match self.kind:
            case "answer":
                labels = [str(one["label"]) for one in bodies(self.client, "GuiButtonMessage")]
                await self.client.click(next(label for label in labels if re.search(r"^\W*2 ", label)))
            case "words":
                await self._type("Because …", self.tab)
            case "curve":
                place = re.findall(r'data-at="([^"]+)"', shown(self.client))[0]
                await self._type("drawing", f"{place} {json.dumps([0.5] * COLUMNS)}")
            case _:
                await self._press("pause")
                await self._pull()
        self.acted = time.time()

    async def _pull(self) -> None:
        node = max(self.client.mirror.grabbable, key=len)
        await self.client.pull(node, "start", PLACE, PLACE)
        for step in range(20):
            await self.client.pull(node, "update", PLACE, (PLACE[0] + 0.005 * step, *PLACE[1:]))
            await asyncio.sleep(0.05)
        await self.client.pull(node, "end", PLACE, PLACE)

    def is_in(self, saved: float, record: VisitorRecord) -> bool:
        """True if a record has the visitor's action. `saved`: time of writing [s since 1970]."""
        if self.kind == "pull":
            return saved >= self.acted and record.state is not None and record.state.run.snapshot.steps > 0
        progress = progress_in(record)
        return any(self._is_of(done) for done in progress.steps.values())

    def _is_of(self, done: StepProgress) -> bool:
        match self.kind:
            case "answer":
                return done.choice == 1
            case "words":
                return done.because == self.tab
            case _:
                return len(done.drawing) == COLUMNS


def stored(path: Path, tab: str) -> tuple[float, VisitorRecord] | None:
    with closing(StoreFile(path, 10**9)) as file:
        found = file.read(tab)
    return None if found is None else (found[0], visitor_from_bytes(found[1]))


async def kill_after_rests(served: Served, store: Path, kills: int, sessions: int) -> list[str]:
    """Repeatedly kill all workers after all visitors have rested and acted once. Returns the lost actions."""
    chance, lost, acts, killed, number = random.Random(kills), [], Counter[str](), 0, 0
    begin = time.perf_counter()
    while killed < kills:
        rest = RESTS[0] * (RESTS[1] / RESTS[0]) ** chance.random()
        kinds = [list(LINKS)[(number + k) % len(LINKS)] for k in range(sessions)]
        visitors = [RestingVisitor(served.url, kind, f"{number + k:032d}") for k, kind in enumerate(kinds)]
        number += sessions
        try:
            await asyncio.gather(*(one.come() for one in visitors))
            await asyncio.sleep(rest)
            await asyncio.gather(*(one.act() for one in visitors))
            await asyncio.sleep(
                max(one.acted for one in visitors) + chance.uniform(*KILLED_AFTER) - time.time()
            )
            victims = served.workers
            for pid in victims:
                os.kill(pid, signal.SIGKILL)
        finally:
            for one in visitors:
                with suppress(Exception):
                    await one.client.close()
        killed += len(victims)
        for one in visitors:
            acts[one.kind] += 1
            found = stored(store, one.tab)
            if found is None or not one.is_in(*found):
                lost.append(f"{one.kind} after a rest of {rest:.1f} s")
        print(
            f"{(time.perf_counter() - begin) / 60.0:5.1f} min  {killed} workers killed, {sum(acts.values())} acts "
            f"({', '.join(f'{count} {kind}' for kind, count in acts.items())}), {len(lost)} lost; rested {rest:.1f} s",
            flush=True,
        )
    return lost
