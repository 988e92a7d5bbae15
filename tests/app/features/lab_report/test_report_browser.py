"""A student's reason beside the outcome, and the contrast run for a wrong answer."""

from typing import Literal

import pytest
from playwright.sync_api import Page

from app.features.lessons.bookmark import Phase
from app.features.lessons.session.lesson_actions import Choose
from tests.app.conftest import OpenHouse, ask
from tests.browser import PageAt, screenshot, until, wait_frames
from tests.tools.lesson_hands import press
from tests.tools.lesson_walker import enter

REASON = "the ball is <b>far</b> & still"

WATCH = """() => { window.flashed = []; document.addEventListener("animationstart", ({ target, animationName }) => {
  const { animationDuration, animationIterationCount } = getComputedStyle(target);
  if (/^duet-(flash|mark)$/.test(animationName)) flashed.push([animationName, target.innerText.trim().split(/\\s/)[0],
    1000 * parseFloat(animationDuration) * animationIterationCount]); }); }"""
"""Records each flash: animation name, first word of the element, duration [ms]."""

FLASHES = "() => document.getAnimations().filter(a => /^duet-(flash|mark)$/.test(a.animationName)).length"


def why_flashes(page: Page, motion: Literal["no-preference", "reduce"], animation: str) -> None:
    """Start the contrast run; check that the differing control is marked once, for 2 s."""
    page.emulate_media(reduced_motion=motion)
    # Recorded, because on a busy machine a flash may end before it is polled.
    page.evaluate("window.flashed = []")
    press(page, "Show me why")
    page.locator(".duet-l-verdict b").get_by_text("Here you would be right: n = 10", exact=True).wait_for()
    until(page, lambda: page.evaluate("flashed") == [[animation, "order", 2000]], "the control flashes")


@pytest.mark.thorough
def test_a_reason_is_beside_the_outcome_and_a_click_runs_the_contrast(
    house: OpenHouse, page_at: PageAt
) -> None:
    page = page_at(1440, 900, fresh=True)
    session, run = enter(page, house(), "lesson=4&step=3&theme=light")
    box = page.get_by_label("Because …", exact=True).locator("visible=true")
    box.fill(REASON)
    until(page, lambda: run.walk.done.because == REASON, "the reason")
    ask(session, lambda _: run.act(Choose(0)))
    until(page, lambda: run.walk.phase is Phase.DO, "the answer")
    press(page, "Skip the run")
    until(page, lambda: run.walk.phase is Phase.OBSERVE, "the outcome")
    said = page.locator(".duet-l-verdict dd").nth(1)
    until(page, lambda: said.inner_text() == REASON and box.count() == 0, "the reason beside the outcome")

    # A wrong answer: the run in which it would be right, with the difference marked.
    page.evaluate(WATCH)
    why_flashes(page, "no-preference", "duet-flash")
    until(page, lambda: session.simulation.time > 1.5, "the run starts by itself")
    legend = page.locator(".duet-caption:visible").first
    until(
        page,
        lambda: legend.locator("span:has(i:not([class*=d]))").all_inner_texts() == ["n = 10"],
        "the run's curve",
    )
    until(
        page, lambda: "n = 1" in legend.locator("span:has(i.dash)").all_inner_texts(), "the curve beside it"
    )
    other = session.ghost
    assert other is not None and other.settings == run.walk.step.setup.run
    screenshot(page, "contrast")
    until(page, lambda: page.evaluate(FLASHES) == 0, "the mark is gone")
    press(page, "Back to the outcome")
    page.locator(".duet-l-verdict b").get_by_text("Here you would be right").wait_for(state="detached")
    wait_frames(page, 3)
    why_flashes(page, "reduce", "duet-mark")
    until(page, lambda: page.evaluate(FLASHES) == 0, "the mark is gone")
