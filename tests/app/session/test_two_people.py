"""Two people hold an arm each: the guest moves the ring of the silver hand, and the run is made again to the last bit."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.session.replay import Replay, make_film
from app.session.second_hand import SecondHand
from app.session.session import Session
from app.settings import Settings
from controllers.errors import BadInputFile
from scenes.inputs import Stretch
from scenes.inputs_file import recorded_bytes, recorded_from
from scenes.packing import KINDS, WIDTHS, decoded, encoded
from scenes.rerun import target_between
from scenes.settings import RunSettings
from scenes.targets import HandTarget, LinkTarget, PairTarget
from tests.scenes.helpers import place_of

BOTH = Settings(run=RunSettings(scene="hold", avoid="both"))
NUMBER = st.floats(-1.0, 1.0)
POINT = st.tuples(NUMBER, NUMBER, NUMBER).map(np.array)
HELD = st.one_of(
    st.builds(LinkTarget, st.integers(1, 7), POINT, POINT),
    st.builds(HandTarget, POINT, st.sampled_from([None, np.eye(3), np.asfortranarray(np.eye(3))]), st.none() | POINT),
)


@given(st.none() | HELD, HELD)
def test_what_two_people_want_is_kept_to_the_last_bit(
    first: HandTarget | LinkTarget | None, second: HandTarget | LinkTarget
) -> None:
    code, numbers = encoded(PairTarget(first, second))
    assert len(KINDS[code]) == 2 and len(numbers) == 8 * WIDTHS[code] and code < 256
    found = decoded(code, np.frombuffer(numbers))
    assert isinstance(found, PairTarget)
    assert encoded(found) == (code, numbers) and encoded(found.first) == encoded(first)


def two() -> tuple[Session, SecondHand]:
    session = Session(BOTH)
    return session, SecondHand(session, lambda action: None)


def test_the_guest_moves_the_ring_and_neither_arm_touches_the_other() -> None:
    session, guest = two()
    before = place_of(session.simulation)
    assert guest.arm is session.simulation.avoiding and session.arm is session.simulation.guided
    # They come for each other.
    mine, theirs = (session.simulation.kinematics.hand_pose(one).translation.copy() for one in (session.arm, guest.arm))
    guest.hold(HandTarget(mine))
    session.hold(HandTarget(theirs))
    nearest = np.inf
    for _ in range(500):
        session.advance(0.01)
        nearest = min(nearest, session.simulation.sample().distance)
    assert nearest > 0.0, "both gave way"
    moved = place_of(session.simulation)
    assert np.linalg.norm(moved - before) > 0.1
    # Let go, the ring stays where it was left.
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


def test_a_pull_at_the_silver_hand_moves_its_ring_and_a_nudge_too() -> None:
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
    # Where a second person can hold nothing, what they held has no meaning.
    session.change("scene", "ball")
    assert not isinstance(session.target(), PairTarget)


def test_finer_steps_go_between_what_both_want() -> None:
    a, b = np.zeros(3), np.ones(3)
    middle = target_between(PairTarget(HandTarget(a), LinkTarget(3, a, a)), PairTarget(HandTarget(b), LinkTarget(3, a, b)), 0.5)
    assert isinstance(middle, PairTarget) and middle.first is not None
    assert isinstance(middle.first, HandTarget) and middle.first.position[0] == 0.5
    assert isinstance(middle.second, LinkTarget) and middle.second.position[0] == 0.5
    # Only one of them has let go.
    other = target_between(PairTarget(HandTarget(a), HandTarget(a)), PairTarget(None, HandTarget(b)), 0.5)
    assert isinstance(other, PairTarget) and np.array_equal(other.second[0], 0.5 * b)


@pytest.mark.parametrize(
    "second", [LinkTarget(8, np.zeros(3), np.zeros(3)), HandTarget(np.full(3, 99.0)), HandTarget(np.zeros(3), 2.0 * np.eye(3))]
)
def test_a_file_with_an_impossible_second_hand_is_refused(second: HandTarget | LinkTarget) -> None:
    session, guest = two()
    guest.hold(HandTarget(np.zeros(3)))
    session.advance(0.05)
    recorded = session.inputs.window(60.0)
    assert recorded is not None
    code, numbers = encoded(PairTarget(None, second))
    targets = recorded.stretches[0].targets._replace(
        codes=np.array([code], np.uint8), counts=np.array([1], np.uint32), numbers=np.frombuffer(numbers)
    )
    with pytest.raises(BadInputFile):
        recorded_from(recorded_bytes(replace(recorded, stretches=(Stretch(recorded.settings, targets),))), "two")


def test_a_reset_ends_what_either_of_two_people_holds() -> None:
    session, guest = two()
    place = place_of(session.simulation)
    guest.hold(HandTarget(place + np.array([0.0, 0.0, 0.2])))
    session.hold(HandTarget(place))
    session.reset()
    assert session.held is None and guest.held is None
