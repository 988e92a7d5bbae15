"""Every control, set by mouse and keyboard in a real browser."""

import numpy as np
import pytest
from playwright.sync_api import Page

from app.page.panels.controls import PICKER, TABS
from app.session.session import Session
from tests.app.conftest import HAND, ask
from tests.app.page.by_hand import control, hand, see_controls, see_plots, set_by_hand
from tests.app.page.helpers import STAGES, bring_into_view
from tests.app.page.shared_page import Shared, SharedPage
from tests.app.page.test_controls import PATIENCE
from tests.browser import lasting, screenshot, settled_box, until, wait_ready, world_position
from tests.tools.page_flaws import flaws

pytestmark = pytest.mark.thorough

SHARED = SharedPage(900, 640, "autopilot=0")
TAB_KEYS = {name: keys for name, _, keys in TABS}


def operate_tab(page: Page, session: Session, name: str) -> None:
    """Open a tab and set each of its controls, in an experiment where it matters."""
    keys = TAB_KEYS[name]
    page.get_by_role("tab", name=name).click()
    for key in keys:
        bring_into_view(session, key)
        see_controls(page, session, keys)
        set_by_hand(page, session, key)
        see_controls(page, session, keys)


def pause(shared: Shared, **settings: object) -> None:
    """Pause the run and change some settings."""
    changes = [*settings.items()]
    ask(shared.session, lambda s: [s.control.halt.set("visitor"), *(s.change(k, v) for k, v in changes)])


def see_handle_on_hand(page: Page, session: Session) -> None:
    until(
        page,
        lambda: np.linalg.norm(world_position(page, HAND) - hand(session)) < 2e-3,
        "the handle on the hand",
    )


def test_controls_of_the_law(shared: Shared) -> None:
    operate_tab(shared.page, shared.session, "Law")


def test_a_slider_moves_by_keys_and_by_the_mouse(shared: Shared) -> None:
    page, session = shared.page, shared.session
    page.get_by_role("tab", name="Law").click()
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


def test_an_impossible_number_does_not_leave_the_page(shared: Shared) -> None:
    page, session = shared.page, shared.session
    page.get_by_role("tab", name="Law").click()
    order, box = session.settings.run.law.order, control(page, "dm").locator("input[type=text]").last
    box.fill("9999")
    box.press("Enter")
    box.fill("nan")
    box.press("Tab")
    control(page, "v").locator("input[type=text]").last.fill("0.5")
    until(page, lambda: session.settings.run.law.nominal_velocity == 0.5, "v")
    assert 0.03 <= session.settings.run.law.critical_distance <= 0.30
    assert session.settings.run.law.order == order


def test_controls_of_the_comparison(shared: Shared) -> None:
    page = shared.page
    operate_tab(page, shared.session, "Compare")
    page.get_by_text("(ghost ").wait_for()
    ring = page.locator("#duet-contact circle.ghost")
    until(page, lambda: ring.get_attribute("visibility") == "visible", "the ghost's ring")
    page.locator(".duet-caption").get_by_text("ghost", exact=True).first.wait_for()
    page.get_by_role("button", name="Measure", exact=True).click()
    page.get_by_text("Largest step of q̇").wait_for(timeout=1000.0 * PATIENCE)
    page.get_by_role("tab", name="Law").click()
    control(page, "dm").locator("input[type=text]").last.fill("200")
    page.get_by_role("tab", name="Compare").click()
    page.get_by_text("as it was", exact=True).wait_for(timeout=1000.0 * PATIENCE)
    page.get_by_text("With dm = 200 mm.").wait_for(timeout=1000.0 * PATIENCE)


def test_controls_of_the_experiment_are_above_the_equation(shared: Shared) -> None:
    page, session = shared.page, shared.session
    pause(shared, gizmo=True, autopilot=True)
    control(page, "rig").wait_for()
    picker = [key for key in PICKER if "scene" not in STAGES.get(key, {})]
    see_controls(page, session, PICKER)

    def in_order() -> bool:
        places = *(control(page, key) for key in picker), page.locator(".duet-eq").first
        tops = [place.evaluate("e => e.getBoundingClientRect().top") for place in places]
        return tops == sorted(tops) and tops[-2] < tops[-1]

    until(page, in_order, "the choice of the experiment above the equation")
    # The experiment is the last one, so that the others are tried in the default experiment.
    for key in reversed(picker):
        set_by_hand(page, session, key)
        see_controls(page, session, PICKER)
        if key == "rig":
            wait_ready(page, "/room")
            see_handle_on_hand(page, session)
            assert session.simulation.room.rig.name == "table"


def test_controls_of_the_arms(shared: Shared) -> None:
    page, session = shared.page, shared.session
    # Choosing a source switches the autopilot on.
    pause(shared, autopilot=True)
    operate_tab(page, session, "Arms")
    # The left arm is the guided one now. The loop may have switched its handle off.
    ask(session, lambda s: s.change("gizmo", True))
    wait_ready(page, HAND)
    assert session.simulation.settings.scene == "hold" and session.simulation.guided.name == "left"
    see_handle_on_hand(page, session)


def test_controls_of_the_robot(shared: Shared) -> None:
    operate_tab(shared.page, shared.session, "Robot")


def test_controls_of_the_view(shared: Shared) -> None:
    page, session = shared.page, shared.session
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
    # The picture is last: shadows take seconds on a machine without a graphics card.
    for key in sorted(set(keys) - {"theme", "profile"}, key=lambda key: (key == "picture", key)):
        set_by_hand(page, session, key)
