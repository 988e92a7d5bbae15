"""The page in a frame of a foreign page, in Chromium and in the system's Firefox.

It works without storage, arrow keys reach the outer page, and the console stays silent.
"""

import json
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import expect

from app.session.session import Session
from app.start import App
from controllers.kinematics import Array
from scenes.targets import LinkTarget
from tests.app.conftest import OpenHouse, ask, live_sessions
from tests.browser import CAMERA, STILL, PageAt, artefacts, screenshot, until
from tests.firefox import TIMEOUT, Firefox, firefox

AROUND = """<!doctype html><title>A course</title><link rel="icon" href="data:,"><body>
<p>The slide before, and the one after.</p>
<script>heard = []; addEventListener("message", ({data}) => { if (typeof data === "string") heard.push(data); });</script>
<iframe src="FRAME" width="900" height="560"></iframe>"""


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: object) -> None:
        """Log nothing."""


Around = Callable[[str], str]


@pytest.fixture
def around(tmp_path: Path) -> Iterator[tuple[str, Around]]:
    """Origin of a foreign page, and a function: address for its frame → address of the page."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(tmp_path))) as server:
        threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
        origin = f"http://localhost:{server.server_address[1]}"

        def write(frame: str) -> str:
            (tmp_path / "course.html").write_text(
                AROUND.replace("FRAME", frame.replace("&", "&amp;")), encoding="utf-8"
            )
            return f"{origin}/course.html"

        yield origin, write
        server.shutdown()


@pytest.mark.thorough
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
    assert (
        not frame.locator("[data-floating-window]").is_visible()
        and not frame.locator("img[alt^='Duet:']").is_visible()
    )
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


def test_a_foreign_page_that_is_not_listed_gets_an_empty_frame(
    house: OpenHouse, page_at: PageAt, around: tuple[str, Around]
) -> None:
    # A separate tab, so that the server need not wait for an open connection.
    page = page_at(940, 640, expect=("frame-ancestors",), fresh=True)
    address = around[1](house(embed_origins=("https://moodle.example.org",)).url)
    with page.expect_event("requestfailed", lambda request: request.is_navigation_request()):
        page.goto(address)
    assert not page.frame_locator("iframe").locator("#duet-loading").count()


NODE = "window.__viserMutable?.nodeRefFromName?."
LINK = "/arms/right/base/j1/j2/j3/j4/j5/j6"
PULL = 110.0
"""Mouse movement to the right, towards the silver arm, within the link's reach [CSS px]."""

STILL_VIEW = f"""new Promise((done) => {{
  let last = "", frames = 0, since = 0;
  const look = (time) => {{
    const now = JSON.stringify({CAMERA});
    if (now !== last) [frames, since] = [0, time];
    frames++;
    last = now;
    if (frames < 20 || time - since < {1000 * STILL}) requestAnimationFrame(look);
    else done(true);
  }};
  requestAnimationFrame(look);
}})"""
NEXT_FRAME = "new Promise((done) => requestAnimationFrame(() => done(true)))"
LINK_PX = f"""(() => {{
  const {{ camera, nodeRefFromName, canvas }} = __viserMutable, box = canvas.getBoundingClientRect();
  const node = nodeRefFromName["{LINK}"], at = node.position.clone();
  node.updateWorldMatrix(true, false);
  node.getWorldPosition(at).project(camera);
  return JSON.stringify([box.left + (1 + at.x) / 2 * box.width, box.top + (1 - at.y) / 2 * box.height]);
}})()"""


@pytest.mark.thorough
def test_a_visit_in_firefox_and_in_a_frame_without_storage(
    house: OpenHouse, around: tuple[str, Around], tmp_path_factory: pytest.TempPathFactory
) -> None:
    origin, write = around
    opened: App = house(embed_origins=(origin,))
    try:
        # 1: frames of another site cannot store anything.
        with firefox(tmp_path_factory.mktemp("firefox"), {"network.cookie.cookieBehavior": 1}) as tab:
            tab.open(f"{opened.url}/?autopilot=0&lang=en&speed=2&wmax=0.5&dm=0.3", 1024, 768)
            tab.until(f"{NODE}['{LINK}/j7'] && {NODE}['/arms/left/base']", "the arms")
            tab.until(
                "__viserMutable.canvas.getContext('webgl2') instanceof WebGL2RenderingContext",
                "a picture of them",
            )
            tab.until("document.documentElement.matches('.duet-built')", "the whole page")
            pull_the_arm(tab, live_sessions(opened)[max(live_sessions(opened))])
            tab.open(write(f"{opened.url}/?lesson=5&lang=de&embed=1"), 1024, 768)
            tab.until("window.length === 1", "the frame")
            tab.enter_frame()
            tab.until("document.querySelector('.duet-lesson')?.innerText.length > 80", "the lesson")
            assert (
                tab.value("(() => { try { return Boolean(localStorage); } catch { return false; } })()")
                is False
            )
            assert not tab.complaints
    except FileNotFoundError as error:
        pytest.skip(str(error))


def pull_the_arm(tab: Firefox, session: Session) -> None:
    """Drag a link of the orange arm until it is at the mouse and the silver arm avoids it."""

    def avoiding(s: Session) -> Array:
        return s.simulation.positions[s.simulation.avoiding.joints].copy()

    def missing(s: Session) -> float:
        assert isinstance(s.held, LinkTarget)
        placement = s.simulation.kinematics.data.oMi[s.simulation.guided.joint(s.held.joint)]
        return float(np.linalg.norm(placement.act(s.held.offset) - s.held.position))

    def off_the_mouse() -> float:
        return float(np.abs(np.array(json.loads(tab.value(LINK_PX))) - (x + PULL, y)).max())

    def pulled() -> bool:
        return (
            ask(session, missing) < 0.02
            and off_the_mouse() < 20.0
            and bool(np.abs(ask(session, avoiding) - still).max() > 0.02)
        )

    def at_the_mouse() -> None:
        tab.until("__viserMutable.nodeRefFromName['/grip/point']?.visible", "the mark where it is held")
        wait(tab, pulled, "the link at the mouse, and the silver arm out of its way")
        tab.picture(artefacts() / "firefox.png")

    tab.value(STILL_VIEW)
    view, (x, y) = tab.value(f"JSON.stringify({CAMERA})"), json.loads(tab.value(LINK_PX))
    still = ask(session, avoiding)
    tab.drag((x, y), (PULL, 0.0), at_the_mouse)
    wait(tab, lambda: session.held is None, "the link let go")
    assert off_the_mouse() < 25.0
    # Dragging the link does not turn the view.
    assert tab.value(f"JSON.stringify({CAMERA})") == view


def wait(tab: Firefox, true: Callable[[], bool], what: str) -> None:
    """Wait until `true()` holds, checked after every drawn frame."""
    end = time.monotonic() + TIMEOUT
    while not true():
        assert time.monotonic() < end, f"{what}: not in time"
        tab.value(NEXT_FRAME)
