"""Every scene in a real browser by its key; ball and figure follow a real mouse, as the hand does in `test_mouse_on_handles`."""

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
from tests.app.conftest import ELBOW, HAND, OpenHouse, ask
from tests.app.page.by_hand import LATE_UPDATE, drag_through, hand, visit
from tests.browser import PageAt, screenshot, settled_view, until, wait_frames, world_position, world_to_px

SCENES = tuple(EXPERIMENTS)
KEYS = dict(zip(SCENES, "123456", strict=True))
NAMES = specs(RunSettings)["scene"].options()
BALL_ARROW = 0.2
"""Length of the ball's arrows [m]."""


def enter(page: Page, session: Session, scene: str) -> None:
    """Go to a scene by its key, as a person does, and wait until it is there."""
    page.keyboard.press(KEYS[scene])
    until(page, lambda: session.simulation.settings.scene == scene, scene)
    arms = ["/arms/left/base", "/arms/arm/base"][:: -1 if scene in ("solo", "ball") else 1]
    page.wait_for_function(
        "([a, b]) => __viserMutable.nodeRefFromName[a] && !__viserMutable.nodeRefFromName[b]", arg=arms
    )
    page.get_by_text(NAMES[scene], exact=True).first.wait_for()
    wait_frames(page, 6)


def pull_pixels(page: Page, start: tuple[float, float], way: tuple[float, float]) -> None:
    """Take what is at a point of the window with the mouse, and pull it in eight steps."""
    x, y = start
    for place in ((x - 2, y), (x, y)):
        page.mouse.move(*place)
        wait_frames(page, 3)
    page.mouse.down()
    for step in range(1, 9):
        page.mouse.move(x + way[0] * step / 8, y + way[1] * step / 8)
        wait_frames(page, 2)


def pull_the_figure(page: Page, session: Session) -> None:
    """Pull the person who is imitated at an elbow, and again if it was on its way while the mouse came."""
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
    """Keep a picture of what is held, and let go."""
    screenshot(page, f"scene-{what}-dragged")
    page.mouse.up()
    until(page, lambda: session.held is None, f"letting go of the {what}")


@pytest.mark.thorough
def test_every_scene_is_entered_its_ball_or_figure_pulled_and_two_makes_are_drawn_where_they_are(
    house: OpenHouse, page_at: PageAt
) -> None:
    page = page_at(960, 720, expect=(LATE_UPDATE,))
    session = visit(page, house(), "gizmo=1&autopilot=0&speed=2")
    page.mouse.click(300, 90)

    def are_there(*nodes: str) -> bool:
        return bool(page.evaluate("names => names.some(name => __viserMutable.nodeRefFromName[name])", nodes))

    def ball() -> np.ndarray:
        return ask(session, lambda s: s.simulation.positions[s.simulation.room.ball].copy())

    enter(page, session, "ball")
    until(page, lambda: not are_there(HAND, ELBOW), "no handles of a hand")
    start, up = ball(), np.array([0.0, 0.0, 1.0])
    drag_through(page, session, [start + up * (0.8 * BALL_ARROW + way) for way in np.linspace(0.0, 0.06, 8)])
    assert isinstance(session.held, BallTarget)
    until(page, lambda: np.linalg.norm(ball() - start - 0.06 * up) < 0.015, "the ball where its arrow is")
    until(
        page,
        lambda: np.linalg.norm(world_position(page, "/ball") - ball()) < 5e-3,
        "the ball drawn where it is",
    )
    let_go(page, session, "arrow")
    # And the ball itself: at a place on it where no arrow lies, across the view, to the left.
    settled_view(page)
    x, y = world_to_px(page, ball())
    x1, _ = world_to_px(page, ball() + np.array([0.0, BALL_RADIUS, 0.0]))
    radius = abs(x1 - x)
    before, taken = ball(), (x - 0.6 * radius, y + 0.45 * radius)
    pull_pixels(page, taken, (-1.2 * radius, 0.0))
    until(page, lambda: isinstance(session.held, BallTarget), "taking the ball itself")
    until(page, lambda: world_to_px(page, ball())[0] < x - radius, "the ball where it was pulled")
    assert np.linalg.norm(ball() - before) > 0.05
    let_go(page, session, "ball")

    for scene in ("solo", "master_slave"):
        enter(page, session, scene)
        until(
            page,
            lambda: np.linalg.norm(world_position(page, HAND) - hand(session)) < 2e-3,
            "the handle on the hand",
        )
    enter(page, session, "imitation")
    q = ask(session, lambda s: s.simulation.positions.copy())
    pull_the_figure(page, session)
    until(
        page,
        lambda: np.abs(ask(session, lambda s: s.simulation.positions.copy()) - q).max() > 0.15,
        "robots that follow",
    )
    screenshot(page, "scene-figure-dragged")
    page.mouse.up()

    enter(page, session, "hold")
    until(page, lambda: are_there(HAND) and not are_there("/person/body"), "the hand's handle, and no figure")

    # Two makes are drawn where they are, and one gives way.
    ask(
        session,
        lambda s: [
            s.change(key, value)
            for key, value in {"robot": "ur5_panda", "rig": "table", "autopilot": True}.items()
        ],
    )
    until(page, lambda: session.simulation.sample().activation > 0.5, "a meeting")
    ask(session, lambda s: s.change("speed", 0.25))
    run = session.simulation
    for arm, made, count in zip(run.room.arms, run.room.robots, (6, 7), strict=True):
        path = "".join(f"/{joint.name}" for joint in joint_frames(made.key))
        assert arm.joints.stop - arm.joints.start == path.count("/") == count

        def off(path: str = path, joint: int = arm.joints.stop, name: str = arm.name) -> float:
            drawn = world_position(page, f"/arms/{name}/base{path}")
            return float(
                np.linalg.norm(
                    drawn - ask(session, lambda s: s.simulation.kinematics.joint_point(joint).copy())
                )
            )

        until(page, lambda off=off: off() < 0.02, f"the {arm.name} arm drawn where it is")
    screenshot(page, "scene-two-makes")
    assert run.history.table()[:, COLUMN["law_d"]].min() > session.settings.run.law.critical_distance - 1e-3
