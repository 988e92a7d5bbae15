"""The page in a frame of a foreign page, with a browser that keeps nothing for frames: it runs, and arrow keys reach the page around it."""

from playwright.sync_api import expect

from app.start import App
from tests.app.conftest import OpenHouse, live_sessions
from tests.app.page.conftest import Around
from tests.browser import PageAt, screenshot, until


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
    # A tab of its own, so that no connection is left open for the server to wait for.
    page = page_at(940, 640, expect=("frame-ancestors",), fresh=True)
    address = around[1](house(embed_origins=("https://moodle.example.org",)).url)
    with page.expect_event("requestfailed", lambda request: request.is_navigation_request()):
        page.goto(address)
    assert not page.frame_locator("iframe").locator("#duet-loading").count()
