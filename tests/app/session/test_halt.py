"""Why a run stands still, what only the teacher may lift, and how a run starts again."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from app.session.halt import Halt
from app.session.session import Session
from scenes.targets import HandTarget
from tests.app.session.conftest import bits


def test_the_run_goes_on_when_no_reason_is_left() -> None:
    halt = Halt()
    halt.set("lesson")
    halt.set("replay")
    halt.set("lesson", False)
    assert halt and "replay" in halt and "lesson" not in halt
    halt.set("replay", False)
    assert not halt
    halt.set("visitor")
    halt.set("teacher")
    halt.go_on()
    assert "teacher" in halt and "visitor" not in halt


Ask = Callable[[Session], None]


@pytest.mark.parametrize("ask", [Session.single_step, Session.toggle_pause], ids=["a single step", "go on"])
@pytest.mark.parametrize("posted", [True, False], ids=["by the page", "before the frame"])
@pytest.mark.parametrize("paused", [True, False], ids=["paused before", "running before"])
def test_no_step_is_made_while_the_teacher_stops_it(session: Session, ask: Ask, posted: bool, paused: bool) -> None:
    session.advance(0.05)
    before = session.simulation.steps
    session.halt.set("visitor", paused)
    session.halt.set("teacher")
    for _ in range(3):
        if posted:
            session.post(lambda: ask(session))
        else:
            ask(session)
        assert session.advance(0.05) == 0
    session.post(lambda: session.change("dm", 0.2))
    session.advance(0.05)
    assert session.settings.run.law.critical_distance == 0.2, "anything but a step"
    assert session.paused and session.simulation.steps == before
    session.halt.set("teacher", False)
    assert session.paused == paused and session.advance(0.0) == 0
    # Afterwards everything is as it was.
    session.single_step()
    assert session.advance(0.0) == 1
    session.toggle_pause()
    assert session.advance(0.05) > 1


CHANGES = [{}, {"guided": "left"}, {"rig": "table", "law": "unprotected"}, {"dt": 0.01, "autopilot": False}]


@pytest.mark.parametrize("change", CHANGES)
def test_reset_is_a_fresh_start_to_the_last_bit(session: Session, change: dict[str, Any]) -> None:
    session.advance(0.0349)
    session.hold(HandTarget(np.array([0.3, 0.1, 0.9])))
    session.advance(0.1)
    for key, value in {"autopilot": True, **change}.items():
        session.change(key, value)
    for _ in range(30):
        session.advance(0.1)
    session.reset()
    fresh = Session(session.settings)
    assert session.simulation.time == 0.0 and session.simulation.history.count == 0 and session.held is None
    for elapsed in (0.033, 0.041, 0.1, 0.07) * 8:
        assert session.advance(elapsed) == fresh.advance(elapsed)
    assert bits(session) == bits(fresh)
    assert session.simulation.history.count > 100


def test_reset_keeps_the_pause(session: Session) -> None:
    session.advance(0.1)
    session.toggle_pause()
    session.reset()
    assert session.paused and session.advance(0.1) == 0 and session.simulation.steps == 0
    session.toggle_pause()
    assert session.advance(0.1) == 20
