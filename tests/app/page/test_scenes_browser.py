"""Every scene in a real browser; ball and figure follow a real mouse (the hand: `test_mouse_on_handles`)."""

import numpy as np
import pytest
from playwright.sync_api import Page

from app.session.session import Session
from scenes.ball import BALL_RADIUS
from scenes.experiments import EXPERIMENTS
from scenes.history import COLUMN
from scenes.robots.drawing import joint_frames
from scenes.settings import RunSettings, specs
from scenes.targets import BallTarget
from tests.app.conftest import ELBOW, HAND, ask
from tests.app.page.by_hand import LATE_UPDATE, drag_through, hand
from tests.app.page.shared_page import Shared, SharedPage
from tests.browser import screenshot, settled_view, until, wait_frames, world_position, world_to_px

pytestmark = pytest.mark.thorough

SHARED = SharedPage(960, 720, "gizmo=1&autopilot=0&speed=2", expect=(LATE_UPDATE,))
SCENES = tuple(EXPERIMENTS)
KEYS = dict(zip(SCENES, "123456", strict=True))
NAMES = specs(RunSettings)["scene"].options()
BALL_ARROW = 0.2
"""Length of the ball's arrows [m]."""


def enter(page: Page, session: Session, scene: str) -> None:
    """Open a scene by its key, and wait until it is drawn."""
    page.keyboard.press(KEYS[scene])
    until(page, lambda: session.simulation.settings.scene == scene, scene)
    arms = ["/arms/left/base", "/arms/arm/base"][:: -1 if scene in ("solo", "ball") else 1]
    page.wait_for_function(
        "([a, b]) => __viserMutable.nodeRefFromName[a] && !__viserMutable.nodeRefFromName[b]", arg=arms
    )
    page.get_by_text(NAMES[scene], exact=True).first.wait_for()
    wait_frames(page, 6)


def pull_pixels(page: Page, start: tuple[float, float], way: tuple[float, float]) -> None:
    """Drag from a point of the window [px] in eight steps, without a release."""
    x, y = start
    for place in ((x - 2, y), (x, y)):
        page.mouse.move(*place)
        wait_frames(page, 3)
    page.mouse.down()
    for step in range(1, 9):
        page.mouse.move(x + way[0] * step / 8, y + way[1] * step / 8)
        wait_frames(page, 2)


def pull_the_figure(page: Page, session: Session) -> None:
    """Drag the imitated figure at an elbow; repeated if the elbow has moved away from the mouse."""
    for attempt in range(1, 6):
        pull_pixels(
            page,
            world_to_px(page, world_position(page, "/person/body/left_upper_arm/left_forearm")),
            (32, -64),
        )
        try:
            until(page, lambda: session.settings.page.source == "figure", "the figure as the person", 20.0)
            return
        except AssertionError:
            page.mouse.up()
            if attempt == 5:
                raise


def let_go(page: Page, session: Session, what: str) -> None:
    """Take a screenshot of the drag, and release the mouse."""
    screenshot(page, f"scene-{what}-dragged")
    page.mouse.up()
    until(page, lambda: session.held is None, f"letting go of the {what}")


def are_there(page: Page, *nodes: str) -> bool:
    return bool(page.evaluate("names => names.some(name => __viserMutable.nodeRefFromName[name])", nodes))


def ball(session: Session) -> np.ndarray:
    return ask(session, lambda s: s.simulation.positions[s.simulation.room.ball].copy())


def see_handle_on_hand(page: Page, session: Session) -> None:
    def off() -> float:
        return float(np.linalg.norm(world_position(page, HAND) - hand(session)))

    until(page, lambda: are_there(page, HAND) and off() < 2e-3, "the handle on the hand")


def test_the_ball_follows_its_arrow(shared: Shared) -> None:
    page, session = shared.page, shared.session
    enter(page, session, "ball")
    until(page, lambda: not are_there(page, HAND, ELBOW), "no handles of a hand")
    start, up = ball(session), np.array([0.0, 0.0, 1.0])
    drag_through(page, session, [start + up * (0.8 * BALL_ARROW + way) for way in np.linspace(0.0, 0.06, 8)])
    assert isinstance(session.held, BallTarget)

    def missing() -> float:
        return float(np.linalg.norm(ball(session) - start - 0.06 * up))

    until(page, lambda: missing() < 0.015, "the ball where its arrow is")
    until(
        page,
        lambda: np.linalg.norm(world_position(page, "/ball") - ball(session)) < 5e-3,
        "the ball drawn where it is",
    )
    let_go(page, session, "arrow")


def test_the_ball_itself_is_dragged(shared: Shared) -> None:
    """Drag to the left, across the view, from a place without an arrow."""
    page, session = shared.page, shared.session
    enter(page, session, "ball")
    settled_view(page)
    before = ball(session)
    x, y = world_to_px(page, before)
    x1, _ = world_to_px(page, before + np.array([0.0, BALL_RADIUS, 0.0]))
    radius = abs(x1 - x)
    pull_pixels(page, (x - 0.6 * radius, y + 0.45 * radius), (-1.2 * radius, 0.0))
    until(page, lambda: isinstance(session.held, BallTarget), "taking the ball itself")
    until(page, lambda: world_to_px(page, ball(session))[0] < x - radius, "the ball where it was pulled")
    assert np.linalg.norm(ball(session) - before) > 0.05
    let_go(page, session, "ball")


def test_the_handle_is_on_the_hand_in_experiments_with_a_handle(shared: Shared) -> None:
    for scene in ("solo", "master_slave"):
        enter(shared.page, shared.session, scene)
        see_handle_on_hand(shared.page, shared.session)


def test_robots_follow_a_dragged_figure(shared: Shared) -> None:
    page, session = shared.page, shared.session
    enter(page, session, "imitation")
    q = ask(session, lambda s: s.simulation.positions.copy())

    def moved() -> float:
        return float(np.abs(ask(session, lambda s: s.simulation.positions.copy()) - q).max())

    pull_the_figure(page, session)
    until(page, lambda: moved() > 0.15, "robots that follow")
    screenshot(page, "scene-figure-dragged")
    page.mouse.up()

    enter(page, session, "hold")
    until(
        page,
        lambda: are_there(page, HAND) and not are_there(page, "/person/body"),
        "the hand's handle, and no figure",
    )


def test_two_makes_are_drawn_at_their_places_while_one_avoids(shared: Shared) -> None:
    page, session = shared.page, shared.session
    makes = {"robot": "ur5_panda", "rig": "table", "autopilot": True}
    ask(session, lambda s: [s.change(key, value) for key, value in makes.items()])
    until(page, lambda: session.simulation.sample().activation > 0.5, "a meeting")
    ask(session, lambda s: s.change("speed", 0.25))
    run = session.simulation
    for arm, made, count in zip(run.room.arms, run.room.robots, (6, 7), strict=True):
        path = "".join(f"/{joint.name}" for joint in joint_frames(made.key))
        assert arm.joints.stop - arm.joints.start == path.count("/") == count

        def off(path: str = path, joint: int = arm.joints.stop, name: str = arm.name) -> float:
            drawn = world_position(page, f"/arms/{name}/base{path}")
            real = ask(session, lambda s: s.simulation.kinematics.joint_point(joint).copy())
            return float(np.linalg.norm(drawn - real))

        until(page, lambda off=off: off() < 0.02, f"the {arm.name} arm drawn where it is")
    screenshot(page, "scene-two-makes")
    assert run.history.table()[:, COLUMN["law_d"]].min() > session.settings.run.law.critical_distance - 1e-3
