"""Recording controls in a real browser: watch, scrub, export, load; also the link and the lab report."""

from pathlib import Path
from urllib.parse import parse_qsl, urlsplit

import numpy as np
import pytest
from playwright.sync_api import Download, Locator, Page

from app.features.exports.export_queue import ExportQueue
from app.features.exports.exports_panel import ExportsPanel
from app.recording.run_file import saved_bytes, saved_from
from app.session.session import Session
from app.settings import Settings, from_query
from app.start import App
from scenes.history import COLUMN
from scenes.settings import changed
from tests.app.conftest import HAND, OpenHouse, ask, visitor_of
from tests.app.features.lessons.helpers import lessons_of, unfold_controls
from tests.app.page.by_hand import visit
from tests.app.recording.runs import piece
from tests.browser import PageAt, screenshot, until, wait_frames, wait_ready, world_position

WRIST = "/arms/right/base/j1/j2/j3/j4/j5/j6/j7"


def enter(page: Page, opened: App, query: str = "") -> tuple[Session, ExportQueue]:
    """Open a page with a link and the exports folder. Returns its session and export queue."""
    session = visit(page, opened, query)
    wait_ready(page, WRIST)
    page.get_by_text("Keep and replay").click()
    return session, visitor_of(opened).operation.panel(ExportsPanel).exports


def is_there(page: Page, node: str) -> bool:
    return bool(page.evaluate("name => !!__viserMutable.nodeRefFromName[name]", node))


def over_the_stage(page: Page) -> str:
    return str(page.evaluate("getComputedStyle(document.body, '::after').content"))


def moment(page: Page) -> Locator:
    return page.get_by_text("moment [s]", exact=True).locator("xpath=ancestor::div[.//input][1]//input").last


def take(page: Page, button: str) -> Download:
    with page.expect_download() as download:
        page.get_by_role("button", name=button, exact=True).click()
    return download.value


def text_of(download: Download) -> str:
    return Path(download.path()).read_text(encoding="utf-8")


def press_key(page: Page, key: str) -> None:
    """Press a key meant for the page; first take the focus from the last button."""
    page.evaluate("document.activeElement?.blur()")
    if key:
        page.keyboard.press(key)


def bring(page: Page, name: str, content: bytes) -> None:
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Load a run").click()
    chooser.value.set_files({"name": name, "mimeType": "application/octet-stream", "buffer": content})


@pytest.mark.thorough
def test_recording_link_and_report_in_a_browser(house: OpenHouse, page_at: PageAt) -> None:
    opened = house()
    page = page_at(1180, 640, permissions=["clipboard-read", "clipboard-write"])
    session, queue = enter(page, opened, "picture=fast&dm=0.12&gizmo=1&speed=2")
    until(page, lambda: session.simulation.time > 4.0, "some seconds of the run")
    look_back(page, session, queue)
    run = export(page, session)
    share(page, opened, session)
    back_to_live(page, session, queue)
    load_files(page, run)
    report(page, opened)


def look_back(page: Page, session: Session, queue: ExportQueue) -> None:
    page.get_by_role("button", name="Watch").click()
    page.get_by_text("This is the past; the live run waits.").wait_for()
    assert session.paused
    until(page, lambda: not is_there(page, HAND), "no handles")
    until(page, lambda: "This is the past" in over_the_stage(page), "the word over the 3-D view")
    until(
        page,
        lambda: queue.player.replay is not None and not queue.player.replay.playing,
        "at rest at its end",
    )
    # From here at the speed at which the page shows the replay.
    ask(session, lambda s: s.change("speed", 1.0))
    press_key(page, "Space")
    until(page, lambda: queue.player.replay is not None and queue.player.replay.playing, "from the beginning")
    # During the replay the page writes into the box, except while the visitor edits it.
    moment(page).click()
    until(
        page,
        lambda: queue.player.replay is not None and not queue.player.replay.playing,
        "at rest for typing",
    )
    replay = queue.player.replay
    assert replay is not None
    until(page, lambda: abs(float(moment(page).input_value()) - replay.time) < 0.01, "where")
    moment(page).fill("9")
    wait_frames(page, 6)
    # The short run has no such moment, and the entry is not finished.
    assert moment(page).input_value() == "9"
    moment(page).fill("0.5")
    moment(page).press("Enter")
    until(page, lambda: abs(replay.time - 0.5) < 1e-6, "half a second")
    press_key(page, ".")
    until(page, lambda: abs(replay.time - 0.505) < 1e-6, "one step more")
    page.get_by_text("the past: 0.5 s").wait_for()
    screenshot(page, "the-past")


