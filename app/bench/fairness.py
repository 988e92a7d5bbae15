"""What one browser's doings leave of the page of another: a neighbour in a process of its own is watched while somebody else floods
the server, throws heavy messages at it, or comes with a whole class."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import time
from collections.abc import Awaitable, Callable
from multiprocessing.connection import Connection
from typing import Final

import msgspec

from app.bench.headless_client import HeadlessClient
from app.bench.visitors import PATIENCE, SETTLING, WARM_UP, answer, ask, keep_house, process
from app.settings import Settings
from scenes.settings import specs

FLOOD: Final = 600.0
"""Messages a second that the server reads of one browser."""

HASTE: Final = 30.0
"""Changes a second of what has the page built again."""

BOMB: Final = 15_000_000
"""Size of a heavy message [bytes]."""

BOMBS: Final = 5
CLASS: Final = 36
ENTRY: Final = 4.0
"""Time in which a whole class comes [s]."""

FRAMES: Final = 24.0
"""A neighbour has at least so many frames a second …"""

GAP: Final = 0.150
"""… and never waits longer for the next one [s]."""

ROUND: Final = ("lwr", "panda", "ur5")

Doing = Callable[[HeadlessClient, float], Awaitable[None]]
"""What a browser does for so many seconds."""


async def _paced(rate: float, seconds: float, send: Callable[[int], Awaitable[None]]) -> None:
    begin = time.perf_counter()
    for number in range(round(rate * seconds)):
        await send(number)
        ahead = begin + (number + 1) / rate - time.perf_counter()
        # What is late is made up for, so that the rate is the one asked for.
        await asyncio.sleep(max(ahead, 0.0))


def _values(key: str, *choices: object, rate: float = FLOOD) -> Doing:
    """Turn a control to one value after the other; without choices, to all it has."""
    spec = specs(Settings)[key]

    async def do(visitor: HeadlessClient, seconds: float) -> None:
        given = choices or tuple(choice for choice in spec.choices if choice != "own")

        async def send(number: int) -> None:
            value = given[number % len(given)]
            if spec.choices:
                value = spec.choice_labels[spec.choices.index(str(value))]
            await visitor.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}})

        label = f"{spec.label} [{spec.page_unit}]" if spec.page_unit else spec.label
        uuid = visitor.mirror.labelled(label)["uuid"]
        await _paced(rate, seconds, send)

    return do


async def _speak(visitor: HeadlessClient, seconds: float) -> None:
    """Choose one language after the other. The page is built again, so that the control is another one every time."""
    spec = specs(Settings)["lang"]
    languages = itertools.cycle(("de", "sl", "en"))

    async def send(number: int) -> None:
        del number
        label = spec.choice_labels[spec.choices.index(next(languages))]
        control = next((e for e in visitor.mirror.gui.values() if label in (e.get("options") or ())), None)
        if control is not None:
            await visitor.send({"type": "GuiUpdateMessage", "uuid": control["uuid"], "updates": {"value": label}})

    await _paced(HASTE, seconds, send)


def _key(title: str) -> Doing:
    """Press a key."""

    async def do(visitor: HeadlessClient, seconds: float) -> None:
        uuid = next(uuid for uuid, command in visitor.mirror.commands.items() if command["label"] == title)
        await _paced(FLOOD, seconds, lambda _: visitor.send({"type": "CommandTriggerMessage", "uuid": uuid}))

    return do


def _button(label: str) -> Doing:
    """Press a button, whatever it says meanwhile."""

    async def do(visitor: HeadlessClient, seconds: float) -> None:
        uuid = visitor.mirror.labelled(label, "GuiButtonMessage")["uuid"]
        message = {"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": True}}
        await _paced(FLOOD, seconds, lambda _: visitor.send(message))

    return do


def _row(option: str) -> Doing:
    """Press all buttons of the row that has this one, in turn."""

    async def do(visitor: HeadlessClient, seconds: float) -> None:
        row = next(e for e in visitor.mirror.gui.values() if option in (e.get("options") or ()))

        async def press(number: int) -> None:
            # What they say changes: one of them is marked.
            value = row["options"][number % len(row["options"])]
            await visitor.send({"type": "GuiUpdateMessage", "uuid": row["uuid"], "updates": {"value": value}})

        await _paced(FLOOD, seconds, press)

    return do


async def _drag(visitor: HeadlessClient, seconds: float) -> None:
    """Drag the hand to and fro."""
    name = "/gizmo/hand"
    x, y, z = visitor.mirror.nodes[name]["position"]
    await visitor.move_gizmo(name, phase="start")
    await _paced(FLOOD, seconds, lambda i: visitor.move_gizmo(name, (x + 0.1 * (i % 2), y, z)))
    await visitor.move_gizmo(name, phase="end")


def _heavy(content: bytes) -> Doing:
    """Send heavy messages in the place of a value, whether or not the server takes them."""

    async def do(visitor: HeadlessClient, seconds: float) -> None:
        uuid = visitor.mirror.labelled("robot")["uuid"]
        head = msgspec.msgpack.encode({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": None}})
        assert head.endswith(b"\xc0")
        message = head[:-1] + content

        async def throw(number: int) -> None:
            del number
            other = await HeadlessClient(visitor.url, decode=False).connect(PATIENCE)
            others.append(other)
            with contextlib.suppress(Exception):
                # The server closes the connection in the middle of the message.
                await other.send_raw(message)

        others: list[HeadlessClient] = []
        await _paced(BOMBS / seconds, seconds, throw)
        for other in others:
            with contextlib.suppress(Exception):
                await other.close()

    return do


def _array(length: int) -> bytes:
    """Return a list of so many small numbers, one byte each, in msgpack."""
    return b"\xdd" + length.to_bytes(4, "big") + bytes(length)


def _enter(query: str = "") -> Doing:
    """Come as a class by one link: one page after the other within `ENTRY`."""

    async def do(visitor: HeadlessClient, seconds: float) -> None:
        pages: list[HeadlessClient] = []

        async def come(number: int) -> None:
            # Each is a tab of its own, as it is in a class.
            tab = f"{query}&resume={number:032x}".lstrip("&")
            pages.append(await HeadlessClient(visitor.url, query=tab, decode=False).connect(PATIENCE))

        await _paced(CLASS / ENTRY, ENTRY, come)
        await asyncio.sleep(max(seconds - ENTRY, 0.0))
        for page in pages:
            await page.close()

    return do


DOINGS: Final[dict[str, Doing]] = {
    "nothing": lambda _, seconds: asyncio.sleep(seconds),
    "600/s of a slider": _values("dm", 100.0, 150.0),
    "600/s of a box": _values("autopilot", True, False),
    "600/s of the law": _values("law"),
    "600/s of the ghost": _values("ghost"),
    "600/s of the plots": _row("λ(d)"),
    "600/s of the hand": _drag,
    "600/s of a single step": _key("One single step"),
    "600/s of a reset": _key("Start anew"),
    "600/s of the guided arm": _values("guided"),
    "600/s of the scenes": _values("scene"),
    "600/s of the lessons": _button("Lessons"),
    "30/s of the scenes": _values("scene", rate=HASTE),
    "30/s of the robots": _values("robot", *ROUND, rate=HASTE),
    "30/s of the rigs": _values("rig", rate=HASTE),
    "30/s of the languages": _speak,
    "five lists of 15 MB": _heavy(_array(BOMB)),
    "five texts of 15 MB": _heavy(b"\xdb" + BOMB.to_bytes(4, "big") + b"a" * BOMB),
    "a class of 36 in 4 s, lecture": _enter(),
    "a class of 36 in 4 s, a lesson each": _enter("lesson=1"),
    "a class of 36 in 4 s, a run each": _enter(),
}
"""Name → what somebody else does."""


def _be_neighbour(pipe: Connection, url: str, seconds: float) -> None:
    asyncio.run(_watch(pipe, url, seconds))


async def _watch(pipe: Connection, url: str, seconds: float) -> None:
    visitor = await HeadlessClient(url, decode=False).connect(PATIENCE)
    await visitor.wait_for(lambda one: one.received.frames >= WARM_UP, PATIENCE)
    pipe.send("here")
    while await asyncio.to_thread(pipe.recv) == "tell":
        visitor.reset_counters()
        begin = time.perf_counter()
        await asyncio.sleep(seconds)
        pipe.send((visitor.received.times, begin, time.perf_counter(), visitor.closed is None))
    await visitor.close()


def _trouble(pipe: Connection, url: str, name: str, seconds: float) -> None:
    asyncio.run(_do(pipe, url, name, seconds))


async def _do(pipe: Connection, url: str, name: str, seconds: float) -> None:
    visitor = await HeadlessClient(url).connect(PATIENCE)
    await visitor.wait_for(lambda one: len(one.received.times) >= WARM_UP or one.mirror.commands, PATIENCE)
    await asyncio.sleep(SETTLING)
    pipe.send("here")
    while await asyncio.to_thread(pipe.recv) == "tell":
        problem = ""
        try:
            await DOINGS[name](visitor, seconds)
        except Exception as error:
            problem = f"{type(error).__name__}: {error}"
        pipe.send(problem)
    await visitor.close()


def measure_neighbour(name: str, seconds: float) -> dict[str, float]:
    """Return what a neighbour sees while somebody else does one of `DOINGS`.

    Args:
        name: of what is done.
        seconds: how long.

    Returns:
        Frames a second at the neighbour, and the longest time without one [ms]; processor time of the server's longest frame [ms], which
        a busy machine changes least, and of all it does in percent of a core; 1 if the first two are as they have to be, else 0.
    """
    lecture = name.endswith("lecture")
    with process(keep_house, lecture, CLASS + 2) as house:
        url = answer(house)
        with process(_be_neighbour, url, seconds) as neighbour:
            answer(neighbour)
            with process(_trouble, url, name, seconds) as other:
                answer(other)
                cpu = ask(house)[0]
                neighbour.send("tell")
                problem = ask(other)
                times, begin, end, alive = answer(neighbour)
                cpu_end, _, longest = ask(house)
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
        "fair": float(frames >= FRAMES and gap <= GAP),
    }
