"""Every key in a real browser: on the canvas it has the effect in the table, in an input it is a letter."""

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
import pytest

from app.page.handles.gizmos import NUDGE, SWING
from app.page.handles.transform_handles import swivel_frame
from app.page.panels.hotkeys import hotkeys
from app.session.session import Session
from scenes.settings import changed, values
from scenes.targets import HandTarget
from tests.app.conftest import ask
from tests.app.page.by_hand import control, drag, hand
from tests.app.page.helpers import SPECS
from tests.app.page.shared_page import Shared, SharedPage, SharedPages
from tests.browser import CAMERA, settled_view, until, wait_frames

thorough = pytest.mark.thorough

# The arms are at rest, so that the camera does not move.
SHARED = SharedPage(900, 640, "autopilot=0")
FREE = (520, 90)
"""A place in the window over the empty scene [CSS px]."""

SWITCHES = (
    ("slower", "[", "speed", (0.5,)),
    ("faster", "]", "speed", (1.0,)),
    ("law", "l", "law", ("unprotected", "smooth_priority")),
    ("autopilot", "a", "autopilot", (True, False, True)),
    ("contact", "o", "contact", (False, True)),
    ("gizmo", "m", "gizmo", (True, False)),
    ("ghost", "g", "ghost", ("frozen", "off")),
)
"""Action, key, setting, and its values after each press."""

# Seen from the front of the torso, right is +y and away is −x (the view is slightly turned).
NUDGES = {
    "left": ("ArrowLeft", (0, -1, 0)),
    "right": ("ArrowRight", (0, 1, 0)),
    "up": ("ArrowUp", (0, 0, 1)),
    "down": ("ArrowDown", (0, 0, -1)),
    "away": ("PageUp", (-1, 0, 0)),
    "near": ("PageDown", (1, 0, 0)),
}
SWINGS = (("elbow_up", "j", SWING), ("elbow_down", "k", 0.0), ("elbow_down", "k", -SWING))
"""Action, key, and angle of the elbow after the press [rad]."""

PAUSE, STEP, RESET = ("pause", " "), ("step", "."), ("reset", "r")
DESCRIBE, VIEW = ("describe", "i"), ("view", "v")
SCENES = dict(zip(SPECS["scene"].choices, "123456", strict=True))
SENTENCE = re.compile(
    r"In the picture orange arm: hand .*, \d+ cm up; silver arm: hand .*; d = \d+ mm; λ = \d\.\d\d: .+\.|"
    r"In the picture silver arm: hand .*, \d+ cm up; orange arm: hand .*; d = \d+ mm; λ = \d\.\d\d: .+\."
)
ARROWS = "!!__viserMutable.nodeRefFromName['/gizmo/hand']"


def test_every_key_of_the_table_is_tested_here() -> None:
    single = (action for action, _ in (PAUSE, STEP, DESCRIBE, RESET, VIEW))
    tried = {*(row[0] for row in (*SWITCHES, *SWINGS)), *NUDGES, *SCENES, *single}
    assert tried == {hotkey.name for hotkey in hotkeys()}


@pytest.fixture(scope="module")
def first_view(shared_pages: SharedPages) -> np.ndarray:
    """Initial camera of the page."""
    return settled_view(shared_pages.get(SHARED).page)


@dataclass(frozen=True)
class Keys:
    """The shared page, paused, with the keyboard focus on the canvas."""

    shared: Shared
    view: np.ndarray

    @property
    def session(self) -> Session:
        return self.shared.session

    @property
    def steps(self) -> int:
        return ask(self.session, lambda s: s.simulation.steps)

    def until(self, true: Callable[[], object], what: str) -> None:
        until(self.shared.page, true, what)

    def press(self, action: str, key: str, effect: Callable[[], object]) -> None:
        """Hold a key for some frames. Only view, reset and ghost (by its legend) may move the camera."""
        keyboard = self.shared.page.keyboard
        keyboard.down(key)
        wait_frames(self.shared.page, 4)
        keyboard.up(key)
        self.until(effect, f"the key {key}")
        if action not in ("view", "reset", "ghost"):
            camera = self.shared.page.evaluate(CAMERA)
            assert np.allclose(camera, self.view, atol=0.02), f"{key} moves the camera"

    def sees_first_view(self) -> bool:
        """True if seen from the same side; the camera's distance depends on the hands."""
        return np.allclose(self.shared.page.evaluate(CAMERA)[3:], self.view[3:], atol=2e-3)


