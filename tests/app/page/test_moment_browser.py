"""Moments on the real page: scene, plots and words stand at the decisive one after a run, a drag over a plot shows another one, and a
jump of q̇ is an edge in the plot over time, and single steps in the microscope."""

import numpy as np
import pytest
from playwright.sync_api import Page

from app.features.studies.background_studies import BackgroundStudies
from app.session.replay_player import ReplayPlayer
from app.session.session import Session
from scenes.history import COLUMN
from scenes.smoothness import AROUND, avoiding_rates
from tests.accessibility import accessible
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import drag, visit
from tests.browser import PageAt, screenshot, until

MOUSE = 0.03
"""How exactly a mouse chooses a moment [share of the axis]."""


STEEPEST = """() => Math.max(...Object.values(__viserTestpoints.uplots).map(({ chart }) => {
  const [x, ...lines] = chart.data;
  let most = 0;
  for (let i = 1; i < x.length; i++) if (x[i] - x[i - 1] < 0.00501)
    for (const y of lines) if (y.length) most = Math.max(most, Math.abs(y[i] - y[i - 1]) || 0);
  return most;
}))"""
"""The largest change of any line within one time step."""

DOTS = "() => [...document.querySelectorAll('.duet-chart .dots')].map((p) => p.getAttribute('d').split('h0').length - 1)"


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


def test_a_jump_is_an_edge_has_its_steps_and_a_drag_over_a_plot_shows_another_moment(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1024, 768)
    session = visit(page, house(), "law=strict_switched&pairs=single&plot=rates&speed=2")
    # From the beginning, as the plots show no more than the last seconds, of which a busy machine may need many to open the page.
    ask(session, lambda s: [s.reset(), s.hurry(7.0)])
    until(page, lambda: session.simulation.time > 7.0, "the jump")
    # Before the jump leaves the plot.
    ask(session, lambda s: s.toggle_pause())
    until(page, lambda: session.paused, "the pause")
    table = ask(session, lambda s: s.simulation.history.table())
    jump = float(np.abs(np.diff(avoiding_rates(session.simulation, table)[40:], axis=0)).max())
    assert jump > 0.3
    page.wait_for_function(f"({STEEPEST})() > {0.999 * jump}")
    page.get_by_role("button", name="dt", exact=True).click()
    page.wait_for_function(f"String(({DOTS})()) === '{2 * AROUND + 1},{4 * AROUND + 1}'")
    page.get_by_text(f"{jump:.3g} at 5 ms").wait_for()
    # Any other instant by the slider and its keys.
    knob = page.get_by_role("slider", name="moment [s]")

    def looked_at() -> float:
        span = session.parts.of(BackgroundStudies).microscope.span
        assert span is not None
        return span[2]

    found = looked_at()
    until(page, lambda: float(knob.get_attribute("aria-valuenow") or 0.0) == pytest.approx(found, abs=0.003), "its place")
    screenshot(page, "microscope")
    knob.press("ArrowLeft")
    until(page, lambda: looked_at() == pytest.approx(found - 0.005, abs=0.003), "one step back")
    knob.press("Home")
    until(page, lambda: looked_at() == table[0, COLUMN["t"]], "the beginning")
    page.get_by_text(f"over t − {looked_at():.3f} s").wait_for()

    usual = {"scene": "imitation", "law": "smooth_priority", "pairs": "smooth", "plot": "none", "speed": 1.0}
    ask(session, lambda s: [*(s.change(key, value) for key, value in usual.items()), s.reset(), s.hurry(3.0)])
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
