"""Tests of lessons beside those of the core in the file `test_moment_browser.py`."""

from contextlib import suppress

import numpy as np
import pytest
from playwright.sync_api import Page, TimeoutError

from app.features.lessons.bookmark import Phase
from app.features.lessons.session.lesson_actions import Choose, Press
from scenes.history import COLUMN
from tests.app.conftest import OpenHouse, ask
from tests.app.page.test_moment_browser import MOUSE, drag_over_plot, shown_time
from tests.browser import PageAt, screenshot, until, world_position
from tests.tools.lesson_walker import enter

IN_FREE_SPACE = """() => { const name = getComputedStyle(document.body, '::after'), low = innerHeight - parseFloat(name.bottom);
  const [card, plots] = ['#duet-contact', '[data-duet-holds~=plots]'].map(e => document.querySelector(e).getBoundingClientRect());
  return +name.zIndex < 3 && low - parseFloat(name.height) >= card.bottom && low <= plots.top && low > plots.top - 40; }"""
"""Whether the name of the moment lies below the contact card and above the plots, and panels and slides cover it, not it them."""


def pseudo(page: Page, element: str, which: str, what: str) -> str:
    look = "([e, w, k]) => getComputedStyle(document.querySelector(e), w).getPropertyValue(k)"
    return str(page.evaluate(look, [element, which, what]))


def test_after_a_run_the_page_stands_at_its_moment(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1024, 768)
    session, run = enter(page, house(), "lesson=6&step=1&theme=light")
    # The controls are folded, and the page says how large its picture is all the same.
    page.locator("[data-duet-picture]").first.wait_for(state="attached")
    ask(session, lambda _: [run.act(Choose(0)), run.act(Press("run"))])
    until(page, lambda: session.simulation.steps > 0, "the run")
    ask(session, lambda s: s.control.hurry(3.5))
    until(page, lambda: run.walk.phase is Phase.OBSERVE, "the end of the run")
    until(page, lambda: shown_time(session) is not None, "the moment")
    table = ask(session, lambda s: s.simulation.history.table())
    nearest = table[table[:, COLUMN["d"]].argmin()]
    end = ask(session, lambda s: s.simulation.time)
    assert (
        shown_time(session) == pytest.approx(nearest[COLUMN["t"]] + session.settings.run.dt)
        and end > nearest[COLUMN["t"]] + 0.5
    )
    until(
        page,
        lambda: "smallest d − dₘ, 3.1 s" in pseudo(page, "body", "::after", "content"),
        "its name over the scene",
    )
    assert "smallest d − dₘ, 3.1 s" in pseudo(page, ".u-over", "::before", "content")
    narrow = page.add_style_tag(content=".u-over{width:120px!important}")
    assert pseudo(page, ".u-over", "::before", "content") == '"3.1 s"'
    narrow.evaluate("style => style.remove()")
    until(page, lambda: page.evaluate(IN_FREE_SPACE), "the name between the contact card and the plots")
    # The hand of the picture is where it was then, not where it is now.
    wrist = "/arms/right/base/j1/j2/j3/j4/j5/j6/j7"
    before = np.array(world_position(page, wrist))
    screenshot(page, "decisive-moment")
    # A hint does not cover what comes of the button once that is pressed.
    button = page.get_by_role("button", name="Back", exact=True)
    hint = page.locator(".mantine-Tooltip-tooltip")

    def hinted() -> bool:
        # The lesson may still move to its outcome, and the button away from the mouse.
        page.mouse.move(5, 5)
        button.hover()
        with suppress(TimeoutError):
            hint.wait_for(state="visible", timeout=2000)
        return hint.is_visible()

    until(page, hinted, "the hint")
    button.dispatch_event("pointerdown")
    hint.wait_for(state="hidden")
    drag_over_plot(page, (0.8, 0.3))
    until(page, lambda: abs((shown_time(session) or 0.0) - 0.3 * end) < MOUSE * end, "another moment")
    until(
        page,
        lambda: float(np.linalg.norm(np.array(world_position(page, wrist)) - before)) > 0.02,
        "the scene of then",
    )
    until(
        page,
        lambda: pseudo(page, "body", "::after", "content") == f'"{shown_time(session):.2f} s"',
        "the time over the scene",
    )
    line = float(pseudo(page, ".u-over", "::after", "left").removesuffix("px"))
    width = float(page.locator(".u-over").first.bounding_box()["width"])  # pyright: ignore[reportOptionalSubscript]
    assert line / width == pytest.approx((shown_time(session) or 0.0) / end, abs=0.01)
    assert session.simulation.time == end, "the run itself stands where it was"
    # Space begins the run once more, and nothing of the moment is left on the page.
    page.evaluate("document.activeElement?.blur()")
    page.keyboard.press("Space")
    until(page, lambda: shown_time(session) is None and not session.paused, "the run")
    until(
        page,
        lambda: pseudo(page, "body", "::after", "content") in ("none", "normal"),
        "no name over the scene",
    )
