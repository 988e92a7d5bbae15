"""The arm under a real mouse and a real finger: taken hold of anywhere, by the arrows of the hand or the arc of the elbow, it comes along,
and the other arm gives way."""

import numpy as np
import pinocchio as pin
import pytest
from playwright.sync_api import Page

from app.page.handles.transform_handles import AUTOPILOT_SIZE, swivel_frame
from app.session.session import Session
from scenes.history import COLUMN
from scenes.settings import RunSettings
from scenes.targets import HandTarget, LinkTarget
from tests.app.conftest import ELBOW, HAND, OpenHouse, ask
from tests.app.page.by_hand import (
    CURSOR,
    WRIST,
    control,
    drag_through,
    finger,
    grab,
    hand,
    hands_of,
    run_on,
    visit,
)
from tests.browser import (
    CAMERA,
    PageAt,
    point_at,
    screenshot,
    settled_view,
    take_hold,
    until,
    wait_frames,
    world_position,
    world_to_px,
)

# Length of the hand's arrows and radius of the elbow's arc [m]; where an arrow is taken: beyond the ends of the arcs that turn the
# hand, which lie on it at 0.65.
GIZMO, ARC, GRIP = 0.22, 0.26 * 0.65, 0.85


def best_arrow(session: Session, toward: np.ndarray) -> tuple[np.ndarray, float]:
    """The hand's arrow that lies most along a direction, and whether it points there (1) or away (−1)."""
    rotation = ask(session, lambda s: s.simulation.kinematics.hand_pose(s.simulation.guided).rotation.copy())
    along = toward @ rotation
    i = int(np.abs(along).argmax())
    return rotation[:, i], float(np.sign(along[i]))


