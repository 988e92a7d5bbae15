"""Every scene in a real browser: seen at first sight, taken hold of with a real mouse, and the simulation follows."""

from typing import get_args

import numpy as np
import pytest
from playwright.sync_api import Page

from app.session.session import Session
from scenes.room import BALL_RADIUS, PATH
from scenes.settings import RunSettings, SceneName, specs
from scenes.targets import BallTarget
from tests.app.conftest import ELBOW, HAND, OpenHouse, ask
from tests.app.page.by_hand import CUT, FREE, GIZMO, GRIP, LATE_UPDATE, drag_through, hand, run_on, see_free, visit
from tests.browser import PageAt, screenshot, until, wait_frames, world_position, world_to_px

SCENES: tuple[SceneName, ...] = get_args(SceneName)
KEYS = dict(zip(SCENES, "12345", strict=True))
NAMES = dict(zip(specs(RunSettings)["scene"].choices, specs(RunSettings)["scene"].choice_labels, strict=True))
BALL_ARROW = 0.2
"""Length of the ball's arrows [m]."""

# Said by viser's page whenever a node that may be pulled is taken.
PULLED = r"Unable to preventDefault inside passive event listener"


def enter(page: Page, session: Session, scene: SceneName) -> None:
    """Go to a scene by its key, as a person does, and wait until it is there."""
    page.keyboard.press(KEYS[scene])
    until(page, lambda: session.simulation.settings.scene == scene, scene)
    alone = scene in ("solo", "ball")
    arm = "/arms/arm/base" if alone else "/arms/left/base"
    other = "/arms/left/base" if alone else "/arms/arm/base"
    page.wait_for_function(
        "names => __viserMutable.nodeRefFromName[names[0]] && !__viserMutable.nodeRefFromName[names[1]]", arg=[arm, other]
    )
    page.get_by_text(NAMES[scene], exact=True).first.wait_for()
    wait_frames(page, 6)


def is_there(page: Page, node: str) -> bool:
    """Whether the page draws a node."""
    return bool(page.evaluate("name => !!__viserMutable.nodeRefFromName[name]", node))


