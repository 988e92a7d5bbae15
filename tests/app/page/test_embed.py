"""The page in a frame of a foreign page, with a browser that keeps nothing for frames: it runs, and arrow keys reach the page around it."""

import threading
from collections.abc import Callable, Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from playwright.sync_api import expect

from app.start import App
from tests.app.conftest import OpenHouse, live_sessions
from tests.browser import PageAt, screenshot, until
from tests.firefox import firefox

AROUND = """<!doctype html><title>A course</title><link rel="icon" href="data:,"><body>
<p>The slide before, and the one after.</p>
<script>heard = []; addEventListener("message", ({data}) => { if (typeof data === "string") heard.push(data); });</script>
<iframe src="FRAME" width="900" height="560"></iframe>"""


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""


Around = Callable[[str], str]


@pytest.fixture
def around(tmp_path: Path) -> Iterator[tuple[str, Around]]:
    """The origin of a foreign page, and what writes it with an address in its frame and returns its own."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(tmp_path))) as server:
        threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
        origin = f"http://localhost:{server.server_address[1]}"

        def write(frame: str) -> str:
            (tmp_path / "course.html").write_text(AROUND.replace("FRAME", frame.replace("&", "&amp;")), encoding="utf-8")
            return f"{origin}/course.html"

        yield origin, write
        server.shutdown()


def test_a_lesson_runs_in_a_frame(house: OpenHouse, page_at: PageAt, around: tuple[str, Around]) -> None:
    origin, write = around
    opened: App = house(embed_origins=(origin,))
    page = page_at(940, 640, fresh=True)
    blocked = page.context.new_cdp_session(page)
    blocked.send("Network.enable")
    blocked.send("Network.setCookieControls", {"enableThirdPartyCookieRestriction": True})
    page.goto(write(f"{opened.url}/?lesson=1&lang=en&embed=1"))
    frame = page.frame_locator("iframe")
    frame.locator(".duet-l-head").wait_for(timeout=60_000)
    frame.get_by_role("button", name="1 In none").click()
    frame.get_by_text("Your prediction: In none").first.wait_for()
    screenshot(page, "embedded-lesson")
    assert not frame.locator("[data-floating-window]").is_visible() and not frame.locator("img[alt^='Duet:']").is_visible()
    page.goto(write(f"{opened.url}/?lang=en&embed=1"))
    frame.locator("#duet-contact").wait_for(timeout=60_000)
    expect(frame.get_by_role("tab", name="Arms")).to_be_hidden(timeout=60_000)
    expect(frame.get_by_role("button", name="Pause")).to_be_visible(timeout=60_000)
    screenshot(page, "embedded-play")
    before = {number: one.simulation.room for number, one in live_sessions(opened).items()}
    assert before
    frame.locator("canvas[data-engine]").click(position={"x": 30, "y": 300})
    page.keyboard.press("ArrowRight")
    page.keyboard.press("PageUp")
    until(page, lambda: page.evaluate("heard.length") == 2, "both keys")
    assert page.evaluate("heard.map(JSON.parse).map(({method}) => method)") == ["right", "prev"]


def test_a_page_that_is_not_named_gets_an_empty_frame(house: OpenHouse, page_at: PageAt, around: tuple[str, Around]) -> None:
    page = page_at(940, 640, expect=("frame-ancestors",))
    address = around[1](house(embed_origins=("https://moodle.example.org",)).url)
    with page.expect_event("requestfailed", lambda request: request.is_navigation_request()):
        page.goto(address)
    assert not page.frame_locator("iframe").locator("#duet-loading").count()


def test_a_lesson_runs_in_a_frame_of_firefox_without_storage(
    house: OpenHouse, around: tuple[str, Around], tmp_path_factory: pytest.TempPathFactory
) -> None:
    origin, write = around
    opened = house(embed_origins=(origin,))
    try:
        # 1: whatever is stored by a frame of another site is refused.
        with firefox(tmp_path_factory.mktemp("firefox"), {"network.cookie.cookieBehavior": 1}) as tab:
            tab.open(write(f"{opened.url}/?lesson=1&lang=en&embed=1"), 940, 640)
            tab.until("window.length === 1", "the frame")
            tab.enter_frame()
            tab.until("document.querySelector('.duet-l-head')", "the lesson")
            assert tab.value("(() => { try { return Boolean(localStorage); } catch { return false; } })()") is False
            assert live_sessions(opened)
            assert not tab.complaints
    except FileNotFoundError as error:
        pytest.skip(str(error))
