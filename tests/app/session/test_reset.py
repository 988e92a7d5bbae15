"""A reset is a fresh start to the last bit, and keeps the pause."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from app.session.session import Session
from scenes.targets import HandTarget
from tests.app.session.conftest import bits


@pytest.mark.parametrize(
    "change", [{}, {"guided": "left"}, {"rig": "table", "law": "unprotected"}, {"dt": 0.01, "autopilot": False}]
)
def test_reset_is_a_fresh_start_to_the_last_bit(session: Session, change: dict[str, Any]) -> None:
    session.advance(0.0349)
    session.hold(HandTarget(np.array([0.3, 0.1, 0.9])))
    session.advance(0.1)
    session.change("autopilot", True)
    for key, value in change.items():
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
