"""Moments on the real page: a drag over a plot shows another one."""

import pytest
from playwright.sync_api import Page

from app.session.replay_player import ReplayPlayer
from app.session.session import Session
from tests.accessibility import accessible
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import drag, visit
from tests.browser import PageAt, until

MOUSE = 0.03
"""How exactly a mouse chooses a moment [share of the axis]."""


def player_of(session: Session) -> ReplayPlayer:
    return session.player


def shown_time(session: Session) -> float | None:
    replay = player_of(session).replay
    return None if replay is None else replay.time


def drag_over_plot(page: Page, shares: tuple[float, ...], place: int = 0) -> None:
    """Press at the first share of a plot's width, drag to the others, and let go."""
    box = page.locator(".u-over").nth(place).bounding_box()
    assert box is not None
    drag(page, [(box["x"] + share * box["width"], box["y"] + box["height"] / 2) for share in shares])


@pytest.mark.thorough
def test_a_drag_over_a_plot_shows_another_moment(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1024, 768)
    session = visit(page, house(), "speed=2")
    usual = {"scene": "imitation", "law": "smooth_priority", "pairs": "smooth", "plot": "none", "speed": 1.0}
    ask(session, lambda s: [*(s.change(key, value) for key, value in usual.items()), s.reset(), s.control.hurry(3.0)])
    until(page, lambda: session.simulation.time > 3.0, "some seconds of the run")
    # While it runs, a plot is only looked at.
    drag_over_plot(page, (0.7, 0.4))
    assert not session.paused and shown_time(session) is None
    page.get_by_role("button", name="Pause", exact=True).click()
    until(page, lambda: session.paused, "the pause")
    page.locator("[data-duet-span]").first.wait_for(state="attached")
    end = ask(session, lambda s: s.simulation.time)

    def span() -> list[float]:
        return [float(one) for one in (page.locator("[data-duet-span]").first.get_attribute("data-duet-span") or "0 0").split()]

    # The next refresh of a plot brings its axis up to the pause; on a busy machine it no longer begins at 0.
    until(page, lambda: span()[1] > end - 0.02, "the run until its pause in the plots")
    begin = span()[0]
    drag_over_plot(page, (0.9, 0.5), 1)
    wanted, within = 0.5 * (begin + end), MOUSE * (end - begin)
    until(page, lambda: abs((shown_time(session) or 0.0) - wanted) < within, "the moment")
    page.get_by_text("Space goes on from the end").wait_for()
    accessible(page)
    page.evaluate("document.activeElement?.blur()")
    page.keyboard.press("Space")
    until(page, lambda: shown_time(session) is None and session.simulation.time > end, "the run goes on from its end")
