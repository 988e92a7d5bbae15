"""Every control in a real browser, set as a person sets it."""

import numpy as np
import pytest
from playwright.sync_api import Page

from app.page.panels.controls import PICKER, TABS
from app.session.session import Session
from tests.app.conftest import HAND, OpenHouse, ask
from tests.app.page.by_hand import control, hand, see_controls, see_plots, set_by_hand, visit
from tests.app.page.helpers import STAGES, bring_into_view
from tests.app.page.test_controls import PATIENCE
from tests.browser import PageAt, lasting, screenshot, settled_box, until, wait_ready, world_position
from tests.tools.page_flaws import flaws

TAB_KEYS = {name: keys for name, _, keys in TABS}


def operate_tab(page: Page, session: Session, name: str) -> None:
    """Go to a tab and set every one of its controls, in an experiment in which it matters."""
    keys = TAB_KEYS[name]
    page.get_by_role("tab", name=name).click()
    for key in keys:
        bring_into_view(session, key)
        see_controls(page, session, keys)
        set_by_hand(page, session, key)
        see_controls(page, session, keys)


@pytest.mark.thorough
def test_every_control_by_hand(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(900, 640)
    session = visit(page, house(), "autopilot=0")
    operate_tab(page, session, "Law")
    ask(session, lambda s: s.change("law", "smooth_priority"))
    control(page, "v").wait_for()
    # A slider's thumb by its keys, and by the mouse.
    thumb = control(page, "dm").get_by_role("slider")
    before = session.settings.run.law.critical_distance
    thumb.focus()
    page.keyboard.press("ArrowRight")
    until(
        page, lambda: session.settings.run.law.critical_distance == pytest.approx(before + 0.005), "the thumb"
    )
    track = control(page, "n").locator(".mantine-Slider-root")
    _, _, width, height = settled_box(page, track)
    track.click(position={"x": 0.75 * width, "y": height / 2})
    until(page, lambda: abs(session.settings.run.law.order - 15.25) < 1.0, "the track")
    # A number that is impossible stays on the page.
    settings, box = session.settings, control(page, "dm").locator("input[type=text]").last
    box.fill("9999")
    box.press("Enter")
    box.fill("nan")
    box.press("Tab")
    control(page, "v").locator("input[type=text]").last.fill("0.5")
    until(page, lambda: session.settings.run.law.nominal_velocity == 0.5, "v")
    assert 0.03 <= session.settings.run.law.critical_distance <= 0.30
    assert settings.run.law.order == session.settings.run.law.order

    # What is compared with it.
    operate_tab(page, session, "Compare")
    page.get_by_text("(ghost ").wait_for()
    until(
        page,
        lambda: page.locator("#duet-contact circle.ghost").get_attribute("visibility") == "visible",
        "the ghost's ring",
    )
    page.locator(".duet-caption").get_by_text("ghost", exact=True).first.wait_for()
    page.get_by_role("button", name="Measure", exact=True).click()
    page.get_by_text("Largest step of q̇").wait_for(timeout=1000.0 * PATIENCE)
    page.get_by_role("tab", name="Law").click()
    control(page, "dm").locator("input[type=text]").last.fill("200")
    page.get_by_role("tab", name="Compare").click()
    page.get_by_text("as it was", exact=True).wait_for(timeout=1000.0 * PATIENCE)
    page.get_by_text("With dm = 200 mm.").wait_for(timeout=1000.0 * PATIENCE)
    usual = {"ghost": "off", "whatif": False, "gizmo": True, "autopilot": True}
    ask(
        session, lambda s: [*(s.change(key, value) for key, value in usual.items()), s.control.toggle_pause()]
    )
    operate_the_others(page, session)


def operate_the_others(page: Page, session: Session) -> None:
    """Set what stands on no tab, and all of two more tabs; the run is paused."""
    control(page, "rig").wait_for()
    picker = [key for key in PICKER if "scene" not in STAGES.get(key, {})]
    see_controls(page, session, PICKER)

    def in_order() -> bool:
        places = *(control(page, key) for key in picker), page.locator(".duet-eq").first
        tops = [place.evaluate("e => e.getBoundingClientRect().top") for place in places]
        return tops == sorted(tops) and tops[-2] < tops[-1]

    until(page, in_order, "the choice of the experiment above the equation")
    # The experiment last, so that the others are tried in the usual one.
    for key in reversed(picker):
        set_by_hand(page, session, key)
        see_controls(page, session, PICKER)
        if key == "rig":
            wait_ready(page, "/room")
            until(
                page,
                lambda: np.linalg.norm(world_position(page, HAND) - hand(session)) < 2e-3,
                "the handle at the table",
            )
            assert session.simulation.room.rig.name == "table"
    operate_tab(page, session, "Arms")
    # The left arm is yours now, and has the handle, which was switched off among the others.
    ask(session, lambda s: s.change("gizmo", True))
    wait_ready(page, HAND)
    assert session.simulation.settings.scene == "hold" and session.simulation.guided.name == "left"
    until(
        page,
        lambda: np.linalg.norm(world_position(page, HAND) - hand(session)) < 2e-3,
        "the handle on the left hand",
    )
    ask(session, lambda s: s.control.toggle_pause())
    keys = TAB_KEYS["View"]
    page.get_by_role("tab", name="View").click()
    see_controls(page, session, keys)
    for key in ("theme", "profile"):
        set_by_hand(page, session, key)
    page.wait_for_function("document.documentElement.dataset.mantineColorScheme === 'dark'")
    page.wait_for_function(
        "getComputedStyle(document.documentElement).getPropertyValue('--duet-k').trim() === '1.3'"
    )
    see_plots(page, ("distance d [m]", "error e² [m²]"))

    assert lasting(page, lambda: flaws(page)) == []
    screenshot(page, "page-900-dark-projector")
    # Last, as shadows take a machine without a graphics card seconds.
    for key in sorted(set(keys) - {"theme", "profile"}, key=lambda key: (key == "picture", key)):
        set_by_hand(page, session, key)
