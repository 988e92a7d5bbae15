"""No control of the page moves while notices appear and disappear under the autopilot."""

import re
from time import perf_counter

import pytest
from playwright.sync_api import Page

from scenes.experiments import EXPERIMENTS
from tests.app.conftest import FRAME, ByHand, Made
from tests.browser import PageAt, until, wait_frames

WATCH = """() => {
  const kinds = 'button, [role=button], a[href], input, select, textarea, [role=slider], [role=tab]';
  const name = one => one.getAttribute('aria-label') || one.textContent.trim() || one.id;
  const places = new Map(), seen = window.duetSeen = { controls: 0, moved: {}, notices: [] };
  const look = () => {
    for (const one of document.querySelectorAll(kinds)) {
      const { x, y, width, height } = one.getBoundingClientRect();
      if (!width) continue;
      const place = [x, y, width, height].map(Math.round), known = places.get(one);
      if (!known) places.set(one, place);
      else if (known.some((value, i) => Math.abs(value - place[i]) > 1)) seen.moved[name(one)] = [known, place];
    }
    seen.controls = places.size;
    const notices = [...document.querySelectorAll('.duet-status > .halt, .duet-status > .alarm')]
      .filter(one => one.checkVisibility()).map(one => one.textContent).join(' | ');
    if (!seen.notices.includes(notices)) seen.notices.push(notices);
    window.duetWatch = requestAnimationFrame(look);
  };
  look();
}"""
"""Records, at every drawn frame, controls that are not at their first place, and the notices."""

SETTINGS = re.compile("All settings|Fewer settings")
"""The last control of the page."""

AT_ONCE = 16
"""Server frames between two checks of the page."""


def first_screen(page: Page, opened: ByHand, query: str) -> None:
    page.goto(f"{opened.house.url}/?{query}")

    def built() -> bool:
        for _ in range(AT_ONCE):
            opened.frame()
        return page.locator(".duet-eq .live").count() > 0 and page.get_by_text(SETTINGS).count() > 0

    until(page, built, "a page that is built")
    page.locator("#duet-note").wait_for(state="detached")
    # The page was built in real time; from now on the frames run faster.
    opened.now = perf_counter()
    wait_frames(page, 10)


def watched(page: Page, opened: ByHand, seconds: float) -> dict[str, object]:
    """A page's record of its controls during some seconds of the run."""
    page.evaluate(WATCH)
    for _ in range(round(seconds / FRAME / AT_ONCE)):
        for _ in range(AT_ONCE):
            opened.frame()
        wait_frames(page, 2)
    seen: dict[str, object] = page.evaluate(
        "() => { cancelAnimationFrame(window.duetWatch); return window.duetSeen; }"
    )
    return seen


def test_no_control_moves_when_a_notice_appears_or_disappears(by_hand: Made, page_at: PageAt) -> None:
    page, opened = page_at(1440, 900), by_hand(sessions=2)
    # The approach is sometimes faster than this slow retreat.
    first_screen(page, opened, "panel=small&v=0.05")
    seen = watched(page, opened, 12.0)
    assert isinstance(seen["notices"], list) and len(seen["notices"]) > 1, "the notices did not change"
    assert seen["controls"] and seen["moved"] == {}, seen


@pytest.mark.thorough
@pytest.mark.parametrize("scene", EXPERIMENTS)
@pytest.mark.parametrize(
    ("panel", "width", "height"), [("small", 1440, 900), ("small", 390, 844), ("all", 1024, 768)]
)
def test_no_control_moves_in_a_minute_of_autopilot(
    by_hand: Made, page_at: PageAt, scene: str, panel: str, width: int, height: int
) -> None:
    page, opened = page_at(width, height), by_hand(sessions=2)
    first_screen(page, opened, f"panel={panel}&scene={scene}&speed=2")
    seen = watched(page, opened, 30.0)
    assert seen["controls"] and seen["moved"] == {}, seen


ROOM = """() => {
  const bottom = document.querySelector('.duet-what').getBoundingClientRect().bottom;
  const status = document.querySelector('.duet-status[role=status]').getBoundingClientRect();
  const pause = [...document.querySelectorAll('button')].find(one => /Pause|Continue/.test(one.textContent)).getBoundingClientRect();
  const shown = document.querySelector('.duet-what > span').getBoundingClientRect();
  return { kept: status.height, blank: pause.top - shown.bottom, tip: bottom - shown.bottom };
}"""
"""Heights between the tip and the clock [CSS px]."""


def test_the_gap_between_tip_and_clock_holds_only_two_lines(by_hand: Made, page_at: PageAt) -> None:
    page, opened = page_at(1440, 900), by_hand(sessions=2)
    first_screen(page, opened, "panel=small")
    room = page.evaluate(ROOM)
    assert room["tip"] < 1.0 and room["kept"] > 40.0 and room["blank"] < room["kept"] + 18.0, room
