"""Lessons in a real browser: lesson 1 walked by clicks, lesson 3 by keys alone."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Page

from app.hosts import House, PrivateHost
from app.lessons.walkthrough import Phase
from app.page.lesson_run import LessonRun
from app.session import Session
from app.settings import Settings
from scenes.settings import changed, values
from tests.app.conftest import OpenHouse, ask, live_sessions
from tests.browser import PageAt, close_software_note, screenshot, until


def enter(page: Page, opened: House, query: str) -> tuple[Session, LessonRun]:
    """Open a lesson by its link; the session and its lessons."""
    page.set_default_timeout(60_000)
    page.goto(f"{opened.url}/?{query}")
    page.locator(".duet-l-head").wait_for()
    until(page, lambda: len(live_sessions(opened)) == 1, "one session")
    close_software_note(page)
    assert isinstance(opened.host, PrivateHost)
    (number,) = live_sessions(opened)
    return live_sessions(opened)[number], opened.host._stands[number].lessons


def press(page: Page, label: str) -> None:
    """Press a button of the panel."""
    page.get_by_role("button", name=re.compile(rf"^\s*{label}")).first.click()


def at(page: Page, run: LessonRun, phase: Phase, step: int) -> None:
    """Wait for a part of a step."""
    until(page, lambda: (run.walk.phase, run.walk._step) == (phase, step), f"{phase} of step {step + 1}", 60.0)
    page.locator(f".duet-l-head .phases .now:text-is('{phase.value.capitalize()}')").wait_for()


def test_lesson_1_by_clicks(house: OpenHouse, page_at: PageAt) -> None:
    opened = house(changed(Settings(), "dm", 0.12))
    page = page_at(1440, 900)
    session, run = enter(page, opened, "lesson=1")
    assert page.get_by_role("button", name="Run (predict first)").is_disabled()
    for step, choice in enumerate((1, 2)):
        at(page, run, Phase.PREDICT, step)
        press(page, f"{choice} ")
        at(page, run, Phase.DO, step)
        ask(session, lambda s: s.change("speed", 2.0))
        page.get_by_role("button", name="Run", exact=True).click()
        at(page, run, Phase.OBSERVE, step)
        assert run.walk.done.outcome is not None and not run.walk.done.outcome.reference
        card = page.locator(".duet-l-verdict .card")
        assert ("It went otherwise" if choice == 1 else "You predicted it") in card.inner_text()
        said = page.locator("#duet-say")
        verdict = card.locator(".mark b").inner_text()
        until(page, lambda said=said, verdict=verdict: verdict in (said.text_content() or ""), "announced")
        if choice == 1:
            press(page, "Show me why")
            until(page, lambda: run.view().showing, "the run that shows why")
            press(page, "Back to the outcome")
            until(page, lambda: not run.view().showing, "the outcome")
        press(page, "Next: explain")
        at(page, run, Phase.EXPLAIN, step)
        assert page.locator(".duet-formula svg").count() > 0
        press(page, "Next step")
    at(page, run, Phase.DO, 2)
    press(page, "Next: ")
    while run.walk.phase is not Phase.CHALLENGE:
        before = run.walk.phase
        press(page, "Next: ")
        until(page, lambda before=before: run.walk.phase is not before, "the next part")
    press(page, "Check my run")
    page.locator(".duet-l-attempt .card.wrong").wait_for()
    assert "must be" in page.locator(".duet-l-attempt").inner_text()
    for count in (1, 2, 3):
        press(page, f"Hint {count} of 3")
        until(page, lambda count=count: page.locator(".duet-l-hints li").count() == count, "a hint")
    box = page.locator(".duet-l-head").bounding_box()
    canvas = page.evaluate("(() => { const b = __viserMutable.canvas.getBoundingClientRect(); return [b.left, b.right]; })()")
    assert box is not None and box["x"] + box["width"] <= canvas[0] + 1.0, "the panel stands beside the scene, not over it"
    screenshot(page, "lesson-1-challenge")
    press(page, "Leave the lessons")
    until(page, lambda: not run.open, "leaving")
    mine = {key: value for key, value in values(session.settings).items() if key != "picture"}
    assert mine == {key: value for key, value in values(changed(Settings(), "dm", 0.12)).items() if key != "picture"}


def test_lesson_3_by_keys_alone(house: OpenHouse, page_at: PageAt) -> None:
    opened = house()
    page = page_at(1024, 768)
    session, run = enter(page, opened, "lesson=3")
    for step, answer in enumerate(("3", "1")):
        at(page, run, Phase.PREDICT, step)
        page.keyboard.press("Space")
        page.keyboard.press(answer)
        at(page, run, Phase.DO, step)
        page.keyboard.press("]")
        until(page, lambda: session.settings.page.speed == 2.0, "twice as fast")
        page.keyboard.press("Space")
        at(page, run, Phase.OBSERVE, step)
        if answer == "1":
            page.keyboard.press("y")
            until(page, lambda: run.view().showing, "the run that shows why")
            page.keyboard.press("b")
            until(page, lambda: not run.view().showing, "the outcome")
        page.keyboard.press("ArrowRight")
        at(page, run, Phase.EXPLAIN, step)
        page.keyboard.press("n")
    at(page, run, Phase.DO, 2)
    page.keyboard.press("Space")
    at(page, run, Phase.OBSERVE, 2)
    page.keyboard.press("n")
    at(page, run, Phase.CHALLENGE, 2)
    formula = run.walk.done.outcome
    assert formula is not None
    pull, lever = (
        next(v[0] for m, v in zip(run.walk.step.measurements, formula.values, strict=True) if m.id == name)
        for name in ("pull", "lever")
    )
    assert pull is not None and lever is not None
    boxes = [
        page.locator("label")
        .filter(has_text=re.compile(f"^{re.escape(label)}$"))
        .locator("xpath=../../..")
        .locator("input, textarea")
        .first
        for label in run.view().forecasts
    ]
    for box, v in zip(boxes, (0.1, 0.2, 0.4), strict=True):
        box.focus()
        page.keyboard.type(f"{(v + pull) / lever:.3f}")
        until(page, lambda v=v: any(n is not None and abs(n - (v + pull) / lever) < 1e-3 for n in run.said), "a number")
    page.keyboard.press("Tab")
    page.keyboard.press("c")
    until(page, lambda: run.walk.done.attempts > 0, "the attempt", 60.0)
    assert run.walk.done.passed, run.view().attempt
    page.keyboard.press("x")
    until(page, lambda: not run.open, "leaving")


def test_progress_survives_a_reload(house: OpenHouse, page_at: PageAt) -> None:
    opened = house()
    page = page_at(1024, 768)
    _, run = enter(page, opened, "lesson=1&step=2")
    press(page, "4 ")
    at(page, run, Phase.DO, 1)
    page.reload()
    page.locator(".duet-l-verdict .mine").wait_for()
    assert isinstance(opened.host, PrivateHost)
    until(page, lambda: len(live_sessions(opened)) == 1, "the old one gone")
    (number,) = live_sessions(opened)
    again = opened.host._stands[number].lessons
    assert again is run and again.walk.done.choice == 3 and again.walk.step.id == "pose"


@pytest.mark.parametrize(("width", "height"), [(390, 844)])
def test_on_a_phone_a_lesson_begins_at_its_top(house: OpenHouse, page_at: PageAt, width: int, height: int) -> None:
    opened = house()
    page = page_at(width, height)
    enter(page, opened, "lesson=1")
    head = page.locator(".duet-l-head")
    until(page, lambda: (head.bounding_box() or {"y": 9e9})["y"] < height - 250, "the lesson in view")
    box = head.bounding_box()
    assert box is not None and box["x"] >= 0.0 and box["x"] + box["width"] <= width + 1.0
    screenshot(page, "lesson-phone")
