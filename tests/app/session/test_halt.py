"""Why a run stands still: every reason has its own author, and only the teacher's is not the visitor's to lift."""

from collections.abc import Callable

import pytest

from app.session.halt import Halt
from app.session.session import Session
from app.settings import Settings


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


@pytest.mark.parametrize("ask", [Session.single_step, Session.toggle_pause], ids=["a single step", "go on"])
@pytest.mark.parametrize("posted", [True, False], ids=["by the page", "before the frame"])
@pytest.mark.parametrize("paused", [True, False], ids=["paused before", "running before"])
def test_no_step_is_made_while_the_teacher_stops_the_session(ask: Callable[[Session], None], posted: bool, paused: bool) -> None:
    session = Session(Settings())
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
