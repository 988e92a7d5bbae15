"""What a student sees of a contrast, of a reason and of the four null-space motions, in a real browser."""

import numpy as np
import pytest
from playwright.sync_api import Page

from app.export.lab_report import done_in, lab_bytes
from app.lessons.bookmark import Phase
from app.lessons.session.lesson_actions import Choose, GoOn
from app.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from tests.app.conftest import OpenHouse, ask
from tests.browser import PageAt, screenshot, until
from tests.tools.lesson_hands import press
from tests.tools.lesson_walker import enter

REASON = "the ball is <b>far</b> & still"

WATCH = """() => { window.flashed = []; document.addEventListener("animationstart", ({ target, animationName }) => {
  const { animationDuration, animationIterationCount } = getComputedStyle(target);
  if (/^duet-(flash|mark)$/.test(animationName)) flashed.push([animationName, target.innerText.trim().split(/\\s/)[0],
    1000 * parseFloat(animationDuration) * animationIterationCount]); }); }"""
"""Notes what begins to flash: name of the animation, first word of the element, for how long [ms]."""

FLASHES = "() => document.getAnimations().filter(a => /^duet-(flash|mark)$/.test(a.animationName)).length"


def observe(page: Page, session: Session, run: LessonSession, answer: int) -> None:
    """Answer wrongly and skip the run."""
    ask(session, lambda _: run.act(Choose(answer)))
    until(page, lambda: run.walk.phase is Phase.DO, "the answer")
    press(page, "Skip the run")
    until(page, lambda: run.walk.phase is Phase.OBSERVE, "the outcome")


@pytest.mark.parametrize(("motion", "animation"), [("no-preference", "duet-flash"), ("reduce", "duet-mark")])
def test_a_click_runs_the_contrast_names_it_and_marks_the_changed_control(
    house: OpenHouse, page_at: PageAt, motion: str, animation: str
) -> None:
    page = page_at(1440, 900, reduced_motion=motion)
    session, run = enter(page, house(), "lesson=4&step=3&theme=light")
    observe(page, session, run, 0)
    # On a busy machine it may be over before it is looked at.
    page.evaluate(WATCH)
    press(page, "Show me why")
    page.locator(".duet-l-verdict b").get_by_text("Here you would be right: n = 10", exact=True).wait_for()
    until(page, lambda: page.evaluate("flashed") == [[animation, "order", 2000]], "the control flashes")
    until(page, lambda: session.simulation.time > 3.0, "it runs by itself")
    legend = page.locator(".duet-caption:visible").first
    until(page, lambda: legend.locator("span:has(i:not([class*=d]))").all_inner_texts() == ["n = 10"], "the run's curve")
    until(page, lambda: "n = 1" in legend.locator("span:has(i.dash)").all_inner_texts(), "the curve beside it")
    other = session.ghost
    assert other is not None and other.settings == run.walk.step.setup.run
    screenshot(page, f"contrast-{motion}")
    until(page, lambda: page.evaluate(FLASHES) == 0, "the mark is gone")


def test_a_reason_stands_beside_the_outcome_on_the_page_and_in_the_report(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1024, 768)
    opened = house()
    session, run = enter(page, opened, "lesson=4&step=3")
    box = page.get_by_label("Because …", exact=True).locator("visible=true")
    box.fill(REASON)
    until(page, lambda: run.walk.done.because == REASON, "the reason")
    observe(page, session, run, 0)
    said = page.locator(".duet-l-verdict dd").nth(1)
    until(page, lambda: said.inner_text() == REASON and box.count() == 0, "the reason beside the outcome")
    report = page_at(1024, 768)
    done = ask(session, lambda _: done_in(run.book.lessons, run.walk.done_in, {}))
    report.set_content(lab_bytes(done, "en").decode())
    reason, outcome = (report.locator(".beside > div").nth(i) for i in (0, 1))
    assert REASON in reason.inner_text() and "Hand error" in outcome.inner_text()
    left, right = reason.bounding_box(), outcome.bounding_box()
    assert left is not None and right is not None and left["x"] + left["width"] <= right["x"] and left["y"] == right["y"]


def test_a_slider_moves_the_elbow_and_the_hand_stays(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1440, 900)
    session, run = enter(page, house(), "lesson=1&step=1")
    ask(session, lambda _: run.act(Choose(2)))
    while run.walk.phase is not Phase.CHALLENGE:
        before = run.walk.phase
        ask(session, lambda _: run.act(GoOn()))
        until(page, lambda before=before: run.walk.phase is not before, f"on from {before}")

    def places(s: Session) -> tuple[np.ndarray, np.ndarray]:
        kinematics, arm = s.simulation.kinematics, s.simulation.guided
        return kinematics.hand_pose(arm).translation.copy(), kinematics.joint_point(arm.elbow)

    hand, elbow = ask(session, places)
    row = page.locator("label:visible").get_by_text("swing the elbow", exact=True).locator("xpath=../../..")
    ways: list[np.ndarray] = []
    for degrees in ("50", "-50"):
        row.locator("input[type=text]").last.fill(degrees)
        page.keyboard.press("Tab")

        def far() -> bool:
            way = ask(session, places)[1] - elbow
            return float(np.linalg.norm(way)) > 0.05 and all(way @ before < 0.0 for before in ways)

        until(page, far, "the elbow on its side")
        ways.append(ask(session, places)[1] - elbow)
        assert np.linalg.norm(ask(session, places)[0] - hand) < 5e-4
    screenshot(page, "null-motions")
    page.keyboard.press("r")
    until(page, lambda: row.locator("input[type=text]").last.input_value() == "0", "a fresh run begins at 0")
