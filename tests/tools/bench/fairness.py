"""Fairness between visitors: a neighbour's frames while another visitor disturbs the server."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import secrets
import time
from collections.abc import Awaitable, Callable, Iterable, Iterator
from functools import partial
from multiprocessing.connection import Connection
from typing import Any, Final

import msgspec

from app.page.panels.hotkeys import hotkeys
from app.settings import TRANSLATIONS, Settings
from app.web.headless_client import HeadlessClient
from scenes.settings import specs
from tests.tools.bench.crowds import WARM_UP
from tests.tools.bench.processes import REQUEST, TIMEOUT, process, receive, request, run_async, serve_app

FLOOD_RATE: Final = 600.0
"""Messages per second; the server's limit for one browser."""

REBUILD_RATE: Final = 30.0
"""Changes per second that rebuild the page."""

HEAVY_BYTES: Final = 15_000_000
"""Size of a heavy message [B]."""

HEAVY_COUNT: Final = 5
CLASS_SIZE: Final = 36
ENTRY_SECONDS: Final = 4.0
"""Arrival time of a whole class [s]."""


async def _paced(rate: float, seconds: float, send: Callable[[int], Awaitable[None]]) -> None:
    begin = time.perf_counter()
    for number in range(round(rate * seconds)):
        await send(number)
        ahead = begin + (number + 1) / rate - time.perf_counter()
        # No pause after a late message, so that the mean rate is correct.
        await asyncio.sleep(max(ahead, 0.0))


