"""Both arms held at once: the pair of targets is recorded, interpolated, checked in files, and reset."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.session.session import Session
from app.settings import Settings
from controllers.errors import BadInputFile
from scenes.inputs import Stretch
from scenes.inputs_file import recorded_bytes, recorded_from
from scenes.packing import KINDS, WIDTHS, decoded, encoded
from scenes.rerun import target_between
from scenes.settings import RunSettings
from scenes.targets import HandTarget, LinkTarget, PairTarget

BOTH = Settings(run=RunSettings(scene="hold", avoid="both"))
NUMBER = st.floats(-1.0, 1.0)
POINT = st.tuples(NUMBER, NUMBER, NUMBER).map(np.array)
HELD = st.one_of(
    st.builds(LinkTarget, st.integers(1, 7), POINT, POINT),
    st.builds(
        HandTarget, POINT, st.sampled_from([None, np.eye(3), np.asfortranarray(np.eye(3))]), st.none() | POINT
    ),
)


@given(st.none() | HELD, HELD)
def test_a_pair_of_targets_is_recorded_to_the_last_bit(
    first: HandTarget | LinkTarget | None, second: HandTarget | LinkTarget
) -> None:
    code, numbers = encoded(PairTarget(first, second))
    assert len(KINDS[code]) == 2 and len(numbers) == 8 * WIDTHS[code] and code < 256
    found = decoded(code, np.frombuffer(numbers))
    assert isinstance(found, PairTarget)
    assert encoded(found) == (code, numbers) and encoded(found.first) == encoded(first)


def test_finer_steps_interpolate_both_targets() -> None:
    a, b = np.zeros(3), np.ones(3)
    middle = target_between(
        PairTarget(HandTarget(a), LinkTarget(3, a, a)), PairTarget(HandTarget(b), LinkTarget(3, a, b)), 0.5
    )
    assert isinstance(middle, PairTarget) and middle.first is not None
    assert isinstance(middle.first, HandTarget) and middle.first.position[0] == 0.5
    assert isinstance(middle.second, LinkTarget) and middle.second.position[0] == 0.5
    # Only one person has let go.
    other = target_between(PairTarget(HandTarget(a), HandTarget(a)), PairTarget(None, HandTarget(b)), 0.5)
    assert isinstance(other, PairTarget) and np.array_equal(other.second[0], 0.5 * b)


def test_the_other_hand_counts_only_in_experiments_for_two_until_a_reset() -> None:
    session, held = Session(BOTH), HandTarget(np.zeros(3))
    session.hand.other = held
    target = session.target()
    assert isinstance(target, PairTarget) and target.second is held
    session.change("scene", "ball")
    assert not isinstance(session.target(), PairTarget)
    session.change("scene", "hold")
    session.reset()
    assert session.hand.other is None and not isinstance(session.target(), PairTarget)


@pytest.mark.parametrize(
    "second",
    [
        LinkTarget(8, np.zeros(3), np.zeros(3)),
        HandTarget(np.full(3, 99.0)),
        HandTarget(np.zeros(3), 2.0 * np.eye(3)),
    ],
)
def test_a_file_with_an_impossible_second_hand_is_refused(second: HandTarget | LinkTarget) -> None:
    session = Session(BOTH)
    session.hand.other = HandTarget(np.zeros(3))
    session.advance(0.05)
    recorded = session.inputs.window(60.0)
    assert recorded is not None
    code, numbers = encoded(PairTarget(None, second))
    targets = recorded.stretches[0].targets._replace(
        codes=np.array([code], np.uint8), counts=np.array([1], np.uint32), numbers=np.frombuffer(numbers)
    )
    with pytest.raises(BadInputFile):
        recorded_from(
            recorded_bytes(replace(recorded, stretches=(Stretch(recorded.settings, targets),))), "two"
        )
