"""One visitor's clock: it runs with the wall, but never loses, repeats or reorders a step."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from app import session as session_module
from app.clock import BUDGET, LONGEST_GAP, SPEEDS
from app.session import Session
from app.settings import PageSettings, Settings
from controllers.errors import BadSetting
from scenes.headless import run
from scenes.inputs import RecordedPerson
from scenes.rerun import rerun
from scenes.room import BALL_ROOM, Room
from scenes.settings import RunSettings, specs, values
from scenes.targets import AnglesTarget, BallTarget, HandTarget, JointTarget, Target

DT = RunSettings().dt
SPECS = specs(Settings)


@pytest.fixture(autouse=True)
def fast_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """However busy this machine is, no step takes any time."""
    monkeypatch.setattr(session_module, "perf_counter", lambda: 0.0)


@pytest.fixture
def session() -> Session:
    """A session with the default settings, at its start."""
    return Session(Settings())


def bits(session: Session) -> bytes:
    """Everything that happened, to the last bit."""
    return session.simulation.history.table().tobytes()


def another(key: str, present: Any) -> Any:
    """A possible value that differs from the present one."""
    spec = SPECS[key]
    if spec.choices:
        return spec.choices[spec.choices.index(present) - 1]
    if isinstance(present, bool):
        return not present
    value = spec.low + (spec.high - spec.low) / (3 if present != spec.low + (spec.high - spec.low) / 3 else 2)
    return int(value) if isinstance(present, int) else value


# --- the clock -----------------------------------------------------------------------------------------------------------------


def test_time_goes_with_the_wall_and_remainders_add_up(session: Session) -> None:
    assert session.advance(0.1) == 20
    assert session.advance(0.012) == 2
    assert session.advance(0.003) == 1  # 2 ms were owed
    assert session.advance(0.0049) == 0
    assert session.advance(0.0001) == 1
    assert session.simulation.steps == 24
    assert session.simulation.time == pytest.approx(24 * DT)


def test_how_frames_are_cut_does_not_reach_the_arms(session: Session) -> None:
    other = Session(Settings())
    for _ in range(20):
        session.advance(0.05)
    for elapsed in (0.007, 0.043, 0.0321, 0.0179) * 10:
        other.advance(elapsed)
    assert session.simulation.steps == other.simulation.steps == 200
    assert bits(session) == bits(other)


def test_nothing_moves_while_paused_and_no_time_is_owed_afterwards(session: Session) -> None:
    session.advance(0.0349)  # 4.9 ms are owed
    before, steps = session.simulation.positions.copy(), session.simulation.steps
    session.toggle_pause()
    assert session.pace.paused and session.pace.rate == 0.0
    assert [session.advance(0.05) for _ in range(5)] == [0] * 5
    assert session.simulation.positions.tobytes() == before.tobytes() and session.simulation.steps == steps
    session.toggle_pause()
    assert not session.pace.paused
    assert session.advance(0.0001) == 0
    assert session.advance(0.05) == 10


def test_single_steps(session: Session) -> None:
    session.advance(0.05)
    session.single_step()
    assert session.paused and session.advance(0.5) == 1 and session.advance(0.5) == 0
    session.single_step()
    session.single_step()
    assert session.advance(0.0) == 2
    assert session.simulation.steps == 13
    # A step is a step, whoever asked for it.
    straight = Session(Settings())
    straight.advance(13 * DT)
    assert bits(session) == bits(straight)


def test_a_step_that_was_overtaken_by_going_on_is_not_made_later(session: Session) -> None:
    session.single_step()
    session.toggle_pause()  # both keys in one frame
    assert session.advance(0.05) == 10
    session.toggle_pause()
    assert session.advance(0.05) == 0
    session.single_step()
    assert session.advance(0.05) == 1


@pytest.mark.parametrize("speed", SPEEDS)
def test_speeds(session: Session, speed: float) -> None:
    session.change("speed", speed)
    assert session.advance(0.08) == round(0.08 * speed / DT)


def test_slower_and_faster_stop_at_the_ends(session: Session) -> None:
    seen = [session.settings.page.speed]
    for by in (1, 1, -1, -1, -1, -1):
        session.change_speed(by)
        seen.append(session.settings.page.speed)
    assert seen == [1.0, 2.0, 2.0, 1.0, 0.5, 0.25, 0.25]
    session.change("speed", 1.75)
    session.change_speed(-1)
    assert session.settings.page.speed == 1.0


def test_rate_tells_the_speed(session: Session) -> None:
    session.change("speed", 0.5)
    for _ in range(60):
        session.advance(0.03)
    assert session.pace.rate == pytest.approx(0.5, abs=0.05)
    assert not session.pace.slowed


def test_a_machine_that_cannot_keep_up_slows_down_and_says_so(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    clock, cost = [0.0], [BUDGET / 2]
    monkeypatch.setattr(session_module, "perf_counter", lambda: clock[0])
    real: Callable[[Target | None], None] = session.simulation.step

    def slow(target: Target | None) -> None:
        clock[0] += cost[0]
        real(target)

    monkeypatch.setattr(session.simulation, "step", slow)
    made = [session.advance(0.08) for _ in range(20)]
    assert all(0 < count < 16 for count in made)
    assert session.pace.slowed and session.pace.rate < 0.9
    # Slow, but every step is there, at its time and with its size.
    table = session.simulation.history.table()
    assert len(table) == sum(made) == session.simulation.steps
    assert np.allclose(np.diff(table[:, 0]), DT)
    # What was missed is not owed, and a machine that recovers is no longer called slow.
    cost[0] = 0.0
    assert session.advance(0.08) == 16
    for _ in range(20):
        session.advance(0.08)
    assert not session.pace.slowed and session.pace.rate == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("gap", [LONGEST_GAP * 1.01, 3.0, 86_400.0])
def test_a_long_gap_is_not_caught_up(session: Session, gap: float) -> None:
    assert session.advance(gap) == round(LONGEST_GAP / DT)
    assert session.advance(0.01) == 2


def test_a_step_longer_than_a_frame_is_saved_up_for(session: Session) -> None:
    session.change("dt", 0.02)
    assert [session.advance(0.008) for _ in range(5)] == [0, 0, 1, 0, 1]


# --- settings ------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("key", [key for key in SPECS if key not in ("scene", "rig", "robot")])
def test_a_change_moves_nothing_by_itself(session: Session, key: str) -> None:
    for _ in range(30):
        session.advance(0.1)
    simulation, before = session.simulation, session.simulation.positions.copy()
    present, steps = values(session.settings), simulation.steps
    session.change(key, another(key, present[key]))
    after = values(session.settings)
    assert [k for k in present if present[k] != after[k]] == [key]
    assert simulation.positions.tobytes() == before.tobytes() and simulation.steps == steps
    assert simulation.settings == session.settings.run
    # And no jump afterwards either.
    session.advance(0.05)
    assert simulation.steps > steps
    moves = np.abs(np.diff(simulation.history.positions(simulation.history.table()), axis=0))
    assert (moves <= simulation.room.model.velocityLimit * 0.02 + 1e-12).all()


def test_a_change_acts_in_the_next_step(session: Session) -> None:
    session.advance(0.05)
    assert session.simulation.sample().activation < 0.9
    session.change("dm", 0.30)
    session.advance(DT)
    law, sample = session.simulation.law, session.simulation.sample()
    assert sample.activation == law.activation(sample.law_distance)
    assert law.activation(0.29) == 1.0


def test_another_rig_is_a_fresh_start_there(session: Session) -> None:
    session.advance(0.1)
    session.hold(HandTarget(np.zeros(3)))
    session.change("rig", "table")
    fresh = Session(session.settings)
    assert session.held is None
    assert session.simulation.positions.tobytes() == fresh.simulation.positions.tobytes()
    for s in (session, fresh):
        s.change("autopilot", False)
        s.change("autopilot", True)
        s.reset()
        s.advance(0.1)
    assert bits(session) == bits(fresh)


def test_a_robot_that_is_not_there_changes_nothing(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(settings: RunSettings) -> Room:
        raise BadSetting(f"{settings.robot} needs a package that is not installed.")

    session.advance(0.1)
    session.hold(HandTarget(np.array([0.4, 0.1, 1.0])))
    before, room = session.settings, session.simulation.room
    monkeypatch.setattr(session_module, "room_of", missing)
    with pytest.raises(BadSetting, match="panda needs"):
        session.change("robot", "panda")
    assert session.settings is before and session.simulation.settings is before.run and session.simulation.room is room
    assert session.held is not None
    assert session.advance(0.1) == 20


BAD: list[tuple[str, Any]] = [
    *((key, bad) for key in SPECS for bad in (math.nan, None, [], "nonsense")),
    *(
        (key, bad)
        for key, spec in SPECS.items()
        if math.isfinite(spec.low)
        for bad in (math.inf, -math.inf, 1e9, -1e9, True, spec.high + 0.5, spec.low - 0.5)
    ),
    ("seed", 1.5),
    ("nothing", 1),
]


@pytest.mark.parametrize(("key", "value"), BAD)
def test_an_impossible_value_leaves_everything(key: str, value: Any) -> None:
    session = _shared
    before = session.settings
    with pytest.raises(BadSetting, match=key):
        session.change(key, value)
    assert session.settings is before and session.simulation.settings is before.run


_shared = Session(Settings())


# --- who moves the arm ---------------------------------------------------------------------------------------------------------


def test_taking_hold_switches_the_autopilot_off_at_once(session: Session) -> None:
    session.advance(0.5)
    assert session.settings.page.autopilot and session.target() is not None
    place = HandTarget(np.array([0.4, 0.1, 1.0]))
    session.hold(place)
    assert not session.settings.page.autopilot and session.target() is place
    session.hold(None)
    assert not session.settings.page.autopilot and session.target() is None


def test_autopilot_begins_where_the_hand_is(session: Session) -> None:
    session.change("autopilot", False)
    hand = session.simulation.kinematics.hand_pose(session.simulation.guided).translation.copy()
    session.hold(HandTarget(hand + np.array([0.0, 0.0, 0.1])))
    for _ in range(10):
        session.advance(0.1)
    session.hold(None)
    simulation = session.simulation
    now = simulation.kinematics.hand_pose(simulation.guided).translation.copy()
    assert np.linalg.norm(now - hand) > 0.05
    session.change("autopilot", True)
    target = session.target()
    assert isinstance(target, HandTarget) and np.linalg.norm(target.position - now) < 2e-3


PEOPLE: dict[str, type] = {
    "solo": HandTarget,
    "ball": BallTarget,
    "hold": HandTarget,
    "master_slave": HandTarget,
    "imitation": AnglesTarget,
}


@pytest.mark.parametrize("scene", PEOPLE)
def test_every_experiment_has_a_person_of_its_own(session: Session, scene: str) -> None:
    session.advance(0.1)
    session.change("scene", scene)
    session.change("ball", "cross")
    assert isinstance(session.target(), PEOPLE[scene])
    q = session.simulation.positions.copy()
    for _ in range(10):
        session.advance(0.1)
    assert np.abs(session.simulation.positions - q).max() > 0.002
    # The same person as that of a run without a page, from the first step on.
    session.reset()
    for _ in range(5):
        session.advance(0.1)
    again = run(session.settings.run, 0.5)
    assert bits(session) == again.table.tobytes()


@pytest.mark.parametrize(
    "target",
    [
        HandTarget(np.array([0.4, 0.1, 1.0])),
        JointTarget(np.zeros(7)),
        BallTarget(np.array([0.4, 0.1, 1.0])),
        AnglesTarget(np.zeros((2, 4))),
    ],
    ids=lambda target: type(target).__name__,
)
def test_whatever_is_taken_hold_of_takes_over_at_once(session: Session, target: Target) -> None:
    session.advance(0.1)
    session.hold(target)
    assert not session.settings.page.autopilot and session.target() is target
    session.advance(0.1)
    recorded = session.recorded()
    assert recorded is not None
    assert [type(t) for t in recorded.targets()][-20:] == [type(target)] * 20


CHANGES: list[tuple[str, Any]] = [
    *(("scene", "solo"), ("rig", "table"), ("guided", "left"), ("path", "circle"), ("point", "arm"), ("ball", "cross")),
    *(("clip", "wave"), ("seed", 7), ("source", "figure")),
]


@pytest.mark.parametrize(("key", "value"), CHANGES)
def test_another_person_or_place_begins_anew(session: Session, key: str, value: Any) -> None:
    session.advance(0.1)
    first = session.target()
    session.change("dm", 0.12)
    session.change("law", "barrier_qp")
    kept = session.target()
    assert isinstance(first, HandTarget) and isinstance(kept, HandTarget)
    assert kept.position.tolist() == first.position.tolist()
    session.hold(HandTarget(np.zeros(3)))
    session.change("k", 3.0)
    assert session.held is not None
    session.change(key, value)
    assert session.held is None and session.target() is None
    session.change("autopilot", True)
    person = session.simulation.person().target(0.0)
    mine = session.target()
    assert type(mine) is type(person)
    if mine is not None and person is not None:
        assert all(x is y is None or (x == y).all() for x, y in zip(mine, person, strict=True))


class Pointer:
    """A person who points at one place after the other, and notes when they were asked."""

    def __init__(self) -> None:
        self.asked: list[float] = []

    def target(self, time: float) -> HandTarget:
        """Return a place that tells the time."""
        self.asked.append(time)
        return HandTarget(np.array([0.4, 0.1, 1.0 + time]))


def test_somebody_else_may_be_invited(session: Session) -> None:
    session.advance(0.1)
    session.hold(HandTarget(np.zeros(3)))
    session.advance(0.1)
    guest = Pointer()
    session.invite(guest)
    assert session.held is None and session.settings.page.autopilot
    session.advance(0.1)
    assert np.allclose(guest.asked, np.arange(20) * DT)
    # Whoever takes hold goes first; the guest then begins again from the beginning, like the autopilot.
    session.hold(HandTarget(np.zeros(3)))
    session.advance(0.1)
    assert len(guest.asked) == 20
    session.hold(None)
    session.change("autopilot", True)
    session.advance(2.0 * DT)
    assert np.allclose(guest.asked[20:], [0.0, DT])
    session.reset()
    session.advance(DT)
    assert guest.asked[-1] == 0.0
    session.invite(None)
    assert isinstance(session.simulation.person().target(0.0), HandTarget)
    session.advance(DT)
    assert len(guest.asked) == 23
    session.invite(guest)
    session.change("source", "camera")
    session.advance(DT)
    assert len(guest.asked) == 23


def test_a_recorded_run_can_be_played_again(session: Session) -> None:
    for _ in range(12):
        session.advance(0.1)
    recorded = session.recorded()
    assert recorded is not None and recorded.steps == 240
    before = bits(session)
    session.reset()
    session.change("seed", 9)
    session.invite(RecordedPerson(recorded))
    for _ in range(12):
        session.advance(0.1)
    assert bits(session) == before


def test_what_is_recorded_can_be_made_again_to_the_last_bit(session: Session) -> None:
    for i in range(40):
        session.advance(0.08)
        if i == 10:
            session.change("dm", 0.2)
        if i == 20:
            session.hold(HandTarget(np.array([0.4, 0.1, 1.0]), np.eye(3).T, np.array([0.2, -0.4, 1.0])))
        if i == 30:
            session.toggle_pause()
            session.single_step()
        if i == 35:
            session.toggle_pause()
    for seconds in (1.0, 2.0, 99.0):
        recorded = session.recorded(seconds)
        assert recorded is not None
        table = session.simulation.history.table(recorded.steps)
        assert rerun(recorded).table.tobytes() == table.tobytes()
    session.reset()
    assert session.recorded() is None or session.advance(DT) == 1
    again = session.recorded()
    assert again is None or again.steps == 1


def test_nudges_add_up_but_do_not_run_away(session: Session) -> None:
    simulation = session.simulation
    hand = simulation.kinematics.hand_pose(simulation.guided).translation.copy()
    session.nudge(np.array([0.0, 0.0, 0.02]))
    assert isinstance(session.held, HandTarget) and np.allclose(session.held.position, hand + np.array([0.0, 0.0, 0.02]))
    assert not session.settings.page.autopilot
    for _ in range(100):
        session.nudge(np.array([0.02, 0.0, 0.02]))
    assert np.allclose(session.held.position, hand + np.array([0.3, 0.0, 0.3]))
    session.advance(0.1)
    assert np.isfinite(simulation.positions).all()


@pytest.mark.parametrize("scene", ["solo", "hold", "master_slave"])
@pytest.mark.parametrize("held", [None, JointTarget(np.zeros(7)), HandTarget(np.array([9.0, 9.0, 9.0]))])
def test_a_nudge_moves_the_hand(session: Session, scene: str, held: Target | None) -> None:
    session.change("scene", scene)
    session.hold(held)
    simulation = session.simulation
    hand = simulation.kinematics.hand_pose(simulation.guided).translation.copy()
    session.nudge(np.array([0.0, 0.02, 0.0]))
    expected = hand + (0.3 if isinstance(held, HandTarget) else np.array([0.0, 0.02, 0.0]))
    assert isinstance(session.held, HandTarget) and np.allclose(session.held.position, expected)
    for _ in range(20):
        session.advance(0.1)
    if not isinstance(held, HandTarget):
        moved = simulation.kinematics.hand_pose(simulation.guided).translation - hand
        assert np.linalg.norm(moved - [0.0, 0.02, 0.0]) < 5e-3


def test_a_nudge_moves_the_ball(session: Session) -> None:
    session.change("scene", "ball")
    columns = session.simulation.room.ball
    assert columns is not None
    ball = session.simulation.positions[columns].copy()
    session.hold(HandTarget(np.zeros(3)))
    for _ in range(3):
        session.nudge(np.array([0.0, 0.02, 0.0]))
    assert isinstance(session.held, BallTarget) and np.allclose(session.held.position, ball + np.array([0.0, 0.06, 0.0]))
    for _ in range(20):
        session.advance(0.1)
    assert np.allclose(session.simulation.positions[columns], session.held.position, atol=2e-3)
    for _ in range(500):
        session.nudge(np.array([0.02, 0.0, 0.0]))
        session.advance(0.1)
    assert session.held.position[0] == BALL_ROOM
    assert abs(session.simulation.positions[columns][0] - BALL_ROOM) < 0.02


def test_a_persons_own_arms_are_not_nudged(session: Session) -> None:
    session.change("scene", "imitation")
    session.nudge(np.array([0.0, 0.02, 0.0]))
    assert session.held is None and session.settings.page.autopilot


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


# --- posts ---------------------------------------------------------------------------------------------------------------------


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