def _value(uuid: str, value: object) -> dict[str, Any]:
    """Message that sets a control's value."""
    return {"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}}


async def _set(
    visitor: HeadlessClient,
    seconds: float,
    key: str,
    choices: tuple[object, ...] = (),
    rate: float = FLOOD_RATE,
) -> None:
    """Set a control to `choices` in turn; without them, to all its own choices."""
    spec = specs(Settings)[key]
    given = choices or tuple(choice for choice in spec.choices if choice != "own")
    values = [spec.options()[str(choice)] for choice in given] if spec.choices else given
    uuid = visitor.mirror.labelled(spec.title())["uuid"]
    await _paced(rate, seconds, lambda number: visitor.send(_value(uuid, values[number % len(values)])))


async def _change_language(visitor: HeadlessClient, seconds: float) -> None:
    """Choose the languages in turn; each rebuilds the page, including the control."""
    spec = specs(Settings)["lang"]
    languages = itertools.cycle((*TRANSLATIONS, "en"))

    async def send(_: int) -> None:
        label = spec.options()[next(languages)]
        control = next((e for e in visitor.mirror.gui.values() if label in (e.get("options") or ())), None)
        if control is not None:
            await visitor.send(_value(control["uuid"], label))

    await _paced(REBUILD_RATE, seconds, send)


async def _press_key(visitor: HeadlessClient, seconds: float, shown: str) -> None:
    title = next(hotkey.title for hotkey in hotkeys() if hotkey.shown == shown)
    uuid = next(uuid for uuid, command in visitor.mirror.commands.items() if command["label"] == title)
    await _paced(FLOOD_RATE, seconds, lambda _: visitor.send({"type": "CommandTriggerMessage", "uuid": uuid}))


async def _press_button(visitor: HeadlessClient, seconds: float, label: str) -> None:
    """Press a button, also after a change of its label."""
    uuid = visitor.mirror.labelled(label, "GuiButtonMessage")["uuid"]
    await _paced(FLOOD_RATE, seconds, lambda _: visitor.send(_value(uuid, True)))


async def _press_row(visitor: HeadlessClient, seconds: float, option: str) -> None:
    row = next(e for e in visitor.mirror.gui.values() if option in (e.get("options") or ()))

    async def press(number: int) -> None:
        # The labels change, as the chosen one is marked.
        value = row["options"][number % len(row["options"])]
        await visitor.send(_value(row["uuid"], value))

    await _paced(FLOOD_RATE, seconds, press)


async def _drag(visitor: HeadlessClient, seconds: float) -> None:
    """Pull the last link of the visitor's arm to and fro."""
    name = max(visitor.mirror.grabbable, key=len)
    x, y, z = place = (0.3, 0.0, 1.0)
    await visitor.pull(name, "start", place, place)
    await _paced(
        FLOOD_RATE, seconds, lambda i: visitor.pull(name, "update", place, (x + 0.1 * (i % 2), y, z))
    )
    await visitor.pull(name, "end", place, place)


async def _send_heavy(visitor: HeadlessClient, seconds: float, content: bytes) -> None:
    """Send a control a large msgpack value, each time over a new connection."""
    uuid = visitor.mirror.labelled("robot")["uuid"]
    head = msgspec.msgpack.encode(_value(uuid, None))
    assert head.endswith(b"\xc0")
    message = head[:-1] + content

    async def send_one(_: int) -> None:
        other = await HeadlessClient(visitor.url, decode=False).connect(TIMEOUT)
        with contextlib.suppress(Exception):
            # The server closes the connection during the message.
            await other.send_raw(message)
        others.append(other)

    others: list[HeadlessClient] = []
    await _paced(HEAVY_COUNT / seconds, seconds, send_one)
    for other in others:
        with contextlib.suppress(Exception):
            await other.close()


async def _enter_class(visitor: HeadlessClient, seconds: float, query: str = "") -> None:
    """Open a class's pages by one link, evenly within `ENTRY_SECONDS`."""
    pages: list[HeadlessClient] = []

    async def open_page(_: int) -> None:
        # Each is a separate tab, as in a class.
        tab = f"{query}&resume={secrets.token_hex(16)}".lstrip("&")
        pages.append(await HeadlessClient(visitor.url, query=tab, decode=False).connect(TIMEOUT))

    await _paced(CLASS_SIZE / ENTRY_SECONDS, ENTRY_SECONDS, open_page)
    await asyncio.sleep(max(seconds - ENTRY_SECONDS, 0.0))
    for page in pages:
        await page.close()


DISTURBANCES: Final[dict[str, Callable[[HeadlessClient, float], Awaitable[None]]]] = {
    "nothing": lambda _, seconds: asyncio.sleep(seconds),
    "600/s of a slider": partial(_set, key="dm", choices=(100.0, 150.0)),
    "600/s of a box": partial(_set, key="autopilot", choices=(True, False)),
    "600/s of the law": partial(_set, key="law"),
    "600/s of the ghost": partial(_set, key="ghost"),
    "600/s of the plots": partial(_press_row, option="λ(d)"),
    "600/s of the hand": _drag,
    "600/s of a single step": partial(_press_key, shown="."),
    "600/s of a reset": partial(_press_key, shown="R"),
    "600/s of the guided arm": partial(_set, key="guided"),
    "600/s of the scenes": partial(_set, key="scene"),
    "600/s of the lessons": partial(_press_button, label="Lessons"),
    "30/s of the scenes": partial(_set, key="scene", rate=REBUILD_RATE),
    "30/s of the robots": partial(_set, key="robot", choices=("lwr", "panda", "ur5"), rate=REBUILD_RATE),
    "30/s of the rigs": partial(_set, key="rig", rate=REBUILD_RATE),
    "30/s of the languages": _change_language,
    "five lists of 15 MB": partial(
        _send_heavy, content=b"\xdd" + HEAVY_BYTES.to_bytes(4, "big") + bytes(HEAVY_BYTES)
    ),
    "five texts of 15 MB": partial(
        _send_heavy, content=b"\xdb" + HEAVY_BYTES.to_bytes(4, "big") + b"a" * HEAVY_BYTES
    ),
    "a class of 36 in 4 s, a lesson each": partial(_enter_class, query="lesson=1"),
    "a class of 36 in 4 s, a run each": _enter_class,
    "a class of 36 in 4 s, lecture": _enter_class,
}
"""Name → action of the other visitor for a number of seconds."""


LEAST_FRAMES: Final = 24.0
"""Least frame rate of a neighbour [1/s]."""

LONGEST_GAP: Final = 0.150
"""Longest time between two frames of a neighbour [s]."""

SETTLED: Final = 10
"""Frames of the other visitor before the disturbance, until the page is built."""


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


async def _disturb(pipe: Connection, url: str, names: tuple[str, ...], seconds: float) -> None:
    """Make the disturbances in turn, each by a new visitor."""
    for name in names:
        visitor = await HeadlessClient(url).connect(TIMEOUT)
        # In a lecture only the lecturer has commands.
        await visitor.wait_for(lambda one: one.received.frames >= WARM_UP or one.mirror.commands, TIMEOUT)
        visitor.reset_counters()
        await visitor.wait_for(lambda one: one.received.frames >= SETTLED, TIMEOUT)
        pipe.send("ready")
        await asyncio.to_thread(pipe.recv)
        problem = ""
        try:
            await DISTURBANCES[name](visitor, seconds)
        except Exception as error:
            problem = f"{type(error).__name__}: {error}"
        await visitor.close()
        pipe.send(problem)


def measure_fairness(
    seconds: float, names: Iterable[str] = tuple(DISTURBANCES)
) -> Iterator[tuple[str, dict[str, float]]]:
    """A neighbour's figures during each of `DISTURBANCES`, by name, as they are measured.

    Consecutive disturbances of the same kind (lecture or not) share a server.

    Args:
        seconds: duration of each [s].

    Yields:
        The neighbour's frames per second, and the longest time without one [ms]; CPU time of the server's
        longest frame [ms] (least affected by a busy machine), and of the whole server in percent of a core; 1
        if the first two are within the limits, else 0.

    Raises:
        RuntimeError: the disturbance failed, or the neighbour lost the connection.
    """
    for lecture, together in itertools.groupby(names, lambda name: name.endswith("lecture")):
        served = tuple(together)
        with process(serve_app, lecture, CLASS_SIZE + 2) as server:
            url = receive(server)
            with (
                process(run_async, _watch, url, seconds) as neighbour,
                process(run_async, _disturb, url, served, seconds) as other,
            ):
                receive(neighbour)
                for name in served:
                    yield name, _measured(name, server, neighbour, other)


def _measured(name: str, server: Connection, neighbour: Connection, other: Connection) -> dict[str, float]:
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
