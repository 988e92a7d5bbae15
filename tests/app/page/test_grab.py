"""The orange arm under a real mouse and a real finger: taken hold of anywhere, it comes along, and the other arm gives way."""

import numpy as np
from playwright.sync_api import Page

from app.session.session import Session
from scenes.targets import LinkTarget
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import CURSOR, finger, visit
from tests.browser import CAMERA, PageAt, screenshot, settled_view, until, wait_frames, world_position, world_to_px

ARM = "/arms/right/base/j1/j2/j3"
FOREARM, HAND_LINK = f"{ARM}/j4/j5", f"{ARM}/j4/j5/j6"


def missing(session: Session) -> float:
    """How far the point that is pulled is from where it is pulled to [m]."""

    def measure(s: Session) -> float:
        held = s.held
        assert isinstance(held, LinkTarget)
        placement = s.simulation.kinematics.data.oMi[s.simulation.guided.joint(held.joint)]
        return float(np.linalg.norm(placement.act(held.offset) - held.position))

    return ask(session, measure)


def holds(session: Session) -> bool:
    return isinstance(session.held, LinkTarget)


def test_the_arm_is_pulled_with_the_mouse_and_the_other_one_gives_way(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(900, 700)
    # Slow, so that the arm is still where the mouse goes; the autopilot has it at first.
    session = visit(page, house(), "speed=0.25&wmax=0.05&dm=0.3")
    assert not page.evaluate("!!__viserMutable.nodeRefFromName['/gizmo/hand']")
    pull_to_the_other_arm(page, session, FOREARM)
    # From the beginning, by another link.
    ask(session, lambda s: [s.change("speed", 0.25), s.change("wmax", 0.05), s.change("autopilot", True), s.reset()])
    until(page, lambda: page.evaluate("!__viserMutable.nodeRefFromName['/grip/point']?.visible"), "no mark")
    page.mouse.move(450, 120)
    pull_to_the_other_arm(page, session, HAND_LINK)


def pull_to_the_other_arm(page: Page, session: Session, link: str) -> None:
    settled_view(page)
    x, y = world_to_px(page, world_position(page, link))
    page.mouse.move(x - 30, 120)
    until(page, lambda: page.evaluate(CURSOR) == "auto", "no hand over the floor")

    def over_the_arm() -> bool:
        # Slow as it is, it goes on while a busy machine draws.
        nonlocal x, y
        x, y = world_to_px(page, world_position(page, link))
        page.mouse.move(x, y)
        return page.evaluate(CURSOR) == "grab"

    until(page, over_the_arm, "a hand over the arm")
    view = np.array(page.evaluate(CAMERA))
    page.mouse.down()
    page.mouse.move(x + 6, y)
    until(page, lambda: holds(session), "taking hold")
    assert not session.settings.page.autopilot
    ask(session, lambda s: [s.change("speed", 2.0), s.change("wmax", 0.5)])
    still = ask(session, lambda s: s.simulation.positions[s.simulation.avoiding.joints].copy())
    # To the other arm, across the view.
    for step in range(1, 13):
        page.mouse.move(x + 7.0 * step, y)
        wait_frames(page, 2)

    def given_way(s: Session) -> bool:
        return bool(np.abs(s.simulation.positions[s.simulation.avoiding.joints] - still).max() > 0.02)

    until(
        page, lambda: missing(session) < 0.02 and ask(session, given_way), "the point at the mouse, the other arm out of the way"
    )
    until(page, lambda: page.evaluate("!!__viserMutable.nodeRefFromName['/grip/point']?.visible"), "the mark")
    screenshot(page, f"pulled-{link.rsplit('/', 1)[1]}")
    assert np.allclose(page.evaluate(CAMERA), view, atol=1e-6)
    page.mouse.up()
    until(page, lambda: session.held is None, "letting go")
    # As after a pull at the arrows: it stays where it came to, and the autopilot does not come back by itself.
    assert not session.settings.page.autopilot


def test_a_finger_pulls_the_arm_and_beside_it_turns_the_view(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(390, 700, has_touch=True, is_mobile=True)
    session = visit(page, house(), "autopilot=0&speed=2&wmax=0.5")
    view, touch = settled_view(page), finger(page)
    before = world_position(page, HAND_LINK)
    x, y = world_to_px(page, before)
    touch("touchStart", x, y)
    for step in range(1, 9):
        touch("touchMove", x + 6.0 * step, y - 4.0 * step)
        wait_frames(page, 2)
    until(page, lambda: holds(session) and missing(session) < 0.02, "the hand where the finger is")
    until(page, lambda: np.linalg.norm(world_position(page, HAND_LINK) - before) > 0.1, "the hand drawn there")
    assert np.allclose(page.evaluate(CAMERA), view, atol=1e-6)
    touch("touchEnd", 0.0, 0.0)
    until(page, lambda: session.held is None, "letting go")
    touch("touchStart", 200.0, 120.0)
    for step in range(1, 9):
        touch("touchMove", 200.0 + 8.0 * step, 120.0)
        wait_frames(page, 1)
    touch("touchEnd", 0.0, 0.0)
    until(page, lambda: np.abs(np.array(page.evaluate(CAMERA)) - view).max() > 0.05, "another view")
    assert session.held is None
