"""Each of two people holds an arm; a guest moves the silver hand's ring. The run is replayed bit for bit."""

import numpy as np

from app.features.second_person.second_hand import SecondHand
from app.session.replay import Replay, make_film
from app.session.session import Session
from app.settings import Settings
from scenes.inputs_file import recorded_bytes, recorded_from
from scenes.settings import RunSettings
from scenes.targets import HandTarget, LinkTarget, PairTarget
from tests.scenes.helpers import place_of

BOTH = Settings(run=RunSettings(scene="hold", avoid="both"))


def two() -> tuple[Session, SecondHand]:
    session = Session(BOTH)
    return session, SecondHand(session, lambda action: None)


def test_the_guest_moves_the_ring_and_the_arms_do_not_touch() -> None:
    session, guest = two()
    before = place_of(session.simulation)
    assert guest.arm is session.simulation.avoiding and session.hand.arm is session.simulation.guided
    # Each hand is pulled to the other one.
    mine, theirs = (
        session.simulation.kinematics.hand_pose(one).translation.copy()
        for one in (session.hand.arm, guest.arm)
    )
    guest.hold(HandTarget(mine))
    session.hand.hold(HandTarget(theirs))
    nearest = np.inf
    for _ in range(500):
        session.advance(0.01)
        nearest = min(nearest, session.simulation.sample().distance)
    assert nearest > 0.0, "both arms must give way"
    moved = place_of(session.simulation)
    assert np.linalg.norm(moved - before) > 0.1
    # After the release the ring stays in place.
    guest.hold(None)
    session.advance(0.1)
    place = place_of(session.simulation)
    assert np.array_equal(place, moved) and guest.held is None
    recorded = session.inputs.window(60.0)
    assert recorded is not None
    again = recorded_from(recorded_bytes(recorded), "two")
    replay = Replay(make_film(again))
    replay.seek(replay.end)
    assert np.array_equal(replay.simulation.positions, session.simulation.positions)


def test_a_pull_at_the_silver_hand_and_a_nudge_move_its_ring() -> None:
    session, guest = two()
    session.change("autopilot", False)
    start = place_of(session.simulation)
    hand = session.simulation.kinematics.hand_pose(guest.arm).translation.copy()
    guest.hold(LinkTarget(7, np.zeros(3), hand + np.array([0.0, 0.0, 0.1])))
    for _ in range(50):
        session.advance(0.01)
    assert place_of(session.simulation)[2] > start[2]
    guest.nudge(np.array([0.02, 0.0, 0.0]))
    assert isinstance(guest.held, HandTarget) and isinstance(session.target(), PairTarget)
    # In a scene without a place for a second person their target is ignored.
    session.change("scene", "ball")
    assert not isinstance(session.target(), PairTarget)


def test_a_reset_ends_what_both_people_hold() -> None:
    session, guest = two()
    place = place_of(session.simulation)
    guest.hold(HandTarget(place + np.array([0.0, 0.0, 0.2])))
    session.hand.hold(HandTarget(place))
    session.reset()
    assert session.held is None and guest.held is None
