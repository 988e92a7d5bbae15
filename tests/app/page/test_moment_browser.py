"""Moments on the real page: scene, plots and words stand at the decisive one after a run, a drag over a plot shows another one, and a
jump of q̇ is an edge in the plot over time, and single steps in the microscope."""

from contextlib import suppress

import numpy as np
import pytest
from playwright.sync_api import Page, TimeoutError

from app.features.lessons.bookmark import Phase
from app.features.lessons.session.lesson_actions import Choose, Press
from app.session.replay_player import ReplayPlayer
from app.session.session import Session
from scenes.history import COLUMN
from scenes.smoothness import AROUND, avoiding_rates
from tests.accessibility import accessible
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import drag, visit
from tests.browser import PageAt, screenshot, until, world_position
from tests.tools.lesson_walker import enter

MOUSE = 0.03
"""How exactly a mouse chooses a moment [share of the axis]."""


IN_FREE_SPACE = """() => { const name = getComputedStyle(document.body, '::after'), low = innerHeight - parseFloat(name.bottom);
  const [card, plots] = ['#duet-contact', '[data-duet-holds~=plots]'].map(e => document.querySelector(e).getBoundingClientRect());
  return +name.zIndex < 3 && low - parseFloat(name.height) >= card.bottom && low <= plots.top && low > plots.top - 40; }"""
"""Whether the name of the moment lies below the contact card and above the plots, and panels and slides cover it, not it them."""


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


def pseudo(page: Page, element: str, which: str, what: str) -> str:
    look = "([e, w, k]) => getComputedStyle(document.querySelector(e), w).getPropertyValue(k)"
    return str(page.evaluate(look, [element, which, what]))


def shown_time(session: Session) -> float | None:
    replay = player_of(session).replay
    return None if replay is None else replay.time


def drag_over_plot(page: Page, shares: tuple[float, ...], place: int = 0) -> None:
    """Press at the first share of a plot's width, drag to the others, and let go."""
    box = page.locator(".u-over").nth(place).bounding_box()
    assert box is not None
    drag(page, [(box["x"] + share * box["width"], box["y"] + box["height"] / 2) for share in shares])


def test_after_a_run_the_page_stands_at_its_moment(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1024, 768)
    session, run = enter(page, house(), "lesson=6&step=1&theme=light")
    # The controls are folded, and the page says how large its picture is all the same.
    page.locator("[data-duet-picture]").first.wait_for(state="attached")
    ask(session, lambda _: [run.act(Choose(0)), run.act(Press("run"))])
    until(page, lambda: session.simulation.steps > 0, "the run")
    ask(session, lambda s: s.hurry(3.5))
    until(page, lambda: run.walk.phase is Phase.OBSERVE, "the end of the run")
    until(page, lambda: shown_time(session) is not None, "the moment")
    table = ask(session, lambda s: s.simulation.history.table())
    nearest = table[table[:, COLUMN["d"]].argmin()]
    end = ask(session, lambda s: s.simulation.time)
    assert (
        shown_time(session) == pytest.approx(nearest[COLUMN["t"]] + session.settings.run.dt) and end > nearest[COLUMN["t"]] + 0.5
    )
    until(page, lambda: "smallest d − dₘ, 3.1 s" in pseudo(page, "body", "::after", "content"), "its name over the scene")
    assert "smallest d − dₘ, 3.1 s" in pseudo(page, ".u-over", "::before", "content")
    narrow = page.add_style_tag(content=".u-over{width:200px!important}")
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
    until(page, lambda: float(np.linalg.norm(np.array(world_position(page, wrist)) - before)) > 0.02, "the scene of then")
    until(page, lambda: pseudo(page, "body", "::after", "content") == f'"{shown_time(session):.2f} s"', "the time over the scene")
    line = float(pseudo(page, ".u-over", "::after", "left").removesuffix("px"))
    width = float(page.locator(".u-over").first.bounding_box()["width"])  # pyright: ignore[reportOptionalSubscript]
    assert line / width == pytest.approx((shown_time(session) or 0.0) / end, abs=0.01)
    assert session.simulation.time == end, "the run itself stands where it was"
    # Space begins the run once more, and nothing of the moment is left on the page.
    page.evaluate("document.activeElement?.blur()")
    page.keyboard.press("Space")
    until(page, lambda: shown_time(session) is None and not session.paused, "the run")
    until(page, lambda: pseudo(page, "body", "::after", "content") in ("none", "normal"), "no name over the scene")


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
        assert session.studies.microscope.span is not None
        return session.studies.microscope.span[2]

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
