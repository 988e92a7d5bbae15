"""A visitor's clock never loses, repeats or reorders a step; reasons of a pause; resets."""

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import MonkeyPatch

from app.session import run_control
from app.session.actions import Action, Pause, SetSetting, SingleStep
from app.session.clock import (
    BUDGET,
    LEAST,
    LONGEST_GAP,
    SLOWEST,
    SPEEDS,
    TOGETHER,
    Clock,
    budget_of,
    next_speed,
)
from app.session.run_control import RunControl
from app.session.session import Session
from app.session.session_state import state_of
from app.settings import Settings
from scenes.targets import HandTarget
from tests.app.session.conftest import DT, bits, go, slow_down


@given(st.lists(st.floats(0.0, LONGEST_GAP), min_size=1, max_size=50), st.sampled_from(SPEEDS))
def test_no_step_is_lost_for_any_frame_lengths(frames: list[float], speed: float) -> None:
    clock, made = Clock(speed), 0
    for elapsed in frames:
        due = clock.due(elapsed, DT, speed)
        clock.note(due, due, elapsed, DT)
        made += due
    assert abs(made * DT - sum(frames) * speed) < DT + 1e-6
    assert not clock.pace(False).slowed


def test_frame_lengths_do_not_affect_the_arms(session: Session) -> None:
    other = Session(Settings())
    # Remainders add up: after 12 ms two steps are made, and 2 ms remain.
    assert [session.advance(elapsed) for elapsed in (0.1, 0.012, 0.003, 0.0049, 0.0001)] == [20, 2, 1, 0, 1]
    assert session.simulation.time == pytest.approx(24 * DT)
    for _ in range(22):
        session.advance(0.04)
    for elapsed in (0.007, 0.043, 0.0321, 0.0179) * 10:
        other.advance(elapsed)
    assert session.simulation.steps == other.simulation.steps == 200
    assert bits(session) == bits(other)


def test_nothing_moves_in_a_pause_and_no_time_is_made_up_later(session: Session) -> None:
    session.advance(0.0349)  # 4.9 ms remain
    before = session.simulation.positions.tobytes(), session.simulation.steps
    session.control.toggle_pause()
    assert session.pace.paused and session.pace.rate == 0.0
    assert [session.advance(0.05) for _ in range(5)] == [0] * 5
    assert (session.simulation.positions.tobytes(), session.simulation.steps) == before
    session.control.toggle_pause()
    assert not session.pace.paused
    assert session.advance(0.0001) == 0
    assert session.advance(0.05) == 10
    # A reset keeps the pause.
    session.control.toggle_pause()
    session.reset()
    assert session.paused and session.advance(0.1) == 0 and session.simulation.steps == 0
    session.control.toggle_pause()
    assert session.advance(0.1) == 20


def test_single_steps(session: Session) -> None:
    session.advance(0.05)
    session.control.single_step()
    assert session.paused and session.advance(0.5) == 1 and session.advance(0.5) == 0
    session.control.single_step()
    session.control.single_step()
    assert session.advance(0.0) == 2
    assert session.simulation.steps == 13
    # Single steps equal the steps of a moving run.
    straight = Session(Settings())
    straight.advance(13 * DT)
    assert bits(session) == bits(straight)
    # A step and a continuation in one frame: the step is not made later.
    session.control.single_step()
    session.control.toggle_pause()
    assert session.advance(0.05) == 10
    session.control.toggle_pause()
    assert session.advance(0.05) == 0
    session.control.single_step()
    assert session.advance(0.05) == 1


@pytest.mark.parametrize("speed", SPEEDS)
def test_the_run_has_the_chosen_speed(session: Session, speed: float) -> None:
    session.change("speed", speed)
    assert session.advance(0.08) == round(0.08 * speed / DT)
    for _ in range(60):
        session.advance(0.03)
    assert session.pace.rate == pytest.approx(speed, rel=0.1) and not session.pace.slowed


