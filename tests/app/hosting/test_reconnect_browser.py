"""A browser reconnects by itself, and reports that it is hidden."""

from collections.abc import Callable

import pytest
from playwright.sync_api import Page

from app.session.session import Session
from app.start import App
from tests.app.conftest import OpenHouse, ask, live_sessions
from tests.app.runtime import processes
from tests.app.viser_private import disconnect_all, live_connections
from tests.browser import PageAt, until, wait_ready

_TRIES = """
window.tries = 0;
const Native = window.Worker;
window.Worker = class extends Native {
  postMessage(message, ...rest) {
    if (message.type === "retry") tries += 1;
    super.postMessage(message, ...rest);
  }
};
"""

_HIDE = """hidden => {
  Object.defineProperty(document, "hidden", { configurable: true, get: () => hidden });
  document.dispatchEvent(new Event("visibilitychange"));
}"""


def lose_the_line(page: Page, opened: App) -> None:
    (connection,) = live_connections(opened.server)
    connection.loop.call_soon_threadsafe(connection.transport.abort)


def find_no_server(page: Page, opened: App) -> None:
    """No websocket is opened before the server answers: after many failures a browser waits for minutes."""
    page.evaluate("tries = 0")
    health, asked = "**/healthz?origin=*", list[str]()
    page.route(health, lambda route: (asked.append(route.request.url), route.abort()))
    disconnect_all(opened.server)
    until(page, lambda: len(asked) > 3, "questions whether the server is there")
    assert page.evaluate("tries") == 0 and not live_sessions(opened)
    page.unroute(health)
    page.wait_for_function("tries === 1")


def reload(page: Page, opened: App) -> None:
    page.reload()


@pytest.fixture(scope="module")
def opened(lasting_house: OpenHouse) -> App:
    return lasting_house()


@pytest.fixture(scope="module")
def page(opened: App, lasting_page_at: PageAt) -> Page:
    """A visible page with changed settings and a paused run."""
    page = lasting_page_at(800, 600, fresh=True, expect=["healthz"])
    page.add_init_script(_TRIES)
    page.goto(f"{opened.url}/?n=8")
    until(page, lambda: len(live_sessions(opened)) == 1, "a session")
    ((_, session),) = live_sessions(opened).items()
    ask(session, lambda s: [s.change("dm", 0.21), s.change("ghost", "frozen"), s.control.toggle_pause()])
    return page


def only_session(opened: App) -> tuple[int, Session]:
    ((number, session),) = live_sessions(opened).items()
    return number, session


@pytest.mark.thorough
@pytest.mark.parametrize("interrupt", [lose_the_line, find_no_server, reload])
def test_a_browser_reconnects_by_itself_to_its_session(
    page: Page, opened: App, interrupt: Callable[[Page, App], None]
) -> None:
    number, session = only_session(opened)
    state = ask(session, lambda s: (s.settings, s.simulation.steps))
    wait_ready(page, "/room")
    interrupt(page, opened)
    until(
        page,
        lambda: len(now := live_sessions(opened)) == 1 and number not in now,
        "a new connection alone",
    )
    _, again = only_session(opened)
    assert again is session and ask(session, lambda s: (s.settings, s.simulation.steps)) == state
    page.wait_for_function("() => [...document.querySelectorAll('input')].some(one => one.value === '210')")
    assert not opened.context.store.parked


def goes_on(session: Session) -> bool:
    steps = session.simulation.steps
    processes.until(lambda: session.simulation.steps > steps or session.paused)
    return not session.paused


@pytest.mark.thorough
def test_a_browser_reports_that_it_is_hidden(page: Page, opened: App) -> None:
    number, session = only_session(opened)
    wait_ready(page, "/room")
    ask(session, lambda s: s.control.toggle_pause())
    assert goes_on(session)
    page.evaluate(_HIDE, True)
    processes.until(lambda: session.paused)
    page.evaluate(_HIDE, False)
    processes.until(lambda: not session.paused)
    assert goes_on(session)
    # A page that reconnects in the background is hidden from the beginning.
    page.evaluate(_HIDE, True)
    processes.until(lambda: session.paused)
    disconnect_all(opened.server)
    processes.until(
        lambda: any(
            one != number and its is session and its.paused for one, its in live_sessions(opened).items()
        )
    )
