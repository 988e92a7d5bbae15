"""Every key in a real browser: on the canvas it does what the table says, in an input it is a letter."""

import re
from collections.abc import Callable

import numpy as np
import pinocchio as pin
import pytest

from app.page.handles.gizmos import NUDGE, SWING
from app.page.handles.transform_handles import swivel_frame
from app.page.panels.hotkeys import hotkeys
from scenes.settings import changed
from scenes.targets import HandTarget
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import control, drag, hand, visit
from tests.app.page.helpers import SPECS
from tests.browser import CAMERA, PageAt, settled_view, until, wait_frames

SENTENCE = re.compile(
    r"In the picture orange arm: hand .*, \d+ cm up; silver arm: hand .*; d = \d+ mm; λ = \d\.\d\d: .+\.|"
    r"In the picture silver arm: hand .*, \d+ cm up; orange arm: hand .*; d = \d+ mm; λ = \d\.\d\d: .+\."
)

ARROWS = "!!__viserMutable.nodeRefFromName['/gizmo/hand']"


@pytest.mark.thorough
def test_every_key_on_the_canvas_and_none_in_an_input(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(900, 640)
    # At rest, so that the camera has nothing to follow.
    session = visit(page, house(), "autopilot=0")
    page.mouse.click(520, 90)
    view, done = settled_view(page), set[str]()

    def press(action: str, key: str, effect: Callable[[], object]) -> None:
        done.add(action)
        # Held for some frames, as a finger does.
        page.keyboard.down(key)
        wait_frames(page, 4)
        page.keyboard.up(key)
        until(page, effect, f"the key {key}")
        if action not in ("view", "reset", *SPECS["scene"].choices):
            assert np.allclose(page.evaluate(CAMERA), view, atol=0.02), f"{key} moves the camera"

    def held() -> HandTarget:
        return session.held if isinstance(session.held, HandTarget) else HandTarget(place)

    def first_view() -> bool:
        # From the same side; how far away depends on where the hands are.
        return np.allclose(page.evaluate(CAMERA)[3:], view[3:], atol=2e-3)

    press("pause", " ", lambda: session.paused)
    steps = ask(session, lambda s: s.simulation.steps)
    press("step", ".", lambda: session.simulation.steps == steps + 1)
    press("slower", "[", lambda: session.settings.page.speed == 0.5)
    press("faster", "]", lambda: session.settings.page.speed == 1.0)
    for law in ("unprotected", "smooth_priority"):
        press("law", "l", lambda law=law: session.settings.run.law.law == law)
    for driven in (True, False, True):
        press("autopilot", "a", lambda driven=driven: session.settings.page.autopilot is driven)
    place = hand(session)
    # Seen from in front of the torso, to the right is +y, away is −x (the view is turned by a little).
    ways = {"ArrowLeft": (0, -1, 0), "ArrowRight": (0, 1, 0), "ArrowUp": (0, 0, 1), "ArrowDown": (0, 0, -1)}
    ways |= {"PageUp": (-1, 0, 0), "PageDown": (1, 0, 0)}
    for action, (key, way) in zip(("left", "right", "up", "down", "away", "near"), ways.items(), strict=True):
        press(action, key, lambda place=place: np.linalg.norm(held().position - place) > NUDGE / 2)
        step = held().position - place
        assert (
            np.linalg.norm(step) == pytest.approx(NUDGE, rel=1e-6) and step @ np.array(way) > 0.85 * NUDGE
        ), action
        assert way[2] or abs(step[2]) < 1e-9
        place = held().position.copy()
    assert not session.settings.page.autopilot

    elbow = ask(session, lambda s: s.simulation.kinematics.joint_point(s.simulation.guided.elbow))
    frame, foot = ask(session, lambda s: swivel_frame(s.hand))
    for action, key, angle in (
        ("elbow_up", "j", SWING),
        ("elbow_down", "k", 0.0),
        ("elbow_down", "k", -SWING),
    ):
        wanted = foot + pin.exp3(frame[:, 0] * angle) @ (elbow - foot)
        press(
            action, key, lambda wanted=wanted: (now := held().elbow) is not None and np.allclose(now, wanted)
        )
        assert np.allclose(held().position, place), "the hand stays where it was wanted"
    press(
        "describe",
        "i",
        lambda: SENTENCE.fullmatch(page.get_by_role("alert").last.inner_text().replace("\n", " ")),
    )
    press("reset", "r", lambda: session.simulation.steps == 0)
    assert session.paused and ask(
        session, lambda s: (s.simulation.steps, s.simulation.history.count, s.held)
    ) == (0, 0, None)

    # Turn the view with the mouse, and take it back.
    drag(page, [(520, 90), (395, 115)])
    until(page, lambda: not np.allclose(page.evaluate(CAMERA), view, atol=0.05), "a turned view")
    press("view", "v", first_view)
    view = settled_view(page)
    for shown in (False, True):
        press("contact", "o", lambda shown=shown: session.settings.page.contact is shown)
    for shown in (True, False):
        press("gizmo", "m", lambda shown=shown: bool(page.evaluate(ARROWS)) is shown)
    press("ghost", "g", lambda: session.ghost is not None)
    press("ghost", "g", lambda: session.ghost is None)
    # Another scene is seen from elsewhere; the one from before is seen as before.
    scenes = dict(zip(SPECS["scene"].choices, "123456", strict=True))
    for scene in (*scenes, "hold"):
        page.keyboard.press(scenes[scene])
        until(page, lambda scene=scene: session.simulation.settings.scene == scene, scene)
        done.add(scene)
    until(page, first_view, "the first view")
    assert done == {hotkey.name for hotkey in hotkeys()}

    # In an input they are letters and moves of the caret.
    box = control(page, "dm").locator("input[type=text]").last
    before = ask(session, lambda s: (s.settings, s.paused, s.held, s.simulation.steps))
    box.click()
    for key in (" ", ".", "[", "]", "r", "a", "l", "v", "g", "1", "4", "PageUp", "ArrowLeft", "ArrowRight"):
        page.keyboard.press(key)
        wait_frames(page, 2)
    box.fill("120")
    box.press("Enter")
    until(page, lambda: session.settings.run.law.critical_distance == pytest.approx(0.12), "d_m")
    after = ask(session, lambda s: (changed(s.settings, "dm", 0.15), s.paused, s.held, s.simulation.steps))
    assert after == before
    page.mouse.click(520, 90)
    page.keyboard.press(" ")
    until(page, lambda: not session.paused, "going on")

    # A key that is held acts once, and Space presses the button that Tab has led to.
    for _ in range(4):
        page.keyboard.down(" ")
    page.keyboard.up(" ")
    until(page, lambda: session.paused, "one pause")
    steps = ask(session, lambda s: s.simulation.steps)
    page.keyboard.press(".")
    until(page, lambda: session.simulation.steps == steps + 1, "one step")
    assert session.paused, "the repeats of the key were none"
    # After a click the key is the page's, as a mouse has led there.
    button = page.get_by_role("button", name="Step", exact=True)
    button.click()
    until(page, lambda: session.simulation.steps == steps + 2, "a step by mouse")
    page.keyboard.press(" ")
    until(page, lambda: not session.paused, "going on")
    page.keyboard.press(" ")
    until(page, lambda: session.paused, "another pause")
    steps = ask(session, lambda s: s.simulation.steps)
    page.keyboard.press("Tab")
    page.keyboard.press("Shift+Tab")
    assert button.evaluate("b => b === document.activeElement")
    page.keyboard.press(" ")
    until(page, lambda: session.simulation.steps == steps + 1, "the button pressed")
    assert session.paused
