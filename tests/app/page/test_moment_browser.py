"""Moments in a real browser: a drag over a plot shows another moment."""

from collections.abc import Callable
from time import perf_counter

import pytest
from playwright.sync_api import Page

from app.session.actions import Pause
from app.session.replay_player import Mark, ReplayPlayer
from app.session.session import Session
from controllers.errors import LazyText
from tests.accessibility import accessible
from tests.app.conftest import ByHand, Made, OpenHouse, ask, visitor_of
from tests.app.page.by_hand import drag, visit
from tests.browser import PageAt, until

MOUSE = 0.03
"""Precision of a moment chosen by mouse [share of the axis]."""


def player_of(session: Session) -> ReplayPlayer:
    return session.player


def shown_time(session: Session) -> float | None:
    replay = player_of(session).replay
    return None if replay is None else replay.time


def drag_over_plot(page: Page, shares: tuple[float, ...], place: int = 0) -> None:
    """Press at the first share of a plot's width, drag to the others, and release."""
    box = page.locator(".u-over").nth(place).bounding_box()
    assert box is not None
    drag(page, [(box["x"] + share * box["width"], box["y"] + box["height"] / 2) for share in shares])


@pytest.mark.thorough
def test_a_drag_over_a_plot_shows_another_moment(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1024, 768)
    session = visit(page, house(), "speed=2")
    usual = {"scene": "imitation", "law": "smooth_priority", "pairs": "smooth", "plot": "none", "speed": 1.0}
    ask(
        session,
        lambda s: [*(s.change(key, value) for key, value in usual.items()), s.reset(), s.control.hurry(3.0)],
    )
    until(page, lambda: session.simulation.time > 3.0, "some seconds of the run")
    # A drag has no effect while the run moves.
    drag_over_plot(page, (0.7, 0.4))
    assert not session.paused and shown_time(session) is None
    page.get_by_role("button", name="Pause", exact=True).click()
    until(page, lambda: session.paused, "the pause")
    page.locator("[data-duet-span]").first.wait_for(state="attached")
    end = ask(session, lambda s: s.simulation.time)

    def span() -> list[float]:
        return [
            float(one)
            for one in (
                page.locator("[data-duet-span]").first.get_attribute("data-duet-span") or "0 0"
            ).split()
        ]

    # The axis reaches the pause at the plot's next refresh; on a busy machine it may not begin at 0.
    until(page, lambda: span()[1] > end - 0.02, "the run until its pause in the plots")
    begin = span()[0]
    drag_over_plot(page, (0.9, 0.5), 1)
    wanted, within = 0.5 * (begin + end), MOUSE * (end - begin)
    until(page, lambda: abs((shown_time(session) or 0.0) - wanted) < within, "the moment")
    page.get_by_text("Space continues from the end").wait_for()
    accessible(page)
    page.evaluate("document.activeElement?.blur()")
    page.keyboard.press("Space")
    until(
        page,
        lambda: shown_time(session) is None and session.simulation.time > end,
        "the run goes on from its end",
    )


NAMES = """() => [...document.querySelectorAll('.u-over')].map(frame => {
  const style = getComputedStyle(frame, '::before');
  const { left, top, width } = frame.getBoundingClientRect();
  const px = name => parseFloat(style[name]), shift = new DOMMatrix(style.transform).e;
  const wide = px('width') + px('paddingLeft') + px('paddingRight');
  const canvas = frame.closest('.uplot').querySelector('canvas').getBoundingClientRect();
  return { text: style.content, line: px('lineHeight'), top: px('top'), left: px('left') + shift, right: px('left') + shift + wide,
    width, above: canvas.top - top };
})"""
"""Name of the marked moment at every plot over time, with its place relative to the plot's frame [CSS px]."""


def after_a_frame(opened: ByHand, seen: Callable[[], object]) -> Callable[[], bool]:
    """Function that makes one more server frame and evaluates `seen`."""

    def look() -> bool:
        opened.frame()
        return bool(seen())

    return look


def said(page: Page, words: str) -> Callable[[], bool]:
    """Function: True if every plot names the moment with `words`."""
    return lambda: {one["text"] for one in page.evaluate(NAMES)} == {f'"{words}"'}


@pytest.mark.thorough
def test_the_name_of_a_moment_is_above_the_frame_of_every_plot(by_hand: Made, page_at: PageAt) -> None:
    page, opened = page_at(1024, 768), by_hand(sessions=2)
    page.goto(f"{opened.house.url}/?panel=small")
    until(page, after_a_frame(opened, lambda: page.locator(".u-over").count() == 2), "two plots")
    # The page was built in real time; from now on the frames run faster.
    opened.now = perf_counter()
    session = visitor_of(opened).session
    until(page, after_a_frame(opened, lambda: session.simulation.time > 4.0), "some seconds of the run")
    session.handlers.do(Pause())
    words = {
        "short": "jump",
        "long": "a name of a moment that no plot of this width has room for, in any language",
    }
    for time, length in ((0.1, "short"), (2.0, "short"), (3.9, "short"), (2.0, "long")):
        player_of(session).review(time, Mark(time, LazyText(words[length])))
        shown = f"{time:.1f} s" if length == "long" else f"jump, {time:.1f} s"
        until(page, after_a_frame(opened, said(page, shown)), f"the name at {time} s")
        for name in page.evaluate(NAMES):
            assert name["above"] - 0.5 <= name["top"] and name["top"] + name["line"] <= 0.5, name
            assert name["left"] >= -0.5 and name["right"] <= name["width"] + 0.5, name
        player_of(session).leave()
