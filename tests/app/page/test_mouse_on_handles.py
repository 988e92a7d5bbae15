"""An arm dragged by a real mouse or finger, on a link or a handle, follows; the other arm avoids it."""

import numpy as np
import pinocchio as pin
import pytest
from playwright.sync_api import Page

from app.page.handles.transform_handles import AUTOPILOT_SIZE, swivel_frame
from app.session.session import Session
from scenes.history import COLUMN
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
from tests.app.page.shared_page import Shared, SharedPage
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

SHARED = SharedPage(900, 800, "gizmo=1&autopilot=0&speed=2")

# Length of the hand's arrows and radius of the elbow's arc [m]; share of an arrow at which it is taken:
# beyond the ends of the arcs that turn the hand, which are at 0.65.
GIZMO, ARC, GRIP = 0.22, 0.26 * 0.65, 0.85


def best_arrow(session: Session, toward: np.ndarray) -> tuple[np.ndarray, float]:
    """The hand's arrow closest to a direction, and its sign: 1 towards it, −1 away from it."""
    rotation = ask(session, lambda s: s.simulation.kinematics.hand_pose(s.simulation.guided).rotation.copy())
    along = toward @ rotation
    i = int(np.abs(along).argmax())
    return rotation[:, i], float(np.sign(along[i]))


def test_a_mouse_takes_the_hand_over_from_the_autopilot(shared: Shared) -> None:
    page, session = shared.page, shared.session
    # Slow, so that the arrow is still at the mouse's goal.
    slow = {"speed": 0.25, "wmax": 0.05, "autopilot": True}
    ask(session, lambda s: [*(s.change(key, value) for key, value in slow.items()), s.reset()])
    run_on(page, session, 0.1)
    assert session.settings.page.autopilot and session.held is None
    page.get_by_text("The autopilot moves the orange arm").wait_for()
    arrow, sign = best_arrow(session, np.array([0.0, 1.0, 0.0]))
    before = session.simulation.time

    def grip() -> np.ndarray:
        return hand(session) + arrow * GRIP * AUTOPILOT_SIZE * GIZMO

    take_hold(page, grip, lambda: session.held is not None)
    taken = grip()
    for way in np.linspace(0.02, 0.10, 4):
        point_at(page, taken + arrow * sign * way)
    page.mouse.up()
    until(page, lambda: session.held is None and not session.settings.page.autopilot, "letting go")
    assert session.simulation.time > before
    page.get_by_text("Pull the orange arm anywhere.").wait_for()
    # The control shows it, too.
    page.get_by_role("tab", name="Arms").click()
    box = control(page, "autopilot").locator("input[type=checkbox]")
    until(page, lambda: not box.is_checked(), "the control without its tick")


def toward_the_other_hand(session: Session) -> tuple[np.ndarray, np.ndarray, float]:
    """Guided hand's place (3,) [m], its arrow closest to the direction of the other hand, and the sign."""
    start, other = ask(session, hands_of)
    return start, *best_arrow(session, (other - start) / np.linalg.norm(other - start))


def handle_off(page: Page, handle: str, place: np.ndarray) -> float:
    """Distance of a drawn handle from a place [m]."""
    return float(np.linalg.norm(world_position(page, handle) - place))


def wrist_off(page: Page, session: Session) -> float:
    """Distance of the drawn right wrist from its true place [m]."""
    wrist = ask(session, lambda s: s.simulation.kinematics.joint_point(14).copy())
    return handle_off(page, f"/arms/right{WRIST}", wrist)


def see_limits_kept(session: Session) -> None:
    """Check that the other arm avoided, and that distance and hand speed kept their limits."""
    table = ask(session, lambda s: s.simulation.history.table())
    limit = session.settings.run.law.critical_distance
    assert table[:, COLUMN["e2"]].max() > 0.01**2
    assert table[:, COLUMN["w"]].max() <= session.settings.run.hand_speed + 1e-9
    assert limit - 1e-4 <= table[:, COLUMN["d"]].min() < limit + 0.1
    # The columns of a second avoiding arm are empty: only one arm avoids.
    assert np.isfinite(table[:, : COLUMN["e2_b"]]).all()
    assert np.isfinite(session.simulation.history.positions(table)).all()


def test_a_hand_dragged_at_its_arrow_follows_and_the_other_arm_avoids_it(shared: Shared) -> None:
    page, session = shared.page, shared.session
    page.mouse.move(40, 420)
    start, arrow, sign = toward_the_other_hand(session)
    still = ask(session, lambda s: s.simulation.positions[s.simulation.avoiding.joints].copy())
    grip, goal = start + arrow * GRIP * GIZMO, start + arrow * sign * 0.45

    def has_given_way(s: Session) -> bool:
        return bool(np.abs(s.simulation.positions[s.simulation.avoiding.joints] - still).max() > 0.03)

    drag_through(page, session, [grip + arrow * sign * way for way in np.linspace(0.0, 0.45, 24)])
    until(page, lambda: np.linalg.norm(hand(session) - goal) < 0.02, "the hand where the mouse is")
    until(page, lambda: ask(session, has_given_way), "the other arm out of the way")
    # During the drag the handle is at the mouse, not at the hand.
    until(page, lambda: handle_off(page, HAND, goal) < 5e-3, "the handle where the mouse is")
    page.mouse.up()
    # After the release the handle jumps to the hand, which stays.
    until(page, lambda: session.held is None, "release")
    run_on(page, session, 0.3)
    assert np.linalg.norm(hand(session) - goal) < 0.03
    until(page, lambda: handle_off(page, HAND, hand(session)) < 2e-3, "the handle on the hand")
    until(page, lambda: wrist_off(page, session) < 2e-3, "the arm drawn where it is")
    see_limits_kept(session)