@pytest.mark.parametrize(
    ("speed", "by", "then"),
    [
        (1.0, -1, 0.5),
        (1.0, 1, 2.0),
        (2.0, 1, 2.0),
        (0.25, -1, 0.25),
        (0.8, 1, 2.0),
        (0.3, 0, 0.25),
        (1.75, -1, 1.0),
    ],
)
def test_slower_and_faster_stop_at_the_limits(session: Session, speed: float, by: int, then: float) -> None:
    session.change("speed", speed)
    session.change("speed", next_speed(session.settings.page.speed, by))
    assert session.settings.page.speed == then


def test_a_slow_machine_slows_the_run_down_and_reports_it(session: Session, monkeypatch: MonkeyPatch) -> None:
    cost = [BUDGET / 2]
    slow_down(monkeypatch, session.simulation, cost)
    made = [session.advance(0.08) for _ in range(20)]
    assert all(0 < count < 16 for count in made)
    assert session.pace.slowed and session.pace.rate < 0.9
    table = session.simulation.history.table()
    assert len(table) == sum(made) == session.simulation.steps
    assert np.allclose(np.diff(table[:, 0]), DT)
    # Missed steps are not made up, and a recovered machine is no longer reported as slow.
    cost[0] = 0.0
    assert session.advance(0.08) == 16
    for _ in range(20):
        session.advance(0.08)
    assert not session.pace.slowed and session.pace.rate == pytest.approx(1.0, abs=0.1)


def test_many_sessions_share_the_time_for_their_steps(session: Session, monkeypatch: MonkeyPatch) -> None:
    assert budget_of(0) == budget_of(1) == BUDGET
    assert all(sessions * budget_of(sessions) <= TOGETHER * BUDGET + 1e-12 for sessions in range(1, 41))
    # Drawing gets its time, until the steps would get almost none.
    assert 10 * budget_of(10, 0.02) == pytest.approx(SLOWEST - 0.02) and 10 * budget_of(
        10, 0.3
    ) == pytest.approx(LEAST)
    assert 10 * budget_of(10, 0.005) == pytest.approx(TOGETHER * BUDGET)
    clock = itertools.count(0.0, BUDGET / 50.0)
    monkeypatch.setattr(run_control, "perf_counter", lambda: next(clock))
    assert session.advance(LONGEST_GAP) == 20 and session.control.stepping == pytest.approx(
        20 * BUDGET / 50.0
    )
    # Each session makes at least one step, for any number of sessions.
    assert session.advance(LONGEST_GAP, budget_of(TOGETHER * 20)) == 3
    assert session.advance(LONGEST_GAP, budget_of(TOGETHER * 1000)) == 1
    session.control.toggle_pause()
    session.advance(LONGEST_GAP)
    assert session.control.stepping == 0.0


def test_slower_than_real_time_is_reported_without_flicker() -> None:
    clock, said = Clock(1.0), []
    for late in [True] * 40 + [False, True] * 60 + [False] * 100 + [True, False, False, False] * 30:
        clock.note(0 if late else 6, 6, 1.0 / 32.0, DT)
        said.append(clock.pace(False).slowed)
    # The report stays while every second frame is late; it does not appear if every fourth one is.
    assert [said[0], *(now for before, now in itertools.pairwise(said) if now != before)] == [
        False,
        True,
        False,
    ]
    assert not said[10] and all(said[40:160]) and not any(said[230:])


@pytest.mark.parametrize("gap", [LONGEST_GAP * 1.01, 3.0, 86_400.0])
def test_a_long_gap_is_not_made_up(session: Session, gap: float) -> None:
    assert session.advance(gap) == round(LONGEST_GAP / DT)
    assert session.advance(0.01) == 2


def test_a_step_longer_than_a_frame_is_made_in_later_frames(session: Session) -> None:
    session.change("dt", 0.02)
    assert [session.advance(0.008) for _ in range(5)] == [0, 0, 1, 0, 1]


def test_a_hurried_run_has_the_same_bits_and_continues_at_its_speed(session: Session) -> None:
    other = Session(Settings())
    session.control.halt.set("visitor")
    session.control.hurry(3.0)
    while session.simulation.time < 3.0 - DT / 2:
        assert session.advance(0.0) > 0
    assert session.simulation.steps == round(3.0 / DT) and not session.paused
    go(other, 3.0)
    assert bits(session) == bits(other)
    assert session.advance(0.1) == 20


