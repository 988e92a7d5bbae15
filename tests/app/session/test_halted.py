"""A session that somebody else holds still: nothing that its visitor does makes a step, and nothing is made up for afterwards."""

from collections.abc import Callable

import pytest

from app.session.session import Session
from app.settings import Settings


@pytest.mark.parametrize("ask", [Session.single_step, Session.toggle_pause], ids=["a single step", "go on"])
@pytest.mark.parametrize("posted", [True, False], ids=["by the page", "before the frame"])
def test_no_step_is_made_while_everybody_is_held(ask: Callable[[Session], None], posted: bool) -> None:
    session = Session(Settings())
    session.advance(0.05)
    before = session.simulation.steps
    session.paused = session.halted = True
    for _ in range(3):
        if posted:
            session.post(lambda: ask(session))
        else:
            ask(session)
        assert session.advance(0.05) == 0
    assert session.paused and session.simulation.steps == before
    session.halted = False
    assert session.advance(0.0) == 0 and session.simulation.steps == before
    # Afterwards everything is as it was.
    session.single_step()
    assert session.advance(0.0) == 1
    session.toggle_pause()
    assert session.advance(0.05) > 1


def test_whatever_else_a_visitor_does_meanwhile_is_done() -> None:
    session = Session(Settings())
    session.halted = True
    session.post(lambda: session.change("dm", 0.2))
    session.advance(0.05)
    assert session.settings.run.law.critical_distance == 0.2 and session.simulation.steps == 0
