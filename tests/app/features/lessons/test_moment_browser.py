"""A run's decisive moment on a lesson's page; see also `tests/app/page/test_moment_browser.py`."""

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
import pytest
from playwright.sync_api import Page, TimeoutError

from app.features.lessons.bookmark import Phase
from app.features.lessons.session.lesson_actions import Choose, Press
from app.session.session import Session
from scenes.history import COLUMN
from tests.app.conftest import OpenHouse, ask
from tests.app.page.test_moment_browser import MOUSE, drag_over_plot, shown_time
from tests.browser import PageAt, screenshot, until, world_position
from tests.tools.lesson_walker import enter

IN_FREE_SPACE = """() => { const name = getComputedStyle(document.body, '::after'), low = innerHeight - parseFloat(name.bottom);
  const [card, plots] = ['#duet-contact', '[data-duet-holds~=plots]'].map(e => document.querySelector(e).getBoundingClientRect());
  return +name.zIndex < 3 && low - parseFloat(name.height) >= card.bottom && low <= plots.top && low > plots.top - 40; }"""
"""True if the moment's name is between contact card and plots, and panels and slides cover it."""


def pseudo(page: Page, element: str, which: str, what: str) -> str:
    look = "([e, w, k]) => getComputedStyle(document.querySelector(e), w).getPropertyValue(k)"
    return str(page.evaluate(look, [element, which, what]))


WRIST = "/arms/right/base/j1/j2/j3/j4/j5/j6/j7"


@dataclass(frozen=True)
class Ended:
    """A page that shows the decisive moment of a run. `end`: the run's last time [s]."""

    page: Page
    session: Session
    end: float


@pytest.fixture(scope="module")
def ended(lasting_house: OpenHouse, lasting_page_at: PageAt) -> Ended:
    opened, page = lasting_house(), lasting_page_at(1024, 768)
    session, run = enter(page, opened, "lesson=6&step=1&theme=light")
    # The page reports its picture's size although the controls are folded.
    page.locator("[data-duet-picture]").first.wait_for(state="attached")
    ask(session, lambda _: [run.act(Choose(0)), run.act(Press("run"))])
    until(page, lambda: session.simulation.steps > 0, "the run")
    ask(session, lambda s: s.control.hurry(3.5))
    until(page, lambda: run.walk.phase is Phase.OBSERVE, "the end of the run")
    until(page, lambda: shown_time(session) is not None, "the moment")
    return Ended(page, session, ask(session, lambda s: s.simulation.time))


def test_the_moment_of_the_smallest_distance_is_shown_with_its_name(ended: Ended) -> None:
    page, session = ended.page, ended.session
    table = ask(session, lambda s: s.simulation.history.table())
    nearest = table[table[:, COLUMN["d"]].argmin(), COLUMN["t"]]
    assert shown_time(session) == pytest.approx(nearest + session.settings.run.dt)
    assert ended.end > nearest + 0.5
    name = "smallest d − dₘ, 3.1 s"
    until(page, lambda: name in pseudo(page, "body", "::after", "content"), "its name over the scene")
    assert name in pseudo(page, ".u-over", "::before", "content")
    narrow = page.add_style_tag(content=".u-over{width:120px!important}")
    assert pseudo(page, ".u-over", "::before", "content") == '"3.1 s"'
    narrow.evaluate("style => style.remove()")
    until(page, lambda: page.evaluate(IN_FREE_SPACE), "the name between the contact card and the plots")
    screenshot(page, "decisive-moment")


def test_a_tooltip_disappears_when_its_button_is_pressed(ended: Ended) -> None:
    """It would cover the result."""
    page = ended.page
    button, hint = (
        page.get_by_role("button", name="Back", exact=True),
        page.locator(".mantine-Tooltip-tooltip"),
    )

    def hinted() -> bool:
        # The lesson may still scroll to its outcome and move the button away from the mouse.
        page.mouse.move(5, 5)
        button.hover()
        with suppress(TimeoutError):
            hint.wait_for(state="visible", timeout=2000)
        return hint.is_visible()

    until(page, hinted, "the hint")
    button.dispatch_event("pointerdown")
    hint.wait_for(state="hidden")


def test_a_drag_over_a_plot_shows_another_moment_until_space_is_pressed(ended: Ended) -> None:
    page, session, end = ended.page, ended.session, ended.end
    # The drawn hand is at its position of that moment.
    before = world_position(page, WRIST)
    drag_over_plot(page, (0.8, 0.3))
    until(page, lambda: abs((shown_time(session) or 0.0) - 0.3 * end) < MOUSE * end, "another moment")
    until(
        page, lambda: np.linalg.norm(world_position(page, WRIST) - before) > 0.02, "the scene of that moment"
    )
    until(
        page,
        lambda: pseudo(page, "body", "::after", "content") == f'"{shown_time(session):.2f} s"',
        "the time over the scene",
    )
    line = float(pseudo(page, ".u-over", "::after", "left").removesuffix("px"))
    box = page.locator(".u-over").first.bounding_box()
    assert box is not None
    assert line / box["width"] == pytest.approx((shown_time(session) or 0.0) / end, abs=0.01)
    assert session.simulation.time == end, "the run itself has not moved"
    # The page no longer shows the moment.
    page.evaluate("document.activeElement?.blur()")
    page.keyboard.press("Space")
    until(page, lambda: shown_time(session) is None and not session.paused, "the run")
    until(
        page,
        lambda: pseudo(page, "body", "::after", "content") in ("none", "normal"),
        "no name over the scene",
    )