def test_every_scene_is_taken_hold_of(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(960, 720, expect=(LATE_UPDATE, PULLED))
    session = visit(page, house(), "autopilot=0&speed=2")
    page.mouse.click(300, 90)

    enter(page, session, "solo")
    start = hand(session)
    # Its arrows lie along the room: up is free of everything.
    up = np.array([0.0, 0.0, 1.0])
    goal = start + 0.08 * up
    drag_through(page, session, [start + up * (GRIP * GIZMO + way) for way in np.linspace(0.0, 0.08, 8)])
    until(page, lambda: np.linalg.norm(hand(session) - goal) < 0.015, "the hand where the mouse is")
    screenshot(page, "scene-solo-dragged")
    page.mouse.up()
    until(page, lambda: session.held is None, "letting go of the hand")

    enter(page, session, "ball")
    assert not is_there(page, HAND) and not is_there(page, ELBOW)

    def ball() -> np.ndarray:
        return ask(session, lambda s: s.simulation.positions[s.simulation.room.ball].copy())

    start = ball()
    drag_through(page, session, [start + up * (0.8 * BALL_ARROW + way) for way in np.linspace(0.0, 0.06, 8)])
    assert isinstance(session.held, BallTarget)
    until(page, lambda: np.linalg.norm(ball() - start - 0.06 * up) < 0.015, "the ball where its arrow is")
    until(page, lambda: np.linalg.norm(world_position(page, "/ball") - ball()) < 5e-3, "the ball drawn where it is")
    page.mouse.up()
    until(page, lambda: session.held is None, "letting go of the arrow")
    # And the ball itself: at a place on it where no arrow lies, across the view, to the left.
    x, y = world_to_px(page, ball())
    x1, _ = world_to_px(page, ball() + np.array([0.0, BALL_RADIUS, 0.0]))
    radius = abs(x1 - x)
    before, taken = ball(), (x - 0.6 * radius, y + 0.45 * radius)
    page.mouse.move(taken[0] - 2, taken[1])
    wait_frames(page, 3)
    page.mouse.move(*taken)
    wait_frames(page, 3)
    page.mouse.down()
    for step in range(1, 9):
        page.mouse.move(taken[0] - 1.2 * radius * step / 8, taken[1])
        wait_frames(page, 2)
    until(page, lambda: isinstance(session.held, BallTarget), "taking the ball itself")
    until(page, lambda: world_to_px(page, ball())[0] < x - radius, "the ball where it was pulled")
    assert np.linalg.norm(ball() - before) > 0.05
    screenshot(page, "scene-ball-dragged")
    page.mouse.up()
    until(page, lambda: session.held is None, "letting go of the ball")

    enter(page, session, "master_slave")
    start = hand(session)
    q = ask(session, lambda s: s.simulation.positions[s.simulation.avoiding.joints].copy())
    rotation = ask(session, lambda s: s.simulation.kinematics.hand_pose(s.simulation.guided).rotation.copy())
    # The arrow that is seen best.
    spans = [np.subtract(world_to_px(page, start + GIZMO * rotation[:, i]), world_to_px(page, start)) for i in range(3)]
    arrow = rotation[:, int(np.argmax([np.hypot(*span) for span in spans]))]
    drag_through(page, session, [start + arrow * (GRIP * GIZMO + way) for way in np.linspace(0.0, 0.07, 8)])
    until(page, lambda: np.linalg.norm(hand(session) - start - 0.07 * arrow) < 0.02, "the master where the mouse is")
    run_on(page, session, 0.5)
    moved = ask(session, lambda s: s.simulation.positions[s.simulation.avoiding.joints].copy()) - q
    assert np.abs(moved).max() > 0.02
    screenshot(page, "scene-master-dragged")
    page.mouse.up()
    until(page, lambda: session.held is None, "letting go of the master")

    enter(page, session, "imitation")
    ask(session, lambda s: s.change("source", "figure"))
    page.wait_for_function("__viserMutable.nodeRefFromName['/gizmo/left_wrist']")
    wait_frames(page, 6)
    q = ask(session, lambda s: s.simulation.positions.copy())
    x, y = world_to_px(page, world_position(page, "/gizmo/left_wrist"))
    page.mouse.move(x - 2, y)
    wait_frames(page, 3)
    page.mouse.move(x, y)
    wait_frames(page, 3)
    page.mouse.down()
    for step in range(1, 9):
        page.mouse.move(x + 4 * step, y - 8 * step)
        wait_frames(page, 2)
    until(page, lambda: np.abs(ask(session, lambda s: s.simulation.positions.copy()) - q).max() > 0.15, "robots that follow")
    screenshot(page, "scene-figure-dragged")
    page.mouse.up()

    enter(page, session, "hold")
    assert is_there(page, HAND) and not is_there(page, "/person/body") and not is_there(page, "/gizmo/left_wrist")


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (1024, 768), (390, 844)])
def test_first_sight_of_every_scene(house: OpenHouse, page_at: PageAt, width: int, height: int) -> None:
    page = page_at(width, height, expect=(LATE_UPDATE,))
    session = visit(page, house(), "speed=2")
    for scene in (*SCENES[:2], *SCENES[3:]):
        ask(session, lambda s, scene=scene: s.change("scene", scene))
        until(page, lambda scene=scene: is_there(page, "/arms/arm/base" if scene in ("solo", "ball") else "/arms/left/base"))
        joints = ask(session, lambda s: [(arm.name, arm.joints.stop - arm.joints.start) for arm in s.simulation.room.arms])
        links = [
            f"/arms/{name}/base" + "".join(f"/j{i}" for i in range(1, n + 1)) for name, count in joints for n in range(count + 1)
        ]
        more = {"ball": ["/ball"], "imitation": ["/person/body/left_upper_arm/left_forearm"]}.get(scene, [])
        see_free(page, links + more, scene)
        if scene == "ball":
            start = ask(session, lambda s: s.simulation.home)
            assert start is not None
            for end in (start, start + PATH):
                assert page.evaluate("p => document.elementFromPoint(...p) === __viserMutable.canvas", world_to_px(page, end))
        # Somewhere on the way, so that the picture shows what happens.
        run_on(page, session, 2.5 if scene == "ball" else 1.5)
        screenshot(page, f"scene-{width}-{scene}")
        assert page.evaluate(CUT) == [], scene
        assert page.evaluate(FREE, links + more) == [], scene
