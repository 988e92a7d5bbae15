"""What is posted to a session is done in order at the beginning of the next frame."""

from __future__ import annotations

import logging
import math

import pytest

from app.session import Session
from app.settings import PageSettings, Settings


def test_posts_are_done_in_order_at_the_beginning_of_the_next_frame(session: Session) -> None:
    done: list[int] = []
    for number in range(3):
        session.post(lambda number=number: done.append(10 * number + session.simulation.steps))
    assert done == []
    session.advance(0.05)
    assert done == [0, 10, 20]


def test_a_post_that_fails_stops_neither_the_others_nor_the_clock(session: Session, caplog: pytest.LogCaptureFixture) -> None:
    done: list[str] = []
    session.post(lambda: done.append("before"))
    session.post(lambda: session.change("dm", math.nan))
    session.post(lambda: done.append("after"))
    with caplog.at_level(logging.ERROR, "duet.session"):
        assert session.advance(0.05) == 10
    assert done == ["before", "after"] and len(caplog.records) == 1
    assert session.settings == Settings() and session.settings.page == PageSettings()
