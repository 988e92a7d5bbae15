"""A visitor who does anything at all, again and again, in a real browser: `python -m tests.monkey --seeds 1 2 3 --seconds 60`.

The same seed does the same things, as far as the page is the same then; a failure prints the seed and all that was done.
"""

from __future__ import annotations

import argparse
import logging
import os
import random
import re
import sys
import tempfile
import threading
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import TimeoutError as NoAnswer
from contextlib import contextmanager
from pathlib import Path
from typing import Final
from urllib.parse import quote

import numpy as np
from playwright.sync_api import Browser, BrowserContext, Error, FileChooser, sync_playwright

from app.hosts import House, PrivateHost, open_house
from app.session import Session
from app.settings import Settings
from scenes.settings import changed, specs, values
from tests.app.conftest import ask, live_sessions
from tests.browser import _HARMLESS, artefacts, launch

PATIENCE: Final = 60.0
"""How long the page or the server may take to answer on a busy machine [s]."""

SHORT: Final = 1500.0
"""How long one action looks for what it wants [ms]."""

SCRIPT: Final = "<img src=x onerror=alert(1)>"
WAYS: Final = ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"]
KEYS: Final = (*" .[]RAVLG12345NBCHYX?", *WAYS, *["PageUp", "Escape", "Tab", "Enter"])
TEXTS: Final = ("", SCRIPT, "\u202e", "é" * 300, "0", "-1", "1e999", "NaN", "0.12", "99999999", "12,5")
SIZES: Final = ((1440, 900), (1024, 768), (800, 600), (390, 844))
LINKS: Final = (
    *(
        "",
        "a" * 3000,
        f"q={quote(SCRIPT)}",
        "lesson=1",
        "lesson=3&step=2",
        "lesson=10",
        "lesson=99",
        "lesson=%3Cb%3E&step=-1",
        "step=2",
    ),
    *(
        "scene=imitation&ghost=frozen",
        "scene=nowhere",
        "rig=table&law=unprotected&dm=0.1&n=10",
        "dm=NaN&n=1e999&v=",
        "%00%ff=%fe",
    ),
    *(
        "dm=0.1&dm=0.2",
        "lang=de",
        "lang=xx",
        "robot=panda&scene=solo",
        "resume=../../etc",
        "window=0x0",
        "whatif=1&plot=speeds",
    ),
)

RUBBISH: Final = (
    ("empty.duet", b""),
    ("noise.duet", bytes(random.Random(0).randbytes(3000))),
    ("noise.bvh", b"HIERARCHY\nROOT Hips\n{\n OFFSET 0 0 nan\n"),
    ("half.zst", b"\x28\xb5\x2f\xfd" + bytes(range(50))),
    ("a.csv", b"t,x,y,z\n0,1e308,nan,x\n"),
    ("\N{PILE OF POO}.json", b'{"version": 1e999, "inputs": [[]]}' * 50),
)

# Said by viser's page about an element that was taken away while something was still on its way to it, and by a browser whose
# dialogs for files are answered by a program.
_LATE = (r"Tried to update non-existent component", r"Intercepted by Page\.setInterceptFileChooserDialog")

_ELEMENTS: Final = """kind => [...document.querySelectorAll(kind)].filter(n => {
    const box = n.getBoundingClientRect();
    return box.width > 2 && box.height > 2 && box.bottom > 0 && box.right > 0 && box.top < innerHeight && box.left < innerWidth
        && !n.disabled && getComputedStyle(n).visibility !== 'hidden';
}).map(n => { const box = n.getBoundingClientRect();
    return [box.left + box.width / 2, box.top + box.height / 2,
        (n.innerText || n.getAttribute('aria-label') || n.tagName).slice(0, 40)]; })"""

_HANDLES: Final = """() => { const { camera, nodeRefFromName, canvas } = __viserMutable, box = canvas.getBoundingClientRect();
    return Object.entries(nodeRefFromName).filter(([name, node]) => node && /^.(gizmo|arms)/.test(name)).map(([name, node]) => {
        node.updateWorldMatrix(true, false); const v = node.getWorldPosition(node.position.clone()); v.project(camera);
        return [name, box.left + (1 + v.x) / 2 * box.width, box.top + (1 - v.y) / 2 * box.height]; }); }"""


