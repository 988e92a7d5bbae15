"""The first sight of a page, in windows of several sizes: nothing is cut off and nothing covers the arms."""

import pytest

from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import CUT, FREE, see_free, see_plots, visit
from tests.browser import PageAt, close_software_note, screenshot, until, wait_frames

LINKS = [f"/arms/{side}/base" + "".join(f"/j{i}" for i in range(1, n + 1)) for side in ("left", "right") for n in range(8)]


@pytest.mark.parametrize(
    ("width", "height", "rigs"),
    [(1440, 900, ("torso", "table")), (1024, 768, ("table", "torso")), (390, 844, ("torso", "table"))],
)
def test_first_sight(house: OpenHouse, page_at: PageAt, width: int, height: int, rigs: tuple[str, ...]) -> None:
    """Of one rig when the page opens, and of the other when it is chosen."""
    page = page_at(width, height)
    session = visit(page, house(), f"rig={rigs[0]}&speed=2")
    if width > 576:
        see_plots(page, ("distance", "error"))
    close_software_note(page)
    for rig in rigs:
        ask(session, lambda s, rig=rig: s.change("rig", rig))
        see_free(page, LINKS, rig)
        # On its way back the hand moves away from the other arm: the numbers are longest then.
        until(page, lambda: session.simulation.time > 3.0 and session.simulation.sample().law_approach < -0.02, "a retreat", 60.0)
        ask(session, lambda s: s.toggle_pause())
        page.get_by_text("paused", exact=True).wait_for()
        faults: dict[str, list[str]] = {}
        for theme in ("light", "dark"):
            ask(session, lambda s, theme=theme: s.change("theme", theme))
            page.wait_for_function("theme => document.documentElement.dataset.mantineColorScheme === theme", arg=theme)
            wait_frames(page, 6)
            screenshot(page, f"page-{width}-{rig}-{theme}")
            faults[theme] = page.evaluate(CUT)
        assert faults == {"light": [], "dark": []}, rig
        assert page.evaluate(FREE, LINKS) == [], rig
        ask(session, lambda s: s.toggle_pause())
