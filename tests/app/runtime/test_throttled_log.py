"""A frequent event is logged once, and then as a count at intervals."""

import logging
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from app.runtime.throttled_log import EVER_RARER, ThrottledLog
from tests.app.conftest import OpenHouse, ask, live_sessions, visitor_of
from tests.approved import Approve
from tests.blocking_client import BlockingClient

LOG = logging.getLogger("duet.tests.throttled")
FRAMES = 32  # per second
Caplog = pytest.LogCaptureFixture


def raised(kind: type[Exception] = ValueError, text: str = "") -> Exception:
    """A caught exception, always from the same place."""
    try:
        raise kind(text)
    except Exception as error:
        return error


@pytest.fixture
def clock() -> SimpleNamespace:
    return SimpleNamespace(now=0.0)


@pytest.fixture
def throttled(clock: SimpleNamespace) -> ThrottledLog:
    return ThrottledLog(LOG, clock=lambda: clock.now)


def lines(caplog: pytest.LogCaptureFixture) -> list[str]:
    logged = [record.getMessage() for record in caplog.records]
    caplog.clear()
    return logged


def over_time(
    clock: SimpleNamespace, seconds: int, caplog: Caplog, event: Callable[[], None]
) -> list[tuple[float, str]]:
    """Times and lines that an event in every frame logs."""
    logged: list[tuple[float, str]] = []
    for frame in range(1, seconds * FRAMES + 1):
        clock.now = frame / FRAMES
        event()
        logged += [(clock.now, line) for line in lines(caplog)]
    return logged


def log_text(logged: list[tuple[float, str]]) -> str:
    """Lines of a log with their times, as a text."""
    return "".join(f"{time:g} s: {line}\n" for time, line in logged)


def test_an_exception_of_every_frame_is_logged_once_and_counted(
    throttled: ThrottledLog, clock: SimpleNamespace, caplog: Caplog, approve: Approve
) -> None:
    throttled.exception("a frame failed", raised(text="at 1 s"), 7)
    assert caplog.records[0].exc_info is not None and "at 1 s" in caplog.text
    caplog.clear()
    # The message changes, the place does not.
    logged = over_time(
        clock,
        1300,
        caplog,
        lambda: throttled.exception("a frame failed", raised(text=f"at {clock.now} s"), 7),
    )
    assert [time for time, _ in logged] == [10.0, 70.0, 670.0, 1270.0] and EVER_RARER == (10.0, 60.0, 600.0)
    approve("exceptions.txt", log_text(logged))


def test_a_warning_has_one_line_per_kind_and_interval(
    clock: SimpleNamespace, caplog: pytest.LogCaptureFixture, approve: Approve
) -> None:
    throttled = ThrottledLog(LOG, (10.0,), lambda: clock.now)
    throttled.warning("slowed down", "client 1")
    throttled.warning("refused origin", "evil.example")
    logged = [(0.0, line) for line in lines(caplog)]
    logged += over_time(clock, 35, caplog, lambda: throttled.warning("slowed down", "client 2"))
    clock.now = 100.0
    throttled.warning("refused origin", "evil.example")
    approve("warnings.txt", log_text([*logged, *((100.0, line) for line in lines(caplog))]))


@pytest.mark.parametrize(
    "other",
    [
        lambda log: log.exception("a frame failed", raised(), 8),
        lambda log: log.exception("a frame failed", raised(KeyError), 7),
        lambda log: log.exception("a frame failed", ValueError("from elsewhere"), 7),
        lambda log: log.exception("the numbers failed", raised(), 7),
    ],
    ids=["another source", "another class", "another place", "another line"],
)
def test_another_exception_is_logged_as_new(
    throttled: ThrottledLog, caplog: Caplog, other: Callable[[ThrottledLog], None]
) -> None:
    counts: list[int] = []
    for _ in range(2):
        throttled.exception("a frame failed", raised(), 7)
        counts.append(len(lines(caplog)))
        other(throttled)
        counts.append(len(lines(caplog)))
    # A forgotten source is new.
    throttled.forget(7)
    throttled.exception("a frame failed", raised(), 7)
    assert [*counts, len(lines(caplog))] == [1, 1, 0, 0, 1]


def test_a_page_that_fails_in_every_frame_does_not_fill_the_log(
    house: OpenHouse, caplog: pytest.LogCaptureFixture, approve: Approve
) -> None:
    opened = house()
    frames = 0

    def fail(*_: Any) -> None:
        nonlocal frames
        frames += 1
        raise RuntimeError(f"frame {frames}")

    with BlockingClient(opened.url) as visitor:
        visitor.wait_for(lambda _: visitor.mirror.replayed)
        visitor.wait_for(lambda _: len(live_sessions(opened)) == 1)
        stand = visitor_of(opened)
        ask(stand.session, lambda _: setattr(stand, "frame", fail))
        visitor.wait_for(lambda _: frames > 5)
        # A busy machine may need 10 s, so that a count is logged, too.
        logged = [line for line in lines(caplog) if line.startswith("a frame of ")]
        approve("page.txt", f"{logged[0]}\n")
        assert len(logged) < 3