class Trouble(AssertionError):
    """Something that must never happen."""


class Watch(logging.Handler):
    """Everything that went wrong, on the page or at the server."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.complaints: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        trace = "".join(traceback.format_exception(*record.exc_info)) if record.exc_info else ""
        self.complaints.append(f"server's log: {record.name}: {record.getMessage()}\n{trace}")

    def take_thread(self, what: threading.ExceptHookArgs) -> None:
        self.complaints.append(
            f"a thread ended: {''.join(traceback.format_exception(what.exc_type, what.exc_value, what.exc_traceback))}"
        )

    def check(self) -> None:
        if self.complaints:
            raise Trouble("\n".join(self.complaints))


@contextmanager
def watching() -> Iterator[Watch]:
    """Note every error of the program while open."""
    watch, before = Watch(), threading.excepthook
    logging.getLogger().addHandler(watch)
    threading.excepthook = watch.take_thread
    try:
        yield watch
    finally:
        threading.excepthook = before
        logging.getLogger().removeHandler(watch)


class Monkey:
    """One visitor.

    Args:
        opened: a house with nobody else in it.
        context: of a browser, empty.
        seed: of all choices.
        watch: hears of everything that goes wrong.

    Attributes:
        done: what was done, in words.
    """

    def __init__(self, opened: House, context: BrowserContext, seed: int, watch: Watch) -> None:
        self.opened, self.context, self.seed, self.watch = opened, context, seed, watch
        self.done: list[str] = []
        self.counts: Counter[str] = Counter()
        self._random = random.Random(seed)
        self._frames = 0
        self._rubbish = Path(tempfile.mkdtemp(prefix="monkey"))
        context.set_default_timeout(SHORT)
        self.page = context.new_page()
        self._listen()
        self.actions: dict[str, tuple[int, Callable[[], str]]] = {
            "button": (26, lambda: self._click("button, [role=button]")),
            "tab": (5, lambda: self._click("[role=tab]")),
            "switch": (5, lambda: self._click("input[type=checkbox], [role=switch], label")),
            "choice": (9, self._choose),
            "slider": (12, self._slide),
            "text": (6, self._type),
            "key": (14, self._key),
            "handle": (12, self._drag_handle),
            "view": (5, self._turn_view),
            "anywhere": (3, self._click_anywhere),
            "file": (3, self._give_file),
            "link": (2, self._follow_link),
            "reload": (1, self._reload),
            "back": (1, self._go_back),
            "size": (1, self._resize),
        }

    # ---- what is heard -----------------------------------------------------------------------------------------------------

    def _listen(self) -> None:
        page, complaints, forgiven = self.page, self.watch.complaints, re.compile("|".join((*_HARMLESS, *_LATE)))

        def on_console(message: object) -> None:
            kind, text = getattr(message, "type", ""), getattr(message, "text", "")
            where = getattr(message, "location", {}).get("url", "")
            if kind == "error" and not forgiven.search(f"{text} {where}"):
                complaints.append(f"console: {text} ({where})")

        def on_error(error: Error) -> None:
            if not forgiven.search(str(error)):
                complaints.append(f"uncaught: {error}")

        def on_socket(socket: object) -> None:
            socket.on("framereceived", lambda _: setattr(self, "_frames", self._frames + 1))  # pyright: ignore[reportAttributeAccessIssue]

        page.on("console", on_console)
        page.on("pageerror", on_error)
        page.on("crash", lambda _: complaints.append("the page crashed"))
        page.on("dialog", self._on_dialog)
        page.on("websocket", on_socket)
        page.on("filechooser", self._on_chooser)
        self.context.on("page", lambda other: other.close() if other is not page else None)

    def _on_dialog(self, dialog: object) -> None:
        message = getattr(dialog, "message", "")
        if message == "1":
            self.watch.complaints.append("a text from outside ran as a script")
        dialog.dismiss()  # pyright: ignore[reportAttributeAccessIssue]

    def _on_chooser(self, chooser: FileChooser) -> None:
        name, content = self._random.choice(RUBBISH)
        path = self._rubbish / name
        path.write_bytes(content)
        chooser.set_files(path)
        self.done.append(f"    gives the file {name} ({len(content)} B)")

    # ---- what is done ------------------------------------------------------------------------------------------------------

    def _pick(self, kind: str) -> tuple[float, float, str] | None:
        found = self.page.evaluate(_ELEMENTS, kind)
        # A number between 0 and 1 picks the same one of as many, however many were picked from before.
        place = self._random.random()
        return tuple(found[int(place * len(found))]) if found else None

    def _click(self, kind: str) -> str:
        found = self._pick(kind)
        if found is None:
            return f"finds nothing like {kind}"
        x, y, label = found
        self.page.mouse.click(x, y, click_count=2 if self._random.random() < 0.05 else 1)
        return f"clicks on {label!r} at {x:.0f}, {y:.0f}"

    def _choose(self) -> str:
        found = self._pick("input[role=combobox], input[aria-haspopup=listbox], [role=combobox]")
        if found is None:
            return "finds no list"
        self.page.mouse.click(found[0], found[1])
        option = self._pick("[role=option]")
        if option is None:
            return f"opens a list at {found[0]:.0f}, {found[1]:.0f}"
        self.page.mouse.click(option[0], option[1])
        return f"chooses {option[2]!r} of a list at {found[0]:.0f}, {found[1]:.0f}"

    def _slide(self) -> str:
        found = self._pick("[role=slider]")
        if found is None:
            return "finds no slider"
        x, y, label = found
        if self._random.random() < 0.4:
            self.page.mouse.click(x, y)
            keys = [self._random.choice(("ArrowLeft", "ArrowRight", "Home", "End")) for _ in range(self._random.randint(1, 5))]
            for key in keys:
                self.page.keyboard.press(key)
            return f"presses {keys} on the slider {label!r}"
        way = self._random.randint(-160, 160)
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        for step in range(1, 6):
            self.page.mouse.move(x + way * step / 5, y)
        self.page.mouse.up()
        return f"drags the slider {label!r} by {way} px"

    def _type(self) -> str:
        found = self._pick("input[type=text]:not([role=combobox]), textarea, input[type=number]")
        text = self._random.choice(TEXTS)
        if found is None:
            return "finds no field"
        self.page.mouse.click(found[0], found[1], click_count=3)
        self.page.keyboard.insert_text(text) if text else self.page.keyboard.press("Delete")
        self.page.keyboard.press(self._random.choice(("Enter", "Tab", "Escape")))
        return f"types {text[:30]!r} at {found[0]:.0f}, {found[1]:.0f}"

    def _key(self) -> str:
        keys = [self._random.choice(KEYS) for _ in range(self._random.choice((1, 1, 1, 4)))]
        if self._random.random() < 0.5:
            self.page.evaluate("document.activeElement?.blur()")
        for key in keys:
            self.page.keyboard.press(key)
        return f"presses {keys}"

    def _drag(self, x: float, y: float, button: str = "left") -> str:
        right, down = self._random.randint(-250, 250), self._random.randint(-200, 200)
        mouse = self.page.mouse
        mouse.move(x, y)
        mouse.down(button=button)  # pyright: ignore[reportArgumentType]
        for step in range(1, 9):
            mouse.move(x + right * step / 8, y + down * step / 8)
        # Now and then something else happens in mid-drag.
        if self._random.random() < 0.15:
            key = self._random.choice("R12345XN")
            self.page.keyboard.press(key)
            right_key = f", pressing {key} meanwhile"
        else:
            right_key = ""
        mouse.up(button=button)  # pyright: ignore[reportArgumentType]
        return f"by {right}, {down} px{right_key}"

    def _drag_handle(self) -> str:
        handles = self.page.evaluate(_HANDLES)
        gizmos = [one for one in handles if one[0].startswith("/gizmo")] or handles
        if not gizmos:
            return "finds nothing to pull"
        name, x, y = gizmos[int(self._random.random() * len(gizmos))]
        x, y = x + self._random.randint(-40, 40), y + self._random.randint(-40, 40)
        return f"pulls near {name} from {x:.0f}, {y:.0f} {self._drag(x, y)}"

    def _turn_view(self) -> str:
        x, y = self._random.randint(50, 700), self._random.randint(80, 500)
        if self._random.random() < 0.3:
            self.page.mouse.move(x, y)
            turn = self._random.choice((-900, 900, 200))
            self.page.mouse.wheel(0, turn)
            return f"turns the wheel by {turn} at {x}, {y}"
        button = self._random.choice(("left", "right"))
        return f"drags the view with the {button} button from {x}, {y} {self._drag(x, y, button)}"

    def _click_anywhere(self) -> str:
        size = self.page.viewport_size or {"width": 800, "height": 600}
        x, y = self._random.randint(0, size["width"] - 1), self._random.randint(48, size["height"] - 1)
        self.page.mouse.click(x, y, button=self._random.choice(("left", "left", "right")))
        return f"clicks anywhere at {x}, {y}"

    def _give_file(self) -> str:
        chosen = self.page.evaluate(
            """place => { const all = [...document.querySelectorAll('input[type=file]')]; if (!all.length) return false;
                all[Math.floor(place * all.length)].click(); return true; }""",
            self._random.random(),
        )
        return "opens a place for files" if chosen else "finds no place for files"

    def _follow_link(self) -> str:
        link = self._random.choice(LINKS)
        if self._random.random() < 0.4:
            key, value = self._random.choice(sorted(specs(Settings))), self._random.choice((*TEXTS, "0.3", "solo", "1"))
            link = f"{link}&{key}={quote(value)}"
        self.arrive(link)
        return f"follows the link ?{link[:120]}"

    def _reload(self) -> str:
        self.page.reload(timeout=1000 * PATIENCE)
        self._settle()
        return "reloads"

    def _go_back(self) -> str:
        self.page.go_back(timeout=1000 * PATIENCE)
        if not self.page.url.startswith(self.opened.url):
            self.arrive("")
        self._settle()
        return "goes back"

    def _resize(self) -> str:
        width, height = self._random.choice(SIZES)
        self.page.set_viewport_size({"width": width, "height": height})
        return f"makes the window {width} × {height}"

    # ---- what must be true -------------------------------------------------------------------------------------------------

    def arrive(self, link: str) -> None:
        """Open the house's page by a link."""
        self.page.goto(f"{self.opened.url}/?{link}", timeout=1000 * PATIENCE)
        self._settle()

    def _until(self, true: Callable[[], object], what: str) -> None:
        deadline = time.monotonic() + PATIENCE
        while not true():
            self.watch.check()
            if time.monotonic() > deadline:
                raise Trouble(f"{what}: not within {PATIENCE:g} s")
            self.page.wait_for_timeout(20.0)

    def _settle(self) -> None:
        """Wait until the page is there, with one session of its own."""
        self.page.wait_for_function(
            "() => window.__viserMutable?.canvas && __viserMutable.nodeRefFromName", timeout=1000 * PATIENCE
        )
        self._until(lambda: len(live_sessions(self.opened)) == 1 and self.opened.server.count_clients() == 1, "one session")

    def _session(self) -> Session:
        self._until(lambda: len(live_sessions(self.opened)) == 1, "one session")
        (session,) = live_sessions(self.opened).values()
        return session

    def check(self) -> None:
        """Look at page and server.

        Raises:
            Trouble: something is not as it must be.
        """
        self.watch.check()
        try:
            ask(self._session(), assert_sound, PATIENCE)
        except NoAnswer:
            raise Trouble("the session does not answer") from None
        seen = self._frames
        self.page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        session = self._session()
        if not session.paused:
            self._until(
                lambda: self._frames > seen or session.paused or session not in live_sessions(self.opened).values(), "a frame"
            )
        self.watch.check()

    def leave(self) -> None:
        """Go, after which nobody must be left."""
        self.page.goto("about:blank", timeout=1000 * PATIENCE)
        self._until(lambda: self.opened.server.count_clients() == 0, "no visitor")
        if isinstance(self.opened.host, PrivateHost):
            self._until(lambda: not live_sessions(self.opened), "no session")
        self.watch.check()

    def act(self) -> None:
        """Do one thing, and look whether all is well."""
        names = list(self.actions)
        (name,) = self._random.choices(names, [self.actions[one][0] for one in names])
        self.counts[name] += 1
        self.done.append(f"{name} …")
        number = len(self.done) - 1
        try:
            self.done[number] = self.actions[name][1]()
        except Error as error:
            # What it reached for has gone meanwhile; a page that hangs is found by the check.
            self.done[number] = f"{name}: {error.message.splitlines()[0]}"
            if "crash" in error.message.lower() or self.page.is_closed():
                raise Trouble(f"the page is gone: {error.message}") from None
        self.check()