def test_a_mouse_takes_over_drags_the_hand_swivels_the_elbow_brings_arrows_and_pulls_links(
    house: OpenHouse, page_at: PageAt
) -> None:
    page = page_at(900, 800)
    # Slow, so that the arrow is still where the mouse goes.
    session = visit(page, house(), "gizmo=1&speed=0.25&wmax=0.05")
    run_on(page, session, 0.1)
    assert session.settings.page.autopilot and session.held is None
    page.get_by_text("The autopilot moves the orange arm").wait_for()
    arrow, sign = best_arrow(session, np.array([0.0, 1.0, 0.0]))
    before = session.simulation.time
    take_hold(
        page, lambda: hand(session) + arrow * GRIP * AUTOPILOT_SIZE * GIZMO, lambda: session.held is not None
    )
    grip = hand(session) + arrow * GRIP * AUTOPILOT_SIZE * GIZMO
    for way in np.linspace(0.02, 0.10, 4):
        point_at(page, grip + arrow * sign * way)
    page.mouse.up()
    until(page, lambda: session.held is None and not session.settings.page.autopilot, "letting go")
    assert session.simulation.time > before
    page.get_by_text("Pull the orange arm anywhere.").wait_for()
    # The control knows it, too.
    page.get_by_role("tab", name="Arms").click()
    box = control(page, "autopilot").locator("input[type=checkbox]")
    until(page, lambda: not box.is_checked(), "the control without its tick")

    # From the beginning, the hand at its usual speed.
    ask(session, lambda s: [s.change("speed", 2.0), s.change("wmax", RunSettings().hand_speed), s.reset()])
    page.mouse.move(40, 420)
    start, other = ask(session, hands_of)
    still = ask(session, lambda s: s.simulation.positions[s.simulation.avoiding.joints].copy())
    arrow, sign = best_arrow(session, (other - start) / np.linalg.norm(other - start))
    grip = start + arrow * GRIP * GIZMO
    drag_through(page, session, [grip + arrow * sign * way for way in np.linspace(0.0, 0.45, 24)])
    goal = start + arrow * sign * 0.45

    def given_way(s: Session) -> bool:
        return bool(np.abs(s.simulation.positions[s.simulation.avoiding.joints] - still).max() > 0.03)

    until(
        page,
        lambda: np.linalg.norm(hand(session) - goal) < 0.02 and ask(session, given_way),
        "the hand where the mouse is",
    )
    # Meanwhile the handle is where the mouse is, not where the hand is.
    until(
        page,
        lambda: np.linalg.norm(world_position(page, HAND) - goal) < 5e-3,
        "the handle where the mouse is",
    )
    page.mouse.up()
    # Released: the handle jumps back to the hand, which stays where it came to.
    until(page, lambda: session.held is None, "release")
    run_on(page, session, 0.3)
    assert np.linalg.norm(hand(session) - goal) < 0.03
    until(
        page,
        lambda: np.linalg.norm(world_position(page, HAND) - hand(session)) < 2e-3,
        "the handle on the hand",
    )

    def wrist_off() -> float:
        drawn = world_position(page, f"/arms/right{WRIST}")
        return float(
            np.linalg.norm(drawn - ask(session, lambda s: s.simulation.kinematics.joint_point(14).copy()))
        )

    until(page, lambda: wrist_off() < 2e-3, "the arm drawn where it is")
    table = ask(session, lambda s: s.simulation.history.table())
    limit = session.settings.run.law.critical_distance
    assert table[:, COLUMN["e2"]].max() > 0.01**2
    assert table[:, COLUMN["w"]].max() <= session.settings.run.hand_speed + 1e-9
    assert limit - 1e-4 <= table[:, COLUMN["d"]].min() < limit + 0.1
    # The columns of a second arm that keeps clear are empty, as only one does.
    assert (
        np.isfinite(table[:, : COLUMN["e2_b"]]).all()
        and np.isfinite(session.simulation.history.positions(table)).all()
    )

    # From the beginning, the elbow by its arc.
    ask(session, lambda s: s.reset())

    def state(s: Session) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return *swivel_frame(s.hand), s.simulation.kinematics.joint_point(s.simulation.guided.elbow).copy()

    (frame, foot, elbow), place = ask(session, state), hand(session)
    out, across = (frame[:, 1] + frame[:, 2]) / np.sqrt(2.0), (frame[:, 2] - frame[:, 1]) / np.sqrt(2.0)
    ways = [elbow + ARC * (np.cos(a) * out + np.sin(a) * across) for a in np.linspace(0.0, 0.6, 13)]
    drag_through(page, session, ways)
    there = foot + pin.exp3(frame[:, 0] * 0.6) @ (elbow - foot)

    def at_the_mouse() -> bool:
        held = session.held
        assert isinstance(held, HandTarget) and held.elbow is not None
        *_, now = ask(session, state)
        return bool(np.linalg.norm(held.elbow - there) < 0.03 and np.linalg.norm(now - held.elbow) < 0.01)

    until(page, at_the_mouse, "the elbow where the mouse is")
    page.mouse.up()
    until(page, lambda: session.held is None, "letting go of the elbow")
    *_, now = ask(session, state)
    assert np.linalg.norm(now - there) < 0.05 < np.linalg.norm(now - elbow)
    assert np.linalg.norm(hand(session) - place) < 5e-3
    until(
        page,
        lambda: np.linalg.norm(world_position(page, ELBOW) - ask(session, state)[2]) < 5e-3,
        "the handle on the elbow",
    )

    ask(session, lambda s: [s.change("gizmo", False), s.change("contact", False), s.reset()])
    see_arrows_under_a_mouse_that_rests(page, session)
    see_links_pulled(page, session)


def see_arrows_under_a_mouse_that_rests(page: Page, session: Session) -> None:
    """A mouse that rests on the hand brings its arrows; the arm stands still."""
    settled_view(page)
    there = f"__viserMutable.nodeRefFromName['{HAND}']"
    # Where an arrow will come out of the hand towards the camera.
    rotation = ask(session, lambda s: s.simulation.kinematics.hand_pose(s.simulation.guided).rotation.copy())
    x, y = world_to_px(page, hand(session) + 0.04 * rotation[:, 0])

    def arrows() -> bool:
        # Again, as the hand may not have been there yet.
        page.mouse.move(x, y + 3)
        page.mouse.move(x, y)
        return page.evaluate(f"!!{there}")

    until(page, arrows, "the arrows of the hand")
    assert (
        not page.evaluate(f"!!__viserMutable.nodeRefFromName['{ELBOW}']") and not session.settings.page.gizmo
    )
    screenshot(page, "hand-hovered")
    # A press where the mouse rests takes the hand itself.
    page.mouse.down()
    page.mouse.move(x + 12, y)
    until(page, lambda: isinstance(session.held, LinkTarget), "the hand held")
    until(page, lambda: page.evaluate(f"!{there}"), "a pull without arrows")
    page.mouse.up()
    until(page, lambda: session.held is None, "letting go")

    def arrows_again() -> bool:
        page.mouse.move(*world_to_px(page, hand(session) + 0.04 * rotation[:, 0]))
        return page.evaluate(f"!!{there}")

    until(page, arrows_again, "the arrows of the hand again")
    # On an arrow they stay, and it can be taken.
    arrow, sign = best_arrow(session, np.array([0.0, -1.0, 0.0]))
    point_at(page, hand(session) + arrow * GRIP * GIZMO)
    take_hold(
        page, lambda: hand(session) + arrow * GRIP * GIZMO, lambda: isinstance(session.held, HandTarget)
    )
    point_at(page, hand(session) + arrow * (GRIP * GIZMO + 0.04 * sign))
    page.mouse.up()
    until(page, lambda: session.held is None, "letting go of the arrow")
    page.mouse.move(40, 420)
    until(page, lambda: page.evaluate(f"!{there}"), "no arrows")


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