LABELS = """() => {
  window.labels = new Set();
  const look = () => document.querySelectorAll("button").forEach((button) => window.labels.add(button.innerText));
  new MutationObserver(look).observe(document.body, { subtree: true, childList: true, characterData: true, attributes: true });
}"""
"""Records the captions that buttons show from now on."""


def copy(page: Page, button: Locator) -> None:
    """Press a copy button and wait for its brief confirmation."""
    page.evaluate(LABELS)
    button.click()
    until(page, lambda: page.evaluate("labels.has('Copied')"), "copied")


def export(page: Page, session: Session) -> bytes:
    live = ask(session, lambda s: s.simulation.history.table())
    rows = [line for line in text_of(take(page, "CSV")).splitlines() if line and not line.startswith("#")]
    assert rows[0].startswith("t,d,lambda,e2")
    # On a slow machine more than the requested length has passed.
    newest = live[len(live) - (len(rows) - 1) :]
    assert [float(row.split(",")[1]) for row in rows[1:6]] == newest[:5, COLUMN["d"]].tolist()
    run = Path(take(page, "Run").path()).read_bytes()
    assert saved_from(run, "it").recorded.steps == len(live)
    assert "window.duet" in text_of(take(page, "HTML"))
    page.get_by_role("button", name="Python").click()
    code = page.locator("pre").inner_text()
    assert "scenes.headless" in code
    copy(page, page.get_by_role("button", name="Copy", exact=True))
    assert page.evaluate("navigator.clipboard.readText()").split() == code.split()
    page.get_by_role("button", name="Close").click()
    return run


def share(page: Page, opened: App, session: Session) -> None:
    copy(page, page.get_by_role("button", name="Copy link"))
    link = page.evaluate("navigator.clipboard.readText()")
    assert link == page.locator(".duet-link input").input_value() and link.startswith(f"{opened.url}/?")
    settings, problems = from_query(
        dict(parse_qsl(urlsplit(link).query)), changed(Settings(), "rig", "table")
    )
    assert (settings, problems) == (session.settings, ()) and settings.run.law.critical_distance == 0.12


def back_to_live(page: Page, session: Session, queue: ExportQueue) -> None:
    wait_frames(page, 4)
    then = world_position(page, WRIST)
    page.get_by_role("button", name="Back to live").click()
    until(page, lambda: queue.player.replay is None and not session.paused, "live")
    until(
        page, lambda: bool(np.abs(world_position(page, WRIST) - then).max() > 1e-4), "the arm of the live run"
    )
    until(page, lambda: is_there(page, HAND), "handles")
    until(page, lambda: over_the_stage(page) == "none", "nothing over the 3-D view")


def load_files(page: Page, run: bytes) -> None:
    bring(page, "mine.duet.npz", run)
    page.get_by_text("This is mine.duet.npz, not the live run.").wait_for()
    until(page, lambda: "This is a loaded run" in over_the_stage(page), "the word over the 3-D view")
    page.get_by_role("button", name="Back to live").click()
    bring(page, "theirs.duet.npz", saved_bytes(piece("ball", 1.0)[0]))
    page.get_by_text("This is theirs.duet.npz, not the live run.").wait_for()
    wait_ready(page, "/ball")
    page.get_by_role("button", name="Back to live").click()
    wait_ready(page, WRIST)
    bring(page, "<b>bad</b>.npz", b"PK")
    page.get_by_text("<b>bad</b>.npz: is not a file of recorded inputs, or is damaged").wait_for()


def report(page: Page, opened: App) -> None:
    written = "Four ways are left,\nI counted them. <b>"
    page.get_by_role("button", name="Lessons", exact=True).click()
    page.locator("button.lesson:has-text('Redundancy')").click()
    page.locator(".duet-l-head").wait_for()
    for key, phase in (("", "Predict"), ("3", "Do"), ("n", "Observe"), ("n", "Explain"), ("n", "Challenge")):
        press_key(page, key)
        page.locator(f".duet-l-head .now:text-is('{phase}')").wait_for()
    page.locator("textarea:visible").fill(written)
    until(page, lambda: lessons_of(visitor_of(opened)).walk.done.words == written, "it has arrived")
    unfold_controls(page)
    page.get_by_text("Keep and replay", exact=True).click()
    made = text_of(take(page, "Lab report on all lessons"))
    assert "&lt;b&gt;" in made and "In 4." in made and made.count("<figure>") == 1
    page.reload()
    page.wait_for_function(
        "words => [...document.querySelectorAll('textarea')].some(box => box.value === words)", arg=written
    )
