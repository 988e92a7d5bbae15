"""What fails frame after frame is in the log once, and then as a count at ever longer intervals."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

import pytest

from app.bench.blocking_client import BlockingClient
from app.hosting.private_host import PrivateHost
from app.lessons.loading import load_lessons
from app.lessons.session.lesson_session import LessonSession
from app.runtime.throttled_log import INTERVALS, ThrottledLog
from app.session.session import Session
from app.settings import Settings
from tests.app.conftest import OpenHouse, ask

LOG = logging.getLogger("duet.tests.mishaps")


class Clock:
    """A clock that is set by hand."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


def raised(kind: type[Exception] = ValueError, text: str = "") -> Exception:
    """An exception as it is caught: always from the same place."""
    try:
        raise kind(text)
    except Exception as error:
        return error


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def mishaps(clock: Clock) -> ThrottledLog:
    return ThrottledLog(LOG, clock)


def lines(caplog: pytest.LogCaptureFixture) -> list[str]:
    """What was logged since the last look."""
    said = [record.getMessage() for record in caplog.records]
    caplog.clear()
    return said


def test_a_failure_of_every_frame_is_logged_once_and_then_counted(
    mishaps: ThrottledLog, clock: Clock, caplog: pytest.LogCaptureFixture
) -> None:
    mishaps.tell("a frame failed", raised(text="at 1 s"), 7)
    assert caplog.records[0].exc_info is not None and "at 1 s" in caplog.text
    caplog.clear()
    # Twenty minutes and more at 32 frames a second; the numbers in the message change, the place does not.
    said: list[tuple[float, str]] = []
    for frame in range(1, 1300 * 32 + 1):
        clock.now = frame / 32.0
        mishaps.tell("a frame failed", raised(text=f"at {clock.now} s"), 7)
        said += [(clock.now, line) for line in lines(caplog)]
    times = [time for time, _ in said]
    assert times == [10.0, 70.0, 670.0, 1270.0]
    assert said[0][1] == "a frame failed: 320 times more in 10 s (ValueError)"
    assert said[1][1] == "a frame failed: 1920 times more in 60 s (ValueError)"
    assert INTERVALS == (10.0, 60.0, 600.0)


@pytest.mark.parametrize(
    "other",
    [
        lambda m: m.tell("a frame failed", raised(), 8),
        lambda m: m.tell("a frame failed", raised(KeyError), 7),
        lambda m: m.tell("a frame failed", ValueError("from elsewhere"), 7),
        lambda m: m.tell("the numbers failed", raised(), 7),
    ],
    ids=["somebody else's", "another class", "another place", "something else failed"],
)
def test_another_failure_is_news(
    mishaps: ThrottledLog, caplog: pytest.LogCaptureFixture, other: Callable[[ThrottledLog], None]
) -> None:
    mishaps.tell("a frame failed", raised(), 7)
    assert len(lines(caplog)) == 1
    other(mishaps)
    assert len(lines(caplog)) == 1
    mishaps.tell("a frame failed", raised(), 7)
    other(mishaps)
    assert lines(caplog) == []


def test_what_happens_to_the_next_one_is_news(mishaps: ThrottledLog, caplog: pytest.LogCaptureFixture) -> None:
    for _ in range(2):
        mishaps.tell("a frame failed", raised(), 7)
        mishaps.tell("a frame failed", raised(), 8)
    assert len(lines(caplog)) == 2
    mishaps.forget(7)
    mishaps.tell("a frame failed", raised(), 7)
    mishaps.tell("a frame failed", raised(), 8)
    assert len(lines(caplog)) == 1


def test_a_page_that_fails_at_every_frame_does_not_fill_the_log(house: OpenHouse, caplog: pytest.LogCaptureFixture) -> None:
    opened = house()
    frames = 0

    def fail(*_: Any) -> None:
        nonlocal frames
        frames += 1
        raise RuntimeError(f"frame {frames}")

    with BlockingClient(opened.url) as visitor:
        visitor.wait_for(lambda _: visitor.mirror.replayed)
        host = opened.host
        assert isinstance(host, PrivateHost)
        visitor.wait_for(lambda _: len(host.sessions) == 1)
        (stand,) = host.visitors.values()
        ask(stand.session, lambda _: setattr(stand, "frame", fail))
        visitor.wait_for(lambda _: frames > 5)
        # What a busy machine takes for it may be ten seconds, and then there is a count.
        said = [line for line in lines(caplog) if line.startswith("a frame of a visitor's page failed")]
        assert said[0] == "a frame of a visitor's page failed" and len(said) < 3


def test_a_lesson_that_fails_at_every_frame_is_told_once_a_run(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    session = Session(Settings())
    run = LessonSession(session, load_lessons())
    run.enter(0)

    def fail(_: Any) -> None:
        raise RuntimeError

    monkeypatch.setattr(run.walk, "watch", fail)
    monkeypatch.setattr(run.walk, "live", fail)
    for _ in range(5):
        run.frame()
        assert run.live() == ()
    assert len(lines(caplog)) == 2
    assert [title for title, _ in run.notes] == ["The lesson stopped here"]
    run.act("reset")
    run.frame()
    assert len(run.notes) == 2
