"""Nudges add up but do not run away, and move what is held."""

from __future__ import annotations

import numpy as np
import pytest

from app.session.session import Session
from scenes.room import BALL_ROOM
from scenes.targets import BallTarget, HandTarget, JointTarget, Target


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