def test_an_elbow_dragged_at_its_arc_swivels_and_the_hand_stays(shared: Shared) -> None:
    page, session = shared.page, shared.session

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
    until(page, lambda: handle_off(page, ELBOW, ask(session, state)[2]) < 5e-3, "the handle on the elbow")


def test_a_mouse_that_rests_on_the_hand_shows_its_arrows(shared: Shared) -> None:
    page, session = shared.page, shared.session
    ask(session, lambda s: [s.change("gizmo", False), s.change("contact", False), s.reset()])
    settled_view(page)
    there = f"__viserMutable.nodeRefFromName['{HAND}']"
    # The place where an arrow will point out of the hand towards the camera.
    rotation = ask(session, lambda s: s.simulation.kinematics.hand_pose(s.simulation.guided).rotation.copy())
    x, y = world_to_px(page, hand(session) + 0.04 * rotation[:, 0])

    def arrows() -> bool:
        # Repeated, as the hand may not have been there yet.
        page.mouse.move(x, y + 3)
        page.mouse.move(x, y)
        return page.evaluate(f"!!{there}")

    until(page, arrows, "the arrows of the hand")
    assert (
        not page.evaluate(f"!!__viserMutable.nodeRefFromName['{ELBOW}']") and not session.settings.page.gizmo
    )
    screenshot(page, "hand-hovered")
    # A press at the resting mouse takes the hand itself.
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
    # With the mouse on an arrow the arrows stay, and it can be dragged.
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
    """Distance of the dragged point from its target [m]."""

    def measure(s: Session) -> float:
        held = s.held
        assert isinstance(held, LinkTarget)
        placement = s.simulation.kinematics.data.oMi[s.simulation.guided.joint(held.joint)]
        return float(np.linalg.norm(placement.act(held.offset) - held.position))

    return ask(session, measure)


def holds(session: Session) -> bool:
    return isinstance(session.held, LinkTarget)


@pytest.mark.parametrize("link", [FOREARM, HAND_LINK], ids=["forearm", "hand"])
def test_a_link_is_dragged_to_the_other_arm(shared: Shared, link: str) -> None:
    """The autopilot moves this arm at first; the other arm avoids it."""
    page, session = shared.page, shared.session
    # Slow, so that the arm is still at the mouse's goal.
    slow = {"gizmo": False, "speed": 0.25, "wmax": 0.05, "dm": 0.3, "contact": True, "autopilot": True}
    ask(session, lambda s: [*(s.change(key, value) for key, value in slow.items()), s.reset()])
    until(page, lambda: page.evaluate("!__viserMutable.nodeRefFromName['/grip/point']?.visible"), "no mark")
    until(page, lambda: not page.evaluate("!!__viserMutable.nodeRefFromName['/gizmo/hand']"), "no arrows")
    page.mouse.move(450, 120)
    settled_view(page)
    page.mouse.move(world_to_px(page, world_position(page, link))[0] - 30, 120)
    until(page, lambda: page.evaluate(CURSOR) == "auto", "no hand over the floor")
    x, y = grab(page, link, lambda: holds(session))
    view = np.array(page.evaluate(CAMERA))
    assert not session.settings.page.autopilot
    ask(session, lambda s: [s.change("speed", 2.0), s.change("wmax", 0.5)])
    still = ask(session, lambda s: s.simulation.positions[s.simulation.avoiding.joints].copy())
    # Towards the other arm, across the view.
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
    # As after a drag at the arrows: the arm stays, and the autopilot stays off.
    assert not session.settings.page.autopilot


def test_a_finger_drags_the_arm_and_next_to_it_turns_the_view(house: OpenHouse, page_at: PageAt) -> None:
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
    # Below the contact card, where symbols react to a touch, and above the arms.
    touch("touchStart", 360.0, 185.0)
    for step in range(1, 9):
        touch("touchMove", 360.0 - 8.0 * step, 185.0)
        wait_frames(page, 1)
    touch("touchEnd", 0.0, 0.0)
    until(page, lambda: np.abs(np.array(page.evaluate(CAMERA)) - view).max() > 0.05, "another view")
    assert session.held is None


@pytest.mark.thorough
def test_a_reset_during_a_drag_at_an_arrow_ends_the_drag(
    shared: Shared,
) -> None:
    page, session = shared.page, shared.session
    start, arrow, sign = toward_the_other_hand(session)
    grip = start + arrow * GRIP * GIZMO
    places = [grip + arrow * sign * way for way in np.linspace(0.0, 0.3, 9)]

    def moved() -> float:
        return float(np.linalg.norm(hand(session) - start))

    for reset in (lambda: page.keyboard.press("r"), lambda: ask(session, lambda s: s.reset())):
        drag_through(page, session, places[:5])
        until(page, lambda: moved() > 0.05, "the hand on its way")
        reset()
        until(page, lambda: session.held is None and moved() < 1e-6, "the run from its beginning")
        # The button is still down: the mouse moves nothing now.
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
    # A new press takes hold again.
    drag_through(page, session, places[:3])
    until(page, lambda: moved() > 0.03, "the hand on its way again")
    page.mouse.up()
    until(page, lambda: session.held is None, "letting go")