def see_links_pulled(page: Page, session: Session) -> None:
    """A link of the arm that the autopilot has at first is pulled with the mouse, and the other arm gives way."""
    # Slow, so that the arm is still where the mouse goes.
    slow = {"speed": 0.25, "wmax": 0.05, "dm": 0.3, "contact": True, "autopilot": True}
    for link in (FOREARM, HAND_LINK):
        ask(session, lambda s: [*(s.change(key, value) for key, value in slow.items()), s.reset()])
        until(
            page, lambda: page.evaluate("!__viserMutable.nodeRefFromName['/grip/point']?.visible"), "no mark"
        )
        assert not page.evaluate("!!__viserMutable.nodeRefFromName['/gizmo/hand']")
        page.mouse.move(450, 120)
        pull_to_the_other_arm(page, session, link)


def pull_to_the_other_arm(page: Page, session: Session, link: str) -> None:
    settled_view(page)
    page.mouse.move(world_to_px(page, world_position(page, link))[0] - 30, 120)
    until(page, lambda: page.evaluate(CURSOR) == "auto", "no hand over the floor")
    x, y = grab(page, link, lambda: holds(session))
    view = np.array(page.evaluate(CAMERA))
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
        page,
        lambda: missing(session) < 0.02 and ask(session, given_way),
        "the point at the mouse, the other arm out of the way",
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
    until(
        page, lambda: np.linalg.norm(world_position(page, HAND_LINK) - before) > 0.1, "the hand drawn there"
    )
    assert np.allclose(page.evaluate(CAMERA), view, atol=1e-6)
    touch("touchEnd", 0.0, 0.0)
    until(page, lambda: session.held is None, "letting go")
    # Below the contact card, whose symbols take a touch, and above the arms.
    touch("touchStart", 360.0, 185.0)
    for step in range(1, 9):
        touch("touchMove", 360.0 - 8.0 * step, 185.0)
        wait_frames(page, 1)
    touch("touchEnd", 0.0, 0.0)
    until(page, lambda: np.abs(np.array(page.evaluate(CAMERA)) - view).max() > 0.05, "another view")
    assert session.held is None


@pytest.mark.thorough
def test_a_reset_in_the_middle_of_a_drag_at_an_arrow_ends_the_pull_until_the_button_is_released(
    house: OpenHouse, page_at: PageAt
) -> None:
    page = page_at(900, 800)
    session = visit(page, house(), "gizmo=1&autopilot=0&speed=2")
    start, other = ask(session, hands_of)
    arrow, sign = best_arrow(session, (other - start) / np.linalg.norm(other - start))
    grip = start + arrow * GRIP * GIZMO
    places = [grip + arrow * sign * way for way in np.linspace(0.0, 0.3, 9)]

    def moved() -> float:
        return float(np.linalg.norm(hand(session) - start))

    for reset in (lambda: page.keyboard.press("r"), lambda: ask(session, lambda s: s.reset())):
        drag_through(page, session, places[:5])
        until(page, lambda: moved() > 0.05, "the hand on its way")
        reset()
        until(page, lambda: session.held is None and moved() < 1e-6, "the run from its beginning")
        # The button is still down: what the mouse does now moves nothing.
        for place in places[5:]:
            point_at(page, place)
        page.keyboard.press("Space")
        until(page, lambda: session.paused, "a key that was pressed after the moves")
        assert session.held is None and moved() < 1e-6
        page.keyboard.press("Space")
        page.mouse.up()
        until(page, lambda: not session.paused, "the run going on")
        run_on(page, session, 0.1)
        until(
            page, lambda: np.linalg.norm(world_position(page, HAND) - start) < 2e-3, "the handle on the hand"
        )
        assert session.held is None and moved() < 1e-6
    # A press takes it again.
    drag_through(page, session, places[:3])
    until(page, lambda: moved() > 0.03, "the hand on its way again")
    page.mouse.up()
    until(page, lambda: session.held is None, "letting go")
