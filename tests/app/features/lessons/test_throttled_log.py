"""Lesson cases of the core's `test_throttled_log.py`."""

from typing import Any

import pytest

from app.features.lessons.loading import load_lessons
from app.features.lessons.session.lesson_actions import Press
from app.features.lessons.session.lesson_session import LessonSession
from app.session.session import Session
from app.settings import Settings
from tests.app.runtime.test_throttled_log import Caplog, lines


def test_a_lesson_failing_at_every_frame_is_logged_once_per_run(
    monkeypatch: pytest.MonkeyPatch, caplog: Caplog
) -> None:
    session = Session(Settings())
    run = LessonSession(session, load_lessons())
    run.enter(0)

    def fail(_: Any) -> None:
        raise RuntimeError

    monkeypatch.setattr(run.walk, "watch", fail)
    monkeypatch.setattr(run.walk, "live", fail)
    for _ in range(5):
        run.decide()
        assert run.live(session.simulation) == ()
    assert len(lines(caplog)) == 2
    assert [title for title, _ in session.notices] == ["The lesson stopped here"]
    run.act(Press("reset"))
    run.decide()
    assert len(session.notices) == 2
