"""The opening of the hold experiment: the elbow swings while the hand stays in its ring, then a push moves the hand."""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from controllers.kinematics import Array
from scenes.opening import BACK, ELBOW, OPENING, PUSH, Leg
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from scenes.targets import HandTarget
from scenes.two_arms import Autopilot

RING = 0.085
"""Radius of the drawn ring around the hand's place [m]."""


def elapsed(legs: tuple[Leg, ...]) -> float:
    """Duration of legs with their pauses [s]."""
    return sum(leg.seconds + leg.pause for leg in legs)


class Seen(NamedTuple):
    """Rows of a run: time [s], hand error and elbow motion [m], distance [m], λ, joints [rad, rad/s]."""

    time: Array
    error: Array
    swing: Array
    distance: Array
    activation: Array
    positions: Array
    velocities: Array


@cache
def seen(seconds: float) -> Seen:
    simulation = Simulation(RunSettings(), 10)
    source = simulation.opening()
    assert source is not None
    kinematics, arm = simulation.kinematics, simulation.avoiding
    hand, elbow = kinematics.hand_pose(arm).translation.copy(), kinematics.joint_point(arm.elbow).copy()
    rows = []
    for _ in range(round(seconds / simulation.settings.dt)):
        simulation.step(source.target(simulation.time))
        error = np.linalg.norm(kinematics.hand_pose(arm).translation - hand)
        swing = np.linalg.norm(kinematics.joint_point(arm.elbow) - elbow)
        sample = simulation.sample()
        scalars = simulation.time, error, swing, sample.distance, sample.activation
        rows.append((*scalars, simulation.positions.copy(), simulation.velocities.copy()))
    return Seen(*(np.array(column) for column in zip(*rows, strict=True)))


@pytest.fixture
def run() -> Seen:
    return seen(elapsed(OPENING) + 6.0)


def test_at_first_the_elbow_swings_and_the_hand_stays_in_its_ring(run: Seen) -> None:
    first = run.time <= elapsed(ELBOW)
    assert 8.0 < elapsed(ELBOW) < 16.0
    assert run.error[first].max() < 0.04 < RING / 2.0
    assert run.swing[first].max() > 0.09
    # λ causes the motion: at twice the distance the elbow rests.
    assert run.activation[first].max() > 0.1 and run.swing[run.time < 2.0].max() < 0.01


def test_then_the_push_moves_the_hand_out_of_its_ring(run: Seen) -> None:
    push = (run.time > elapsed(ELBOW)) & (run.time < elapsed((*ELBOW, *PUSH)))
    assert run.error[push].max() > 2.0 * RING
    assert run.activation[push].max() > 0.5 > run.activation[run.time <= elapsed(ELBOW)].max()
    # When the other arm returns home, the hand returns to its ring.
    assert run.error[np.searchsorted(run.time, elapsed(OPENING))] < 0.5 * RING
    assert OPENING[-1] is BACK[-1]


def test_the_opening_keeps_limits_and_distance_without_jumps(run: Seen) -> None:
    simulation = Simulation(RunSettings(), 10)
    model, dt = simulation.room.model, simulation.settings.dt
    assert (run.positions >= model.lowerPositionLimit - 1e-9).all() and (
        run.positions <= model.upperPositionLimit + 1e-9
    ).all()
    assert (np.abs(run.velocities) <= model.velocityLimit + 1e-9).all()
    assert run.distance.min() > RunSettings().law.critical_distance - 1e-3
    assert np.abs(np.diff(run.velocities, axis=0)).max() / dt < 40.0
    targets = [simulation.opening().target(float(t)) for t in np.arange(0.0, elapsed(OPENING) + 6.0, dt)]  # type: ignore[union-attr]
    places = np.array([target.position for target in targets if isinstance(target, HandTarget)])
    assert len(places) == len(targets) and np.linalg.norm(np.diff(places, axis=0), axis=1).max() / dt < 0.6


def test_after_the_opening_the_autopilot_continues_from_its_end() -> None:
    simulation = Simulation(RunSettings(), 10)
    source, room, place = simulation.opening(), simulation.room, np.array(OPENING[-1].place)
    autopilot = Autopilot(room, "right", 1, place)
    assert source is not None
    for time in (0.0, 1.0, 5.0, 30.0):
        after = source.target(elapsed(OPENING) + time)
        assert isinstance(after, HandTarget)
        assert np.allclose(after.position, autopilot.target(time).position, atol=1e-6)
