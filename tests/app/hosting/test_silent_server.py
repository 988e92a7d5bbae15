"""A server that hangs is noticed on the page, in the visitor's language; one that is merely quiet is not taken for one that hangs."""

import itertools
import json
import threading

import pytest
from playwright.sync_api import expect

from tests.app.conftest import OpenHouse, visitor_of
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
"""What the page says of its connection, how often it was connected, and how many answers without news it got."""


@pytest.mark.thorough
def test_a_frame_that_hangs_is_noticed_also_on_the_page_and_one_that_rests_is_not(
    house: OpenHouse, page_at: PageAt, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened, let_go, sticks, rounds = house(), threading.Event(), threading.Event(), itertools.count()
    page = page_at(700, 500, locale="de-DE")
    page.add_init_script(WATCH)
    page.goto(opened.url)
    wait_ready(page, "/room")
    session, note = visitor_of(opened).session, page.locator("#duet-connection")
    # Nothing moves any more, so that it is an answer that takes a note away.
    page.get_by_role("button", name="Pause", exact=True).click()
    page.get_by_text("angehalten", exact=True).wait_for()

    def answers(more: int) -> None:
        """Return when the page has asked and been answered so often again."""
        page.wait_for_function(
            "([first, more]) => seen.answers >= first + more", arg=[page.evaluate("seen.answers"), more]
        )

    # Once in a while a busy machine gives the server no core for so long.
    for _ in range(5):
        page.evaluate("seen.said.length = 0")
        answers(3)
        # A page that was held up itself has heard nothing for long.
        page.evaluate("const end = performance.now() + 3200; while (performance.now() < end);")
        answers(1)
        if page.evaluate("seen.said") == []:
            break
    assert page.evaluate("seen.said") == [] and page.evaluate("seen.connected") == 1

    def is_well() -> bool:
        return json.loads(get(f"{opened.url}/healthz")[2])["ok"]

    def stick() -> None:
        sticks.set()
        let_go.wait(120.0)

    def work() -> None:
        while not let_go.is_set():
            next(rounds)

    def is_slow() -> bool:
        """Whether the frame has gone on, and the page counts as stuck."""
        goal = next(rounds) + 1000
        until(lambda: next(rounds) > goal)
        return not opened.server.is_at_work()

    monkeypatch.setattr("app.hosting.frame_loop.STUCK", 0.5)
    post_call(session, stick)
    assert sticks.wait(60.0)
    until(lambda: not is_well())
    until(opened.hangs)
    expect(note).to_have_text("Der Server antwortet nicht – bitte warten …", timeout=60_000)
    let_go.set()
    until(is_well)
    assert not opened.hangs()
    expect(note).to_be_empty(timeout=60_000)

    let_go.clear()
    post_call(session, work)
    until(is_slow)
    for _ in range(3):
        assert is_slow() and not opened.hangs()
    for limit in ("MOST_WORK", "LONGEST"):
        with monkeypatch.context() as patched:
            patched.setattr(f"app.hosting.frame_loop.{limit}", 0.1)
            # It has had a processor for as long a moment after it counts as stuck.
            until(lambda: is_slow() and opened.hangs())
    let_go.set()
    until(lambda: not opened.hangs())
