"""What one visitor's actions leave for the others: a neighbour's frames while another visitor disturbs the server."""

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
"""Messages a second; the server reads no more of one browser."""

REBUILD_RATE: Final = 30.0
"""Changes a second that rebuild the page."""

HEAVY_BYTES: Final = 15_000_000
"""Size of a heavy message."""

HEAVY_COUNT: Final = 5
CLASS_SIZE: Final = 36
ENTRY_SECONDS: Final = 4.0
"""Time in which a whole class arrives [s]."""


async def _paced(rate: float, seconds: float, send: Callable[[int], Awaitable[None]]) -> None:
    begin = time.perf_counter()
    for number in range(round(rate * seconds)):
        await send(number)
        ahead = begin + (number + 1) / rate - time.perf_counter()
        # A late message is not followed by a pause, so that the mean rate is right.
        await asyncio.sleep(max(ahead, 0.0))


def _value(uuid: str, value: object) -> dict[str, Any]:
    """Return the message that gives a control a value."""
    return {"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}}


async def _set(
    visitor: HeadlessClient,
    seconds: float,
    key: str,
    choices: tuple[object, ...] = (),
    rate: float = FLOOD_RATE,
) -> None:
    """Set a control to the values in turn; without choices, to all of its own."""
    spec = specs(Settings)[key]
    given = choices or tuple(choice for choice in spec.choices if choice != "own")
    values = [spec.options()[str(choice)] for choice in given] if spec.choices else given
    uuid = visitor.mirror.labelled(spec.title())["uuid"]
    await _paced(rate, seconds, lambda number: visitor.send(_value(uuid, values[number % len(values)])))


async def _change_language(visitor: HeadlessClient, seconds: float) -> None:
    """Choose the languages in turn; each rebuilds the page, and with it the control."""
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
    """Press a button, even after its label has changed."""
    uuid = visitor.mirror.labelled(label, "GuiButtonMessage")["uuid"]
    await _paced(FLOOD_RATE, seconds, lambda _: visitor.send(_value(uuid, True)))


async def _press_row(visitor: HeadlessClient, seconds: float, option: str) -> None:
    row = next(e for e in visitor.mirror.gui.values() if option in (e.get("options") or ()))

    async def press(number: int) -> None:
        # The labels change: the chosen one is marked.
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
    """Send a large value, encoded in msgpack, to a control, each time over a new connection."""
    uuid = visitor.mirror.labelled("robot")["uuid"]
    head = msgspec.msgpack.encode(_value(uuid, None))
    assert head.endswith(b"\xc0")
    message = head[:-1] + content

    async def send_one(_: int) -> None:
        other = await HeadlessClient(visitor.url, decode=False).connect(TIMEOUT)
        with contextlib.suppress(Exception):
            # The server closes the connection in the middle of the message.
            await other.send_raw(message)
        others.append(other)

    others: list[HeadlessClient] = []
    await _paced(HEAVY_COUNT / seconds, seconds, send_one)
    for other in others:
        with contextlib.suppress(Exception):
            await other.close()


async def _enter_class(visitor: HeadlessClient, seconds: float, query: str = "") -> None:
    """Open the pages of a whole class by one link, evenly within `ENTRY_SECONDS`."""
    pages: list[HeadlessClient] = []

    async def open_page(_: int) -> None:
        # Each is a tab of its own, as it is in a class.
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
"""Name → what the other visitor does for a number of seconds."""


LEAST_FRAMES: Final = 24.0
"""Least number of frames a second that a neighbour receives."""

LONGEST_GAP: Final = 0.150
"""Longest wait of a neighbour for its next frame [s]."""

SETTLED: Final = 10
"""Frames that the other visitor receives before the disturbance, once the page is built."""


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
    """Make one disturbance after the other, each as a visitor of its own who comes before it and leaves after it."""
    for name in names:
        visitor = await HeadlessClient(url).connect(TIMEOUT)
        # Only who leads a lecture has commands.
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
    """Yield what a neighbour sees during each of `DISTURBANCES`, by name, as soon as it is measured.

    They follow each other on one server, as long as that gives a lecture or does not.

    Args:
        seconds: duration of each [s].

    Yields:
        Frames a second at the neighbour, and the longest time without one [ms]; processor time of the server's longest frame [ms], which
        a busy machine changes least, and of the whole server in percent of a core; 1 if the first two are within the limits, else 0.

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
