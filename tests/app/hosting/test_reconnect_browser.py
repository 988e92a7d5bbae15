"""A browser that comes back by itself, and one that says that it is out of sight."""

import pytest

from app.session.session import Session
from tests.app.conftest import OpenHouse, ask, live_sessions
from tests.app.runtime import processes
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


@pytest.mark.thorough
def test_a_browser_comes_back_by_itself_to_where_it_was_and_says_that_it_is_out_of_sight(
    house: OpenHouse, page_at: PageAt
) -> None:
    opened, asked = house(), list[str]()
    page = page_at(800, 600, fresh=True, expect=["healthz"])
    page.add_init_script(_TRIES)
    page.goto(f"{opened.url}/?n=8")
    until(page, lambda: len(live_sessions(opened)) == 1, "a session")
    ((number, session),) = live_sessions(opened).items()
    ask(session, lambda s: [s.change("dm", 0.21), s.change("ghost", "frozen"), s.control.toggle_pause()])
    state = ask(session, lambda s: (s.settings, s.simulation.steps))

    def lose_the_line() -> None:
        (connection,) = opened.server._websock_server._live_connections.values()
        connection.loop.call_soon_threadsafe(connection.transport.abort)

    def find_no_server() -> None:
        """No websocket is opened before the server answers: a browser that has seen many of them fail would open none for minutes."""
        page.evaluate("tries = 0")
        health = "**/healthz?origin=*"
        page.route(health, lambda route: (asked.append(route.request.url), route.abort()))
        opened.server._websock_server.disconnect_all_clients()
        until(page, lambda: len(asked) > 3, "questions whether the server is there")
        assert page.evaluate("tries") == 0 and not live_sessions(opened)
        page.unroute(health)
        page.wait_for_function("tries === 1")

    for interrupt in (lose_the_line, find_no_server, page.reload):
        wait_ready(page, "/room")
        interrupt()
        until(
            page,
            lambda before=number: len(now := live_sessions(opened)) == 1 and before not in now,
            "a new connection alone",
        )
        ((number, again),) = live_sessions(opened).items()
        assert again is session and ask(session, lambda s: (s.settings, s.simulation.steps)) == state
        page.wait_for_function(
            "() => [...document.querySelectorAll('input')].some(one => one.value === '210')"
        )
    assert not opened.context.store.parked

    def goes_on(session: Session) -> bool:
        steps = session.simulation.steps
        processes.until(lambda: session.simulation.steps > steps or session.paused)
        return not session.paused

    ask(session, lambda s: s.control.toggle_pause())
    assert goes_on(session)
    page.evaluate(_HIDE, True)
    processes.until(lambda: session.paused)
    page.evaluate(_HIDE, False)
    processes.until(lambda: not session.paused)
    assert goes_on(session)
    # A page that connects again in the background is out of sight from the beginning.
    page.evaluate(_HIDE, True)
    processes.until(lambda: session.paused)
    opened.server._websock_server.disconnect_all_clients()
    processes.until(
        lambda: any(
            one != number and its is session and its.paused for one, its in live_sessions(opened).items()
        )
    )
