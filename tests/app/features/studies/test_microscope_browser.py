"""A jump of q̇ on the real page: an edge in the plot over time, and single steps in the microscope."""

import numpy as np
import pytest

from app.features.studies.background_studies import BackgroundStudies
from scenes.history import COLUMN
from scenes.smoothness import AROUND, avoiding_rates
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import visit
from tests.browser import PageAt, screenshot, until

STEEPEST = """() => Math.max(...Object.values(__viserTestpoints.uplots).map(({ chart }) => {
  const [x, ...lines] = chart.data;
  let most = 0;
  for (let i = 1; i < x.length; i++) if (x[i] - x[i - 1] < 0.00501)
    for (const y of lines) if (y.length) most = Math.max(most, Math.abs(y[i] - y[i - 1]) || 0);
  return most;
}))"""
"""Largest change of any line within one time step."""

DOTS = "() => [...document.querySelectorAll('.duet-chart .dots')].map((p) => p.getAttribute('d').split('h0').length - 1)"


@pytest.mark.thorough
def test_a_jump_is_an_edge_and_has_its_steps(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1024, 768)
    session = visit(page, house(), "law=strict_switched&pairs=single&plot=rates&speed=2")
    # From the beginning: the plots show only the last seconds, and a busy machine opens the page slowly.
    ask(session, lambda s: [s.reset(), s.control.hurry(7.0)])
    until(page, lambda: session.simulation.time > 7.0, "the jump")
    # Before the jump has left the plot.
    ask(session, lambda s: s.control.toggle_pause())
    until(page, lambda: session.paused, "the pause")
    table = ask(session, lambda s: s.simulation.history.table())
    jump = float(np.abs(np.diff(avoiding_rates(session.simulation, table)[40:], axis=0)).max())
    assert jump > 0.3
    page.wait_for_function(f"({STEEPEST})() > {0.999 * jump}")
    page.get_by_role("button", name="dt", exact=True).click()
    page.wait_for_function(f"String(({DOTS})()) === '{2 * AROUND + 1},{4 * AROUND + 1}'")
    page.get_by_text(f"{jump:.3g} at 5 ms").wait_for()
    # Other moments by the slider and its keys.
    knob = page.get_by_role("slider", name="moment [s]")

    def looked_at() -> float:
        span = session.parts.of(BackgroundStudies).microscope.span
        assert span is not None
        return span[2]

    found = looked_at()
    until(
        page,
        lambda: float(knob.get_attribute("aria-valuenow") or 0.0) == pytest.approx(found, abs=0.003),
        "its place",
    )
    screenshot(page, "microscope")
    knob.press("ArrowLeft")
    until(page, lambda: looked_at() == pytest.approx(found - 0.005, abs=0.003), "one step back")
    knob.press("Home")
    until(page, lambda: looked_at() == table[0, COLUMN["t"]], "the beginning")
    page.get_by_text(f"over t − {looked_at():.3f} s").wait_for()