@pytest.mark.parametrize("end", ["pause", "halt", "reset"])
def test_a_paused_or_restarted_run_no_longer_hurries(
    session: Session, end: str, monkeypatch: MonkeyPatch
) -> None:
    # Each reading of the clock uses up a frame's budget.
    looks = itertools.count()
    monkeypatch.setattr(run_control, "perf_counter", lambda: 2.0 * BUDGET * next(looks))
    session.control.hurry(3.0)
    assert session.advance(0.0) == 1 and session.advance(0.0) == 1
    teacher = (
        lambda: session.control.halt.set("teacher"),
        lambda: session.control.halt.set("teacher", False),
    )
    for act in {"pause": (session.control.toggle_pause,) * 2, "halt": teacher, "reset": (session.reset,)}[
        end
    ]:
        act()
        assert session.advance(0.0) == 0


def test_a_hidden_run_pauses_and_continues_its_hurry_later(session: Session) -> None:
    session.advance(0.05)
    for reason in ("visitor", "hidden", "teacher"):
        session.control.halt.set(reason)
    session.control.hurry(1.0)
    # The reasons that a visitor cannot remove stay.
    assert session.control.halt == {"hidden", "teacher"}
    session.control.halt.set("teacher", False)
    assert session.paused and [session.advance(0.5) for _ in range(5)] == [0] * 5
    session.control.halt.set("hidden", False)
    assert not session.paused
    while session.simulation.time < 1.0 - DT / 2:
        assert session.advance(0.0) > 0
    assert state_of(session).halted == ()


Ask = Callable[[RunControl], None]


@pytest.mark.parametrize(
    ("ask", "action"),
    [(RunControl.single_step, SingleStep()), (RunControl.toggle_pause, Pause())],
    ids=["a single step", "go on"],
)
@pytest.mark.parametrize("posted", [True, False], ids=["by the page", "before the frame"])
@pytest.mark.parametrize("paused", [True, False], ids=["paused before", "running before"])
def test_no_step_is_made_while_the_teacher_halts_the_run(
    session: Session, ask: Ask, action: Action, posted: bool, paused: bool
) -> None:
    session.advance(0.05)
    before = session.simulation.steps
    session.control.halt.set("visitor", paused)
    session.control.halt.set("teacher")
    for _ in range(3):
        if posted:
            session.post(action)
        else:
            ask(session.control)
        assert session.advance(0.05) == 0
    session.post(SetSetting("dm", 0.2))
    session.advance(0.05)
    assert session.settings.run.law.critical_distance == 0.2, "a setting was not changed"
    assert session.paused and session.simulation.steps == before
    session.control.halt.set("teacher", False)
    assert session.paused == paused and session.advance(0.0) == 0
    session.control.single_step()
    assert session.advance(0.0) == 1
    session.control.toggle_pause()
    assert session.advance(0.05) > 1


CHANGES = [{}, {"guided": "left"}, {"rig": "table", "law": "unprotected"}, {"dt": 0.01, "autopilot": False}]


@pytest.mark.parametrize("change", CHANGES)
def test_a_reset_run_equals_a_new_one_to_the_last_bit(session: Session, change: dict[str, Any]) -> None:
    session.advance(0.0349)
    session.hand.hold(HandTarget(np.array([0.3, 0.1, 0.9])))
    session.advance(0.1)
    for key, value in {"autopilot": True, **change}.items():
        session.change(key, value)
    go(session, 3.0)
    session.reset()
    fresh = Session(session.settings)
    assert session.simulation.time == 0.0 and session.simulation.history.count == 0 and session.held is None
    for elapsed in (0.033, 0.041, 0.1, 0.07) * 8:
        assert session.advance(elapsed) == fresh.advance(elapsed)
    assert bits(session) == bits(fresh)
    assert session.simulation.history.count > 100