def assert_sound(session: Session) -> None:
    """All that moves is and was where it can be, and every setting is one that can be set.

    Raises:
        Trouble: not so.
    """
    for who, simulation in (("run", session.simulation), ("ghost", session.ghost)):
        if simulation is None:
            continue
        model, table = simulation.room.model, simulation.history.table()
        q, dq = simulation.history.positions(table)[-400:], simulation.velocities
        if not (np.isfinite(q).all() and np.isfinite(dq).all() and np.isfinite(simulation.positions).all()):
            raise Trouble(f"{who}: not finite: {simulation.positions}, {dq}")
        low, high = model.lowerPositionLimit - 1e-9, model.upperPositionLimit + 1e-9
        for place in (*q, simulation.positions):
            if not ((place >= low).all() and (place <= high).all()):
                raise Trouble(f"{who}: out of its bounds by {np.maximum(low - place, place - high).max():.3g}: {place}")
    for key, value in values(session.settings).items():
        if changed(session.settings, key, value) != session.settings:
            raise Trouble(f"{key} = {value!r} is no value of a setting")


def let_loose(browser: Browser, seed: int, seconds: float, least: int = 0, lecture: bool = False) -> Monkey:
    """Let a visitor (a lecturer, in a lecture) do anything for so long, and for so many actions at least; return them.

    Raises:
        Trouble: the message says what was done.
    """
    opened = open_house("127.0.0.1", 0, Settings(), lecture=lecture)
    context = browser.new_context(viewport={"width": 1024, "height": 768}, accept_downloads=True)
    try:
        with watching() as watch:
            monkey = Monkey(opened, context, seed, watch)
            try:
                monkey.arrive("")
                end = time.monotonic() + seconds
                while time.monotonic() < end or len(monkey.done) < least:
                    monkey.act()
                monkey.leave()
            except (Trouble, Error) as trouble:
                picture = artefacts() / f"monkey-{seed}.png"
                try:
                    monkey.page.screenshot(path=picture, timeout=5000)
                except Error:
                    picture = Path("no picture could be taken")
                did = "\n".join(f"{number:4d} {what}" for number, what in enumerate(monkey.done, 1))
                raise Trouble(f"seed {seed}, after {len(monkey.done)} actions ({picture}):\n{did}\n\n{trouble}") from None
            return monkey
    finally:
        context.close()
        opened.close()


def main() -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--least", type=int, default=0, help="so many actions at least")
    parser.add_argument("--lecture", action="store_true", help="on the stage of a lecture")
    arguments = parser.parse_args()
    failed = 0
    with sync_playwright() as playwright:
        browser = launch(playwright)
        for seed in arguments.seeds:
            try:
                monkey = let_loose(browser, seed, arguments.seconds, arguments.least, arguments.lecture)
                did = ", ".join(f"{count} {name}" for name, count in monkey.counts.most_common())
                print(f"seed {seed}: {len(monkey.done)} actions without trouble ({did})", flush=True)
            except Trouble as trouble:
                failed += 1
                print(f"TROUBLE\n{trouble}\n", flush=True)
        browser.close()
    return failed


if __name__ == "__main__":
    status = main()
    sys.stdout.flush()
    # Workers of the background may still hold on to something.
    os._exit(1 if status else 0)
