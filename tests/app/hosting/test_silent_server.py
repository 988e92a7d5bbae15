"""A page reports a hanging server in the visitor's language, but not a quiet one."""

import itertools
import json
import threading
from collections.abc import Iterator

import pytest
from playwright.sync_api import Page, expect

from app.session.session import Session
from app.start import App
from tests.app.conftest import Arrive, OpenHouse, visitor_of
from tests.app.posted_call import post_call
from tests.app.runtime.processes import until
from tests.app.web.conftest import get
from tests.browser import PageAt, wait_ready

WATCH = """
window.seen = { said: [], answers: 0, connected: 0 };
const Native = window.Worker;
window.Worker = class extends Native {
  constructor(...given) {
    super(...given);
    this.addEventListener("message", ({ data }) => {
      if (data.type === "connected") seen.connected += 1;
      if (data.type === "message_batch" && data.messages.length === 0) seen.answers += 1;
    });
  }
};
addEventListener("DOMContentLoaded", () => new MutationObserver(() => {
  const text = document.getElementById("duet-connection")?.textContent;
  if (text) seen.said.push(text);
}).observe(document.body, { childList: true, subtree: true, characterData: true }));
"""
"""Records the page's texts about its connection, the connections, and the answers without messages."""


@pytest.fixture
def let_go(monkeypatch: pytest.MonkeyPatch) -> Iterator[threading.Event]:
    """Event that ends a waiting frame, which counts as stuck after 0.5 s."""
    monkeypatch.setattr("app.hosting.frame_loop.STUCK", 0.5)
    event = threading.Event()
    yield event
    event.set()


def stick(session: Session, let_go: threading.Event) -> None:
    """Make a frame of the session wait."""
    sticks = threading.Event()

    def wait() -> None:
        sticks.set()
        let_go.wait(120.0)

    post_call(session, wait)
    assert sticks.wait(60.0)


def is_well(opened: App) -> bool:
    return json.loads(get(f"{opened.url}/healthz")[2])["ok"]


def wait_for_answers(page: Page, more: int) -> None:
    """Wait until the page has got `more` further answers."""
    page.wait_for_function(
        "([first, more]) => seen.answers >= first + more", arg=[page.evaluate("seen.answers"), more]
    )


@pytest.mark.thorough
def test_a_page_reports_a_hanging_server_but_not_a_quiet_one(
    house: OpenHouse, page_at: PageAt, let_go: threading.Event
) -> None:
    opened = house()
    page = page_at(700, 500, locale="de-DE")
    page.add_init_script(WATCH)
    page.goto(opened.url)
    wait_ready(page, "/room")
    session, note = visitor_of(opened).session, page.locator("#duet-connection")
    # Nothing moves any more, so that only an answer can remove a note.
    page.get_by_role("button", name="Pause", exact=True).click()
    page.get_by_text("angehalten", exact=True).wait_for()
    # Repeated, as a busy machine may give the server no core for some seconds.
    for _ in range(5):
        page.evaluate("seen.said.length = 0")
        wait_for_answers(page, 3)
        # A page that was blocked itself has received nothing for 3.2 s.
        page.evaluate("const end = performance.now() + 3200; while (performance.now() < end);")
        wait_for_answers(page, 1)
        if page.evaluate("seen.said") == []:
            break
    assert page.evaluate("seen.said") == [] and page.evaluate("seen.connected") == 1

    stick(session, let_go)
    expect(note).to_have_text("Der Server antwortet nicht – bitte warten …", timeout=60_000)
    let_go.set()
    until(lambda: is_well(opened))
    expect(note).to_be_empty(timeout=60_000)


@pytest.mark.thorough
def test_a_waiting_frame_hangs_and_is_unhealthy(
    house: OpenHouse, arrive: Arrive, let_go: threading.Event
) -> None:
    opened = house()
    stick(arrive(opened).session, let_go)
    until(lambda: not is_well(opened))
    until(opened.hangs)
    let_go.set()
    until(lambda: is_well(opened))
    assert not opened.hangs()


@pytest.mark.thorough
def test_a_working_frame_is_slow_and_hangs_only_after_its_limits(
    house: OpenHouse, arrive: Arrive, monkeypatch: pytest.MonkeyPatch, let_go: threading.Event
) -> None:
    opened, rounds = house(), itertools.count()

    def work() -> None:
        while not let_go.is_set():
            next(rounds)

    def is_slow() -> bool:
        """True if the frame still runs and counts as stuck."""
        goal = next(rounds) + 1000
        until(lambda: next(rounds) > goal)
        return not opened.server.is_at_work()

    post_call(arrive(opened).session, work)
    until(is_slow)
    for _ in range(3):
        assert is_slow() and not opened.hangs()
    for limit in ("MOST_WORK", "LONGEST"):
        with monkeypatch.context() as patched:
            patched.setattr(f"app.hosting.frame_loop.{limit}", 0.1)
            # Wait until the stuck frame has had a processor for that time.
            until(lambda: is_slow() and opened.hangs())
            assert all(is_slow() and opened.hangs() for _ in range(3)), limit
    let_go.set()
    until(lambda: not opened.hangs())