@pytest.fixture
def keys(first_view: np.ndarray, shared: Shared) -> Keys:
    page, session = shared.page, shared.session
    page.mouse.click(*FREE)
    ask(session, lambda s: [s.control.toggle_pause(), s.reset()])
    until(page, lambda: np.allclose(page.evaluate(CAMERA), first_view, atol=0.01), "the first view")
    return Keys(shared, first_view)


@thorough
def test_one_key_pauses_and_another_makes_a_step(keys: Keys) -> None:
    keys.press(*PAUSE, lambda: not keys.session.paused)
    keys.press(*PAUSE, lambda: keys.session.paused)
    steps = keys.steps
    keys.press(*STEP, lambda: keys.session.simulation.steps == steps + 1)


@thorough
def test_keys_change_their_settings(keys: Keys) -> None:
    session, page = keys.session, keys.shared.page
    for action, key, setting, settings in SWITCHES:
        for value in settings:
            keys.press(action, key, lambda name=setting, value=value: values(session.settings)[name] == value)
            keys.until(
                lambda: bool(page.evaluate(ARROWS)) is session.settings.page.gizmo, "arrows as they are set"
            )
            keys.until(
                lambda: (session.ghost is not None) is (session.settings.page.ghost == "frozen"), "the ghost"
            )


@thorough
def test_six_keys_move_the_hand_as_the_visitor_sees_it(keys: Keys) -> None:
    session = keys.session
    ask(session, lambda s: s.change("autopilot", True))
    place = hand(session)

    def wanted() -> np.ndarray:
        return session.held.position if isinstance(session.held, HandTarget) else place

    for action, (key, way) in NUDGES.items():
        keys.press(action, key, lambda place=place: np.linalg.norm(wanted() - place) > NUDGE / 2)
        step = wanted() - place
        assert np.linalg.norm(step) == pytest.approx(NUDGE, rel=1e-6), action
        assert step @ np.array(way) > 0.85 * NUDGE, action
        assert way[2] or abs(step[2]) < 1e-9
        place = wanted().copy()
    assert not session.settings.page.autopilot


@thorough
def test_two_keys_swing_the_elbow_about_the_hands_target(keys: Keys) -> None:
    session = keys.session
    # In a paused run only the target moves.
    keys.press("up", "ArrowUp", lambda: session.held is not None)
    place = session.held.position.copy() if isinstance(session.held, HandTarget) else None
    elbow = ask(session, lambda s: s.simulation.kinematics.joint_point(s.simulation.guided.elbow))
    frame, foot = ask(session, lambda s: swivel_frame(s.hand))
    for action, key, angle in SWINGS:
        wanted = foot + pin.exp3(frame[:, 0] * angle) @ (elbow - foot)

        def is_there(wanted: np.ndarray = wanted) -> bool:
            held = session.held
            return isinstance(held, HandTarget) and held.elbow is not None and np.allclose(held.elbow, wanted)

        keys.press(action, key, is_there)
        assert isinstance(session.held, HandTarget) and place is not None
        assert np.allclose(session.held.position, place), "the hand's target has moved"


@thorough
def test_a_key_describes_the_picture(keys: Keys) -> None:
    said = keys.shared.page.get_by_role("alert").last
    keys.press(*DESCRIBE, lambda: SENTENCE.fullmatch(said.inner_text().replace("\n", " ")))


