"""A clock owes steps, forgets what could not be made in time, and knows how fast time goes."""

from itertools import count

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.session import session as session_module
from app.session.clock import BUDGET, LONGEST_GAP, SPEEDS, TOGETHER, Clock, budget_of, next_speed
from app.session.session import Session

DT = 0.005


@given(st.lists(st.floats(0.0, LONGEST_GAP), min_size=1, max_size=50), st.sampled_from(SPEEDS))
def test_no_step_is_lost_however_frames_are_cut(frames: list[float], speed: float) -> None:
    clock, made = Clock(speed), 0
    for elapsed in frames:
        due = clock.due(elapsed, DT, speed)
        clock.note(due, due, elapsed, DT)
        made += due
    assert abs(made * DT - sum(frames) * speed) < DT + 1e-6
    assert not clock.pace(False).slowed


def test_what_could_not_be_made_is_not_owed() -> None:
    clock = Clock(1.0)
    assert clock.due(0.1, DT, 1.0) == 20
    clock.note(8, 20, 0.1, DT)
    assert clock.due(0.0, DT, 1.0) == 0
    # A closed laptop is not caught up.
    assert clock.due(3600.0, DT, 1.0) == round(LONGEST_GAP / DT)
    clock.forget()
    assert clock.due(0.0, DT, 1.0) == 0


def test_the_pace_tells_a_machine_that_cannot_keep_up() -> None:
    clock = Clock(1.0)
    for _ in range(100):
        due = clock.due(0.05, DT, 1.0)
        clock.note(due // 2, due, 0.05, DT)
    pace = clock.pace(False)
    assert pace.slowed and pace.rate == pytest.approx(0.5, abs=0.01)
    assert clock.pace(True).rate == 0.0 and clock.pace(True).paused
    for _ in range(100):
        due = clock.due(0.05, DT, 1.0)
        clock.note(due, due, 0.05, DT)
    assert not clock.pace(False).slowed and clock.pace(False).rate == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(
    ("speed", "by", "then"), [(1.0, -1, 0.5), (1.0, 1, 2.0), (2.0, 1, 2.0), (0.25, -1, 0.25), (0.8, 1, 2.0), (0.3, 0, 0.25)]
)
def test_speeds_end_at_both_ends(speed: float, by: int, then: float) -> None:
    assert next_speed(speed, by) == then


def test_many_sessions_share_the_time_for_their_steps(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    assert budget_of(0) == budget_of(1) == BUDGET
    assert all(sessions * budget_of(sessions) <= TOGETHER * BUDGET + 1e-12 for sessions in range(1, 41))
    # Eight steps take a fifth of the budget here.
    clock = count(0.0, BUDGET / 5.0)
    monkeypatch.setattr(session_module, "perf_counter", lambda: next(clock))
    assert session.advance(LONGEST_GAP) == 20
    assert session.advance(LONGEST_GAP, budget_of(TOGETHER * 20)) == 8
