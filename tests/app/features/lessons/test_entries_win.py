"""Lesson cases of the core's `test_entries_win.py`."""

import numpy as np
import pytest

from app.features.lessons.bookmark import Phase
from app.features.lessons.panel.lesson_controls import LessonControls
from app.features.lessons.session.lesson_actions import Choose, Press
from app.session.session import Session
from tests.app.conftest import OpenHouse, ask, visitor_of
from tests.app.page.by_hand import row_of
from tests.app.page.test_entries_win import box
from tests.app.runtime.processes import until as arrived
from tests.browser import PageAt, until, world_position
from tests.tools.lesson_walker import enter

ELBOW = "/arms/arm/base/j1/j2/j3/j4"


def test_a_value_that_arrives_during_a_frame_swings_only_the_elbow(
    house: OpenHouse, page_at: PageAt, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = page_at(900, 640)
    opened = house()
    session, run = enter(page, opened, "lesson=1&step=1")
    ask(session, lambda _: run.act(Choose(2)))
    while run.walk.phase is not Phase.CHALLENGE:
        ask(session, lambda _: run.act(Press("next")))
    swing = box(row_of(page, "swing the elbow"))
    swing.wait_for()
    slider, making = (
        visitor_of(opened).operation.panel(LessonControls)._motions._sliders[0],
        session.control.step,
    )

    def slow_step(elapsed: float, budget: float) -> int:
        """Step the frame only after the visitor's value arrived; the frame has taken its actions before."""
        arrived(lambda: slider.value == 50.0)
        return making(elapsed, budget)

    def places(s: Session) -> tuple[np.ndarray, np.ndarray]:
        kinematics, arm = s.simulation.kinematics, s.simulation.guided
        return kinematics.hand_pose(arm).translation.copy(), kinematics.joint_point(arm.elbow)

    (hand, elbow), drawn = ask(session, places), world_position(page, ELBOW)
    monkeypatch.setattr(session.control, "step", slow_step)
    swing.fill("50")
    arrived(lambda: slider.value == 50.0)
    monkeypatch.setattr(session.control, "step", making)
    until(page, lambda: np.linalg.norm(world_position(page, ELBOW) - drawn) > 0.05, "the elbow on its way")
    assert swing.input_value() == "50" and slider.value == 50.0
    # The elbow swings to both sides, and the hand stays.
    way = ask(session, places)[1] - elbow
    assert np.linalg.norm(ask(session, places)[0] - hand) < 5e-4
    swing.fill("-50")
    until(
        page,
        lambda: (ask(session, places)[1] - elbow) @ way < -0.05 * np.linalg.norm(way),
        "the elbow on its other side",
    )
    assert np.linalg.norm(ask(session, places)[0] - hand) < 5e-4
    # A new run begins at 0.
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("r")
    until(page, lambda: swing.input_value() == "0", "0 again")
