"""The server in a real browser: tabs that connect, lose their connection, or find all places taken."""

import pytest

from app.hosting.visitor_record import tab_id
from app.page import STATIC
from app.web.connection import FilteredConnection
from app.web.pages import PageAssets, page_query
from app.web.traffic_limits import TrafficLimits
from tests.app.viser_private import disconnect_all
from tests.app.web.conftest import Start
from tests.blocking_client import BlockingClient
from tests.browser import PageAt, screenshot

RESUME, TEACHER_KEY = PageAssets((STATIC / "resume.js",)), PageAssets((STATIC / "teacher_key.js",))


@pytest.mark.thorough
def test_the_full_page_admits_later_and_a_teacher_at_once(start: Start, page_at: PageAt) -> None:
    server = start(max_clients=1, assets=TEACHER_KEY)
    server.always_admits = lambda query: query.get("key") == "chalk-and-talk"
    server.gui.add_markdown("welcome")
    page = page_at(900, 600, fresh=True, expect=(r"status of 503",))
    with BlockingClient(server.url) as program:
        # The program takes the place with its first message.
        program.wait_for(lambda _: server.count_clients() == 1)
        page.goto(f"{server.url}/?dm=0.1")
        page.get_by_text("Every place is taken").wait_for()
        screenshot(page, "room-full")
    page.get_by_text("welcome").wait_for()
    # The page is open now, but the server is full when it reconnects.
    attempts: list[str] = []
    page.on(
        "console",
        lambda message: attempts.append(message.text) if message.text.startswith("Connecting") else None,
    )
    server.max_clients = 0
    disconnect_all(server)
    page.get_by_text("Every place is taken").wait_for()
    assert server.count_clients() == 0 and len(attempts) <= 3
    server.max_clients = 1
    page.get_by_text("welcome").wait_for()
    assert page.evaluate("location.search") == "?dm=0.1"
    # A teacher is admitted, also after a reload, although every place is taken.
    server.max_clients = 0
    for come in (lambda: page.goto(f"{server.url}/?dm=0.1&key=chalk-and-talk"), page.reload):
        come()
        page.get_by_text("welcome").wait_for()
        assert page.evaluate("location.search") == "?dm=0.1"


_IN_THE_BACKGROUND = """
Object.defineProperty(window, "sessionStorage", { get() { throw new Error("blocked"); } });
window.Worker = class extends Worker {
  postMessage(message, ...rest) { if (message?.message?.type !== "ViewerCameraMessage") super.postMessage(message, ...rest); }
};
"""


def test_a_tab_without_drawing_and_storage_sends_hello_and_its_id(start: Start, page_at: PageAt) -> None:
    server = start(assets=RESUME, limits=TrafficLimits(connections=1))
    page = page_at(700, 500, fresh=True)
    page.add_init_script(_IN_THE_BACKGROUND)
    page.goto(server.url)
    with BlockingClient(server.url) as program:
        program.wait_for(lambda _: len(server.holders) == 2)
        tab = next(one for one, holder in server.holders.items() if holder[0] == "tab")
        assert isinstance(tab, FilteredConnection) and tab.request is not None
        program.wait_for(lambda _: tab.received)
        assert server.holders[tab] == ("tab", tab_id(page_query(tab.request.path)))
        # viser does not know the client yet.
        assert server.client_id(tab) not in server.get_clients()


@pytest.mark.thorough
def test_a_lost_connection_is_restored_and_a_doubled_tab_is_refused(start: Start, page_at: PageAt) -> None:
    options = {"assets": RESUME, "limits": TrafficLimits(connections=1)}
    server = start(**options)
    server.gui.add_markdown("first start")
    page = page_at(900, 600)
    page.goto(server.url)
    page.get_by_text("first start").wait_for()
    pill = page.locator("#duet-connection")
    assert not pill.is_visible() and pill.get_attribute("role") == "status"
    word = page.evaluate("sessionStorage.getItem('duetResume')")
    double = page_at(900, 600, locale="de-DE")
    double.add_init_script(f"sessionStorage.setItem('duetResume', '{word}')")
    double.goto(server.url)
    double.get_by_text("in zu vielen Tabs").wait_for()
    note = "document.querySelector('#duet-connection')"
    assert double.evaluate(f"{note}.scrollWidth <= {note}.clientWidth")
    screenshot(double, "tab-doubled")
    assert server.count_clients() == 1
    port = server.get_port()
    server.stop()
    pill.get_by_text("Connection lost").wait_for()
    screenshot(page, "connection-lost")
    again = start(port, **options)
    again.gui.add_markdown("second start")
    page.get_by_text("second start").wait_for()
    pill.wait_for(state="hidden")
    # The page was loaded from the new server.
    page.wait_for_function(
        "fetch('/healthz').then(a => a.json()).then(s => document.documentElement.outerHTML.includes(s.run))"
    )
