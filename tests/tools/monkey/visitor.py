"""A visitor with random actions and a check after each."""

from __future__ import annotations

import logging
import random
import tempfile
import threading
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import TimeoutError as NoAnswer
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final
from urllib.parse import quote

import numpy as np
from playwright.sync_api import Browser, BrowserContext, Dialog, Error, FileChooser

from app.features import FEATURES
from app.hosting.private_host import PrivateHost
from app.hosting.serve_options import FeatureOptions, ServeOptions
from app.session.session import Session
from app.settings import Settings
from app.start import App, start_app
from scenes.settings import changed, specs, values
from tests.app.conftest import ask, live_sessions
from tests.browser import artefacts, listen
from tests.tools.monkey.hands import LINKS, RUBBISH, TEXTS, Hands, NothingThere

PATIENCE: Final = 60.0
"""Longest answer time of page or server on a busy machine [s]."""

SHORT: Final = 1500.0
"""Time limit of one action to find its element [ms]."""

# Messages about an update of a removed element, and about file dialogs answered by a program.
_LATE = (r"Tried to update non-existent component", r"Intercepted by Page\.setInterceptFileChooserDialog")

_NOW: Final = "document.timeline.currentTime"
_DRAWN: Final = "begin => document.timeline.currentTime !== begin"
"""Time of the newest frame, and True after another frame."""


class Trouble(AssertionError):
    """A fault of the page or of the server."""