@thorough
def test_a_key_restarts_the_run_and_leaves_it_paused(keys: Keys) -> None:
    session = keys.session
    keys.press("up", "ArrowUp", lambda: session.held is not None)
    keys.press(*STEP, lambda: session.simulation.steps == 1)
    keys.press(*RESET, lambda: session.simulation.steps == 0)
    after = ask(session, lambda s: (s.simulation.steps, s.simulation.history.count, s.held, s.paused))
    assert after == (0, 0, None, True)


@thorough
def test_a_key_restores_the_first_view_after_a_turn_by_mouse(keys: Keys) -> None:
    page, (x, y) = keys.shared.page, FREE
    drag(page, [(x, y), (x - 125, y + 25)])
    until(page, lambda: not np.allclose(page.evaluate(CAMERA), keys.view, atol=0.05), "a turned view")
    keys.press(*VIEW, keys.sees_first_view)


@thorough
def test_digits_open_the_scenes_and_the_first_has_its_first_view(keys: Keys) -> None:
    page, session = keys.shared.page, keys.session
    for scene in (*SCENES, "hold"):
        page.keyboard.press(SCENES[scene])
        keys.until(lambda scene=scene: session.simulation.settings.scene == scene, scene)
    keys.until(keys.sees_first_view, "the first view")


@thorough
def test_keys_in_an_input_type_letters_and_move_the_caret(keys: Keys) -> None:
    page, session = keys.shared.page, keys.session
    # Keys that would have an effect here.
    keys.press("up", "ArrowUp", lambda: session.held is not None)
    keys.press(*STEP, lambda: session.simulation.steps == 1)
    box = control(page, "dm").locator("input[type=text]").last
    held, before = session.held, ask(session, lambda s: (s.settings, s.paused, s.simulation.steps))
    box.click()
    for key in (" ", ".", "[", "]", "r", "a", "l", "v", "g", "1", "4", "PageUp", "ArrowLeft", "ArrowRight"):
        page.keyboard.press(key)
        wait_frames(page, 2)
    box.fill("120")
    box.press("Enter")
    keys.until(lambda: session.settings.run.law.critical_distance == pytest.approx(0.12), "d_m")
    after = ask(session, lambda s: (changed(s.settings, "dm", 0.15), s.paused, s.simulation.steps))
    assert after == before and session.held is held
    page.mouse.click(*FREE)
    page.keyboard.press(" ")
    keys.until(lambda: not session.paused, "going on")


@thorough
def test_a_key_that_is_held_acts_once(keys: Keys) -> None:
    keyboard, session = keys.shared.page.keyboard, keys.session
    keys.press(*PAUSE, lambda: not session.paused)
    for _ in range(4):
        keyboard.down(" ")
    keyboard.up(" ")
    keys.until(lambda: session.paused, "one pause")
    steps = keys.steps
    keyboard.press(".")
    keys.until(lambda: session.simulation.steps == steps + 1, "one step")
    assert session.paused, "a repeat of the key counted as a press"


@thorough
def test_space_pauses_after_a_click_and_presses_a_button_after_tab(keys: Keys) -> None:
    page, session = keys.shared.page, keys.session
    button = page.get_by_role("button", name="Step", exact=True)
    steps = keys.steps
    button.click()
    keys.until(lambda: session.simulation.steps == steps + 1, "a step by mouse")
    # The mouse has set the focus, not Tab.
    page.keyboard.press(" ")
    keys.until(lambda: not session.paused, "going on")
    page.keyboard.press(" ")
    keys.until(lambda: session.paused, "another pause")
    steps = keys.steps
    page.keyboard.press("Tab")
    page.keyboard.press("Shift+Tab")
    assert button.evaluate("b => b === document.activeElement")
    page.keyboard.press(" ")
    keys.until(lambda: session.simulation.steps == steps + 1, "the button pressed")
    assert session.paused
