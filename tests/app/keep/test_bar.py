"""The controls in a real browser, with real workers: files come down, a file goes up, the scrubber moves what is drawn."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from threading import Event, Thread

import numpy as np
import pytest
import viser
from playwright.sync_api import Page

from app.background import Background
from app.keep.run_file import saved_bytes, saved_from
from app.page.keep import ReplayBar
from app.page.stage import Stage
from app.server import start_server
from app.session import Session
from app.settings import PageSettings, Settings
from scenes.history import COLUMN
from tests.app.conftest import ask
from tests.app.keep.runs import piece
from tests.browser import PageAt, screenshot, wait_frames, wait_ready, world_position

WRIST = "/arms/right/base/j1/j2/j3/j4/j5/j6/j7"


@dataclass
class Stand:
    """A visitor's page with nothing but the stage and the bar, as the frame loop draws it."""

    session: Session
    bar: ReplayBar
    stage: Stage
    client: viser.ClientHandle

    def frame(self, elapsed: float) -> None:
        self.session.advance(elapsed)
        self.bar.advance(elapsed)
        with self.client.atomic():
            shown = self.bar.past or self.session
            self.stage.show(shown.simulation, shown.simulation.sample(), self.session.settings.page)
            self.bar.show()
        self.client.flush()


def send(client: viser.ClientHandle, name: str, content: bytes) -> None:
    client.send_file_download(name, content, save_immediately=True)


def notify(client: viser.ClientHandle, title: str, text: str) -> None:
    client.add_notification(title, text, auto_close_seconds=60.0)


@dataclass
class House:
    """A server with one visitor at most."""

    url: str
    stands: list[Stand]


@pytest.fixture
def house() -> Iterator[House]:
    """A server whose page has the bar."""
    server, background, stands, ended = start_server("127.0.0.1", 0), Background(1), list[Stand](), Event()

    @server.on_client_connect
    async def _(client: viser.ClientHandle) -> None:
        arrived.append(client)

    arrived: list[viser.ClientHandle] = []

    def loop() -> None:
        before = time.perf_counter()
        while not ended.wait(0.02):
            while arrived:
                client = arrived.pop()
                session = Session(Settings(page=PageSettings(picture="fast")))
                bar = ReplayBar(client.gui, session, background, partial(send, client), partial(notify, client))
                stands.append(Stand(session, bar, Stage(client.scene, session.simulation, session.settings.page), client))
            now = time.perf_counter()
            for stand in stands:
                stand.frame(now - before)
            before = now

    thread = Thread(target=loop, daemon=True)
    thread.start()
    yield House(server.url, stands)
    ended.set()
    thread.join(10.0)
    background.close()
    server.stop()


def until(page: Page, true: Callable[[], object], what: str, seconds: float = 60.0) -> None:
    """Return as soon as something is true, asked again after every drawn frame."""
    deadline = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < deadline, f"{what}: not within {seconds:g} s"
        wait_frames(page, 1)


def test_look_back_take_home_and_bring_along(page_at: PageAt, house: House, tmp_path: Path) -> None:
    page = page_at(1000, 640)
    page.goto(house.url)
    wait_ready(page, WRIST)
    (stand,) = house.stands
    session, shelf = stand.session, stand.bar.shelf
    until(page, lambda: ask(session, lambda s: s.simulation.time) > 1.0, "a second of the run")

    # Look back: the live run waits, and the slider moves what is drawn.
    page.get_by_role("button", name="Watch").click()
    page.get_by_text("This is the past; the live run waits.").wait_for(timeout=60_000)
    assert session.paused and shelf.replay is not None
    page.get_by_role("button", name="Play").click()
    until(page, lambda: shelf.replay is not None and not shelf.replay.playing, "at rest")
    box = page.get_by_role("textbox").nth(0)
    box.fill("0.5")
    box.press("Enter")
    until(page, lambda: shelf.replay is not None and abs(shelf.replay.time - 0.5) < 1e-6, "half a second")
    wait_frames(page, 4)
    half = world_position(page, WRIST)
    live = ask(session, lambda s: s.simulation.history.table())
    positions = ask(session, lambda s: s.simulation.history.positions(live))
    assert np.abs(np.diff(positions, axis=0)).max() > 0.0
    screenshot(page, "replay-bar")

    # Take home.
    with page.expect_download(timeout=60_000) as table:
        page.get_by_role("button", name="CSV").click()
    text = Path(table.value.path()).read_text(encoding="utf-8")
    rows = [line for line in text.splitlines() if line and not line.startswith("#")]
    assert table.value.suggested_filename.endswith(".csv") and rows[0].startswith("t,d,lambda,e2")
    assert [float(row.split(",")[1]) for row in rows[1:6]] == live[:5, COLUMN["d"]].tolist()
    with page.expect_download(timeout=60_000) as run:
        page.get_by_role("button", name="Run", exact=True).click()
    kept = saved_from(Path(run.value.path()).read_bytes(), "it")
    assert kept.recorded.steps == len(live)
    page.get_by_role("button", name="Python").click()
    lines = page.locator("pre")
    lines.wait_for(timeout=60_000)
    assert "from scenes.headless import run" in lines.inner_text()
    page.get_by_role("button", name="Copy", exact=True).click()
    page.get_by_role("button", name="Copied").wait_for()
    page.get_by_role("button", name="Close").click()

    # Back to live: the arms go on.
    page.get_by_role("button", name="Back to live").click()
    until(page, lambda: shelf.replay is None and not session.paused, "live")
    until(page, lambda: np.abs(world_position(page, WRIST) - half).max() > 1e-4, "the arm of the live run")

    # Bring along: another experiment, compared and replayed; and something that is no run.
    bring(page, "theirs.duet.npz", saved_bytes(piece("ball", 1.0)[0]))
    page.get_by_text("Loaded: the same run").wait_for(timeout=60_000)
    page.get_by_text("This is theirs.duet.npz, not the live run.").wait_for(timeout=60_000)
    wait_ready(page, "/ball")
    page.get_by_role("button", name="Back to live").click()
    wait_ready(page, WRIST)
    bring(page, "<b>bad</b>.npz", b"PK")
    page.get_by_text("<b>bad</b>.npz: is not a file of recorded inputs, or is damaged").wait_for(timeout=60_000)


def bring(page: Page, name: str, content: bytes) -> None:
    """Choose a file to load."""
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Load a run").click()
    chooser.value.set_files({"name": name, "mimeType": "application/octet-stream", "buffer": content})