class Watch(logging.Handler):
    """Collects errors of the page and of the server."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.complaints: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        trace = "".join(traceback.format_exception(*record.exc_info)) if record.exc_info else ""
        self.complaints.append(f"server's log: {record.name}: {record.getMessage()}\n{trace}")

    def take_thread(self, what: threading.ExceptHookArgs) -> None:
        trace = "".join(traceback.format_exception(what.exc_type, what.exc_value, what.exc_traceback))
        self.complaints.append(f"a thread ended: {trace}")

    def check(self) -> None:
        if self.complaints:
            raise Trouble("\n".join(self.complaints))


@contextmanager
def watching() -> Iterator[Watch]:
    """Collects every error of the program while open."""
    watch, before = Watch(), threading.excepthook
    logging.getLogger().addHandler(watch)
    threading.excepthook = watch.take_thread
    try:
        yield watch
    finally:
        threading.excepthook = before
        logging.getLogger().removeHandler(watch)


def assert_sound(session: Session) -> None:
    """Raise Trouble unless all positions, also past ones, and all settings are within their bounds."""
    for who, simulation in (("run", session.simulation), ("ghost", session.ghost)):
        if simulation is None:
            continue
        model, history = simulation.room.model, simulation.history
        q, dq = np.vstack([history.positions(history.table()), simulation.positions]), simulation.velocities
        if not (np.isfinite(q).all() and np.isfinite(dq).all()):
            raise Trouble(f"{who}: not finite: {simulation.positions}, {dq}")
        beyond = np.maximum(model.lowerPositionLimit - q, q - model.upperPositionLimit).max()
        if beyond > 1e-9:
            raise Trouble(f"{who}: out of its bounds by {beyond:.3g}: {simulation.positions}")
    usual = values(Settings())
    for key, value in values(session.settings).items():
        if changed(session.settings, key, value) != session.settings or type(value) is not type(usual[key]):
            raise Trouble(f"{key} = {value!r} is no value of a setting")


class Monkey:
    """The only visitor of an app; `done`: descriptions of the actions."""

    def __init__(self, opened: App, context: BrowserContext, seed: int, watch: Watch) -> None:
        self.opened, self.context, self.seed, self.watch = opened, context, seed, watch
        self.done: list[str] = []
        self.counts: Counter[str] = Counter()
        self._random = random.Random(seed)
        self._frames = 0
        self._rubbish = Path(tempfile.mkdtemp(prefix="monkey"))
        context.set_default_timeout(SHORT)
        self.page = context.new_page()
        self._listen()
        hands = Hands(self.page, self._random)
        self.actions: dict[str, tuple[int, Callable[[], str]]] = {
            "button": (26, lambda: hands.click("button, [role=button]")),
            "tab": (5, lambda: hands.click("[role=tab]")),
            "switch": (5, lambda: hands.click("input[type=checkbox], [role=switch], label")),
            "choice": (9, hands.choose),
            "slider": (12, hands.slide),
            "text": (6, hands.write),
            "key": (14, hands.press),
            "handle": (12, hands.drag_handle),
            "view": (5, hands.turn_view),
            "anywhere": (3, hands.click_anywhere),
            "file": (3, hands.give_file),
            "link": (2, self._follow_link),
            "reload": (1, self._reload),
            "back": (1, self._go_back),
            "size": (1, hands.resize),
        }

    def _listen(self) -> None:
        page, complaints = self.page, self.watch.complaints

        def on_dialog(dialog: Dialog) -> None:
            if dialog.message == "1":
                complaints.append("a text from outside ran as a script")
            dialog.dismiss()

        def count(_: object) -> None:
            self._frames += 1

        listen(page, complaints, *_LATE)
        page.on("crash", lambda _: complaints.append("the page crashed"))
        page.on("dialog", on_dialog)
        page.on("websocket", lambda socket: socket.on("framereceived", count))
        page.on("filechooser", self._on_chooser)
        self.context.on("page", lambda other: other.close() if other is not page else None)

    def _on_chooser(self, chooser: FileChooser) -> None:
        name, content = self._random.choice(RUBBISH)
        path = self._rubbish / name
        path.write_bytes(content)
        # A link may be followed meanwhile.
        with suppress(Error):
            chooser.set_files(path)
        self.done.append(f"    gives the file {name} ({len(content)} B)")

    def _follow_link(self) -> str:
        link = self._random.choice(LINKS)
        if self._random.random() < 0.4:
            key, value = (
                self._random.choice(sorted(specs(Settings))),
                self._random.choice((*TEXTS, "0.3", "solo", "1")),
            )
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

    def arrive(self, link: str) -> None:
        self.page.goto(f"{self.opened.url}/?{link}", timeout=1000 * PATIENCE)
        self._settle()

    def _until(self, true: Callable[[], object], what: str) -> None:
        deadline = time.monotonic() + PATIENCE
        while not true():
            self.watch.check()
            if time.monotonic() > deadline:
                raise Trouble(f"{what}: not within {PATIENCE:g} s")
            try:
                # Until a frame is drawn, or the page changes.
                self.page.wait_for_function(_DRAWN, arg=self.page.evaluate(_NOW), timeout=SHORT)
            except Error as error:
                if self.page.is_closed():
                    raise Trouble(f"the page is gone: {error.message}") from None

    def _settle(self) -> None:
        """Wait until the page is loaded and has the only session."""
        there = "() => window.__viserMutable?.canvas && __viserMutable.nodeRefFromName"
        self.page.wait_for_function(there, timeout=1000 * PATIENCE)
        self._until(
            lambda: len(live_sessions(self.opened)) == 1 and self.opened.server.count_clients() == 1,
            "one session",
        )

    def _session(self) -> Session:
        self._until(lambda: len(live_sessions(self.opened)) == 1, "one session")
        return next(iter(live_sessions(self.opened).values()))

    def check(self) -> None:
        """Check page and server; Trouble on a fault."""
        self.watch.check()
        try:
            ask(self._session(), assert_sound, PATIENCE)
        except NoAnswer:
            raise Trouble("the session does not answer") from None
        seen = self._frames
        self.page.evaluate(
            "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
        )
        session = self._session()
        self._until(
            lambda: (
                self._frames > seen or session.paused or session not in live_sessions(self.opened).values()
            ),
            "a frame",
        )
        self.watch.check()

    def leave(self) -> None:
        """Leave; then no visitor may remain."""
        self.page.goto("about:blank", timeout=1000 * PATIENCE)
        self._until(lambda: self.opened.server.count_clients() == 0, "no visitor")
        if isinstance(self.opened.host, PrivateHost):
            self._until(lambda: not live_sessions(self.opened), "no session")
        self.watch.check()

    def act(self) -> None:
        names = list(self.actions)
        (name,) = self._random.choices(names, [self.actions[one][0] for one in names])
        self.counts[name] += 1
        self.done.append(f"{name} …")
        number = len(self.done) - 1
        try:
            self.done[number] = self.actions[name][1]()
        except NothingThere as nothing:
            self.done[number] = str(nothing)
        except Error as error:
            # The element has gone meanwhile; the check finds a page that hangs.
            self.done[number] = f"{name}: {error.message.splitlines()[0]}"
            if "crash" in error.message.lower() or self.page.is_closed():
                raise Trouble(f"the page is gone: {error.message}") from None
        self.check()


def let_loose(browser: Browser, seed: int, seconds: float, least: int = 0, lecture: bool = False) -> Monkey:
    """Random actions of a visitor or lecturer for `seconds`, and at least `least` actions."""
    asked: tuple[FeatureOptions, ...] = ()
    if lecture:
        # The monkey also runs without a lecture.
        from app.features.lecture.lecture_options import LectureOptions

        asked = (LectureOptions(lecture=True),)
    opened = start_app(ServeOptions(features=asked), features=FEATURES)
    context = browser.new_context(viewport={"width": 1024, "height": 768}, accept_downloads=True)
    try:
        with watching() as watch:
            monkey = Monkey(opened, context, seed, watch)
            try:
                monkey.arrive("")
                end = time.monotonic() + seconds
                while time.monotonic() < end or monkey.counts.total() < least:
                    monkey.act()
                monkey.leave()
            except (Trouble, Error) as trouble:
                picture = artefacts() / f"monkey-{seed}.png"
                try:
                    monkey.page.screenshot(path=picture, timeout=5000)
                except Error:
                    picture = Path("no picture could be taken")
                did = "\n".join(f"{number:4d} {what}" for number, what in enumerate(monkey.done, 1))
                raise Trouble(
                    f"seed {seed}, after {len(monkey.done)} actions ({picture}):\n{did}\n\n{trouble}"
                ) from None
            return monkey
    finally:
        context.close()
        opened.close()
