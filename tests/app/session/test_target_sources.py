"""Sources of the arm's motion: autopilot, held hand, nudges by key, guest source."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from app.session import session as session_module
from app.session.session import Session
from controllers.errors import BadSetting
from scenes.ball import BALL_ROOM
from scenes.headless import run
from scenes.room import Room
from scenes.settings import RunSettings
from scenes.targets import AnglesTarget, BallTarget, HandTarget, JointTarget, Target
from tests.app.session.conftest import DT, bits, go


def test_the_autopilot_begins_at_the_present_hand(session: Session) -> None:
    session.change("autopilot", False)
    hand = session.simulation.kinematics.hand_pose(session.simulation.guided).translation.copy()
    session.hand.hold(HandTarget(hand + np.array([0.0, 0.0, 0.1])))
    go(session, 1.0)
    session.hand.hold(None)
    simulation = session.simulation
    now = simulation.kinematics.hand_pose(simulation.guided).translation.copy()
    assert np.linalg.norm(now - hand) > 0.05
    session.change("autopilot", True)
    target = session.target()
    assert isinstance(target, HandTarget) and np.linalg.norm(target.position - now) < 2e-3


PEOPLE = {
    "solo": HandTarget,
    "ball": BallTarget,
    "hold": HandTarget,
    "master_slave": HandTarget,
    "imitation": AnglesTarget,
}


@pytest.mark.parametrize("scene", PEOPLE)
def test_every_experiment_has_its_own_person(session: Session, scene: str) -> None:
    session.advance(0.1)
    session.change("scene", scene)
    session.change("ball", "cross")
    assert isinstance(session.target(), PEOPLE[scene])
    q = session.simulation.positions.copy()
    go(session, 1.0)
    assert np.abs(session.simulation.positions - q).max() > 0.002
    session.reset()
    go(session, 0.5)
    again = run(session.settings.run, 0.5)
    assert bits(session) == again.table.tobytes()


PLACE = np.array([0.4, 0.1, 1.0])
TARGETS = (HandTarget(PLACE), JointTarget(np.zeros(7)), BallTarget(PLACE), AnglesTarget(np.zeros((2, 4))))


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: type(target).__name__)
def test_a_held_target_takes_over_at_once(session: Session, target: Target) -> None:
    session.advance(0.1)
    assert session.settings.page.autopilot and session.target() is not None
    session.hand.hold(target)
    assert not session.settings.page.autopilot and session.target() is target
    session.advance(0.1)
    recorded = session.inputs.window()
    assert recorded is not None
    assert [type(t) for t in recorded.targets()][-20:] == [type(target)] * 20
    session.hand.hold(None)
    assert not session.settings.page.autopilot and session.target() is None


CHANGES: list[tuple[str, Any]] = [
    *(
        ("scene", "solo"),
        ("rig", "table"),
        ("guided", "left"),
        ("path", "circle"),
        ("point", "arm"),
        ("ball", "cross"),
    ),
    *(("clip", "wave"), ("seed", 7), ("source", "figure")),
]


@pytest.mark.parametrize(("key", "value"), CHANGES)
def test_another_person_or_place_restarts_the_source(session: Session, key: str, value: Any) -> None:
    session.advance(0.1)
    first = session.target()
    session.change("dm", 0.12)
    session.change("law", "barrier_qp")
    kept = session.target()
    assert isinstance(first, HandTarget) and isinstance(kept, HandTarget)
    assert kept.position.tolist() == first.position.tolist()
    session.hand.hold(HandTarget(np.zeros(3)))
    session.change("k", 3.0)
    assert session.held is not None
    session.change(key, value)
    assert session.held is None and session.target() is None
    session.change("autopilot", True)
    person = session.simulation.source().target(0.0)
    mine = session.target()
    assert type(mine) is type(person)
    if mine is not None and person is not None:
        assert all(
            x is y is None or np.array_equal(np.asarray(x), np.asarray(y))
            for x, y in zip(mine, person, strict=True)
        )


def test_a_guest_source_moves_the_arm_until_a_hand_holds_it(session: Session) -> None:
    session.advance(0.1)
    session.hand.hold(HandTarget(np.zeros(3)))
    session.advance(0.1)
    asked: list[float] = []
    guest: Any = SimpleNamespace(
        target=lambda time: asked.append(time) or HandTarget(np.array([0.4, 0.1, 1.0 + time]))
    )
    session.hand.set_source(guest)
    assert session.held is None and session.settings.page.autopilot
    session.advance(0.1)
    assert np.allclose(asked, np.arange(20) * DT)
    # A hand has priority; the guest then restarts, like the autopilot.
    session.hand.hold(HandTarget(np.zeros(3)))
    session.advance(0.1)
    assert len(asked) == 20
    session.hand.hold(None)
    session.change("autopilot", True)
    session.advance(2.0 * DT)
    assert np.allclose(asked[20:], [0.0, DT])
    session.reset()
    session.advance(DT)
    assert asked[-1] == 0.0
    session.hand.set_source(None)
    assert isinstance(session.simulation.source().target(0.0), HandTarget)
    session.advance(DT)
    assert len(asked) == 23
    session.hand.set_source(guest)
    session.change("source", "figure")
    session.advance(DT)
    assert len(asked) == 23


def test_nudges_add_up_to_a_limit(session: Session) -> None:
    simulation = session.simulation
    hand = simulation.kinematics.hand_pose(simulation.guided).translation.copy()
    session.hand.nudge(np.array([0.0, 0.0, 0.02]))
    assert isinstance(session.held, HandTarget) and np.allclose(
        session.held.position, hand + np.array([0.0, 0.0, 0.02])
    )
    assert not session.settings.page.autopilot
    for _ in range(100):
        session.hand.nudge(np.array([0.02, 0.0, 0.02]))
    assert np.allclose(session.held.position, hand + np.array([0.3, 0.0, 0.3]))
    session.advance(0.1)
    assert np.isfinite(simulation.positions).all()


@pytest.mark.parametrize("scene", ["solo", "hold", "master_slave"])
@pytest.mark.parametrize("held", [None, JointTarget(np.zeros(7)), HandTarget(np.array([9.0, 9.0, 9.0]))])
def test_a_nudge_moves_the_hand(session: Session, scene: str, held: Target | None) -> None:
    session.change("scene", scene)
    session.hand.hold(held)
    simulation = session.simulation
    hand = simulation.kinematics.hand_pose(simulation.guided).translation.copy()
    session.hand.nudge(np.array([0.0, 0.02, 0.0]))
    expected = hand + (0.3 if isinstance(held, HandTarget) else np.array([0.0, 0.02, 0.0]))
    assert isinstance(session.held, HandTarget) and np.allclose(session.held.position, expected)
    go(session, 2.0)
    if not isinstance(held, HandTarget):
        moved = simulation.kinematics.hand_pose(simulation.guided).translation - hand
        assert np.linalg.norm(moved - [0.0, 0.02, 0.0]) < 5e-3


def test_a_nudge_moves_the_ball_but_not_a_person(session: Session) -> None:
    session.change("scene", "ball")
    columns = session.simulation.room.ball
    assert columns is not None
    ball = session.simulation.positions[columns].copy()
    session.hand.hold(HandTarget(np.zeros(3)))
    for _ in range(3):
        session.hand.nudge(np.array([0.0, 0.02, 0.0]))
    assert isinstance(session.held, BallTarget) and np.allclose(
        session.held.position, ball + np.array([0.0, 0.06, 0.0])
    )
    go(session, 2.0)
    assert np.allclose(session.simulation.positions[columns], session.held.position, atol=2e-3)
    for _ in range(500):
        session.hand.nudge(np.array([0.02, 0.0, 0.0]))
        session.advance(0.1)
    assert session.held.position[0] == BALL_ROOM
    assert abs(session.simulation.positions[columns][0] - BALL_ROOM) < 0.02
    # A nudge does not move a person's arms.
    session.change("scene", "imitation")
    session.change("autopilot", True)
    session.hand.nudge(np.array([0.0, 0.02, 0.0]))
    assert session.held is None and session.settings.page.autopilot


def test_a_missing_robot_changes_nothing(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(settings: RunSettings) -> Room:
        raise BadSetting(f"{settings.robot} needs a package that is not installed.")

    session.advance(0.1)
    session.hand.hold(HandTarget(np.array([0.4, 0.1, 1.0])))
    before, room = session.settings, session.simulation.room
    monkeypatch.setattr(session_module, "room_of", missing)
    with pytest.raises(BadSetting, match="panda needs"):
        session.change("robot", "panda")
    assert (
        session.settings is before
        and session.simulation.settings is before.run
        and session.simulation.room is room
    )
    assert session.held is not None
    assert session.advance(0.1) == 20
