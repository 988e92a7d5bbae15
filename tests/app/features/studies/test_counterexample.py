"""The search for a counterexample: the closest of several pairs loses, one smooth distance does not."""

import pickle
from dataclasses import replace
from math import inf
from time import monotonic

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from app.features.studies.counterexample import (
    BROKEN,
    FINER,
    SECONDS,
    Attack,
    attack_of,
    check,
    lasting,
    replayed,
    searched,
)
from controllers.errors import BadSetting
from scenes.history import COLUMN
from scenes.promise import Condition, broken_by, fallen, missing
from scenes.rerun import rerun
from scenes.roles import room_of
from scenes.room import World
from scenes.settings import RunSettings
from scenes.targets import SHORTEST, AnglesTarget, BallTarget, HandTarget, PairTarget, WallTarget, Waypoints
from scenes.wanted import Stopped, until
from tests.scenes.helpers import given_settings

pytestmark = pytest.mark.slow

CLOSEST = given_settings(pairs="single", v=0.05, dt=0.02)


def test_the_closest_pair_loses_50_mm_with_every_other_condition_met() -> None:
    # `until` is monotonic: setting the system clock has no effect. Pickled as from another process.
    found = pickle.loads(pickle.dumps(searched(CLOSEST, 1, 6, until=monotonic() + 600.0)))
    attack, loss = found.attack, found.loss
    assert loss.lost > 0.05 and loss.lost > 100.0 * loss.strict
    d_m, least = CLOSEST.law.critical_distance, inf
    for finer in (1, FINER):
        # d_law falls this far from d_m or above before a step in which another condition is missing.
        table = attack.table(finer)
        lacking = missing(replace(attack.settings, dt=attack.settings.dt / finer), table)
        bad = np.any(
            [steps for condition, steps in lacking.items() if condition is not Condition.PAIRS], axis=0
        )
        d = table[:, COLUMN["law_d"]]
        lowest = int(d.argmin())
        begin = int(np.flatnonzero(d[:lowest] >= d_m)[-1])
        end = begin + int(bad[begin:lowest].argmax()) if bad[begin:lowest].any() else lowest
        assert lacking[Condition.PAIRS][begin:end].any()
        least = min(least, d_m - d[begin:end].min())
    assert least > 0.05
    # The same person from the same start cannot break one smooth distance.
    smooth = given_settings(v=0.05, dt=0.02, wmax=attack.settings.hand_speed)
    assert broken_by(smooth, Attack(smooth, attack.start, attack.points).table()) < BROKEN


def test_a_fall_is_one_descent_from_the_critical_distance() -> None:
    margins = np.array([-0.2, 0.01, -0.01, -0.03, -0.02, -0.05, 0.02, -0.04, -0.09])
    every = np.ones(9, bool)
    assert fallen(margins, every) == pytest.approx(0.09)
    # Without one step of the last fall, only the part before it counts.
    assert fallen(margins, every & (np.arange(9) != 6)) == pytest.approx(0.05)
    assert fallen(margins, every & (np.arange(9) != 3) & (np.arange(9) != 6)) == pytest.approx(0.03)
    assert fallen(margins, ~every) == 0.0
    # A descent that begins below d_m is not a fall.
    assert fallen(margins[2:5], every[:3]) == 0.0


def test_a_loss_that_shrinks_with_the_time_step_does_not_count() -> None:
    assert lasting(1.457e-3, 0.358e-3) < BROKEN and lasting(1.107e-3, 0.274e-3) < BROKEN
    assert (
        lasting(0.060, 0.059) == pytest.approx(0.0587, abs=1e-4)
        and lasting(0.050, 0.060) == 0.050
        and lasting(0.2e-3, 0.0) == 0.0
    )


def test_a_smooth_distance_loses_nothing() -> None:
    for index in range(4):
        assert searched(given_settings(v=0.05, dt=0.02), 1, index).loss.lost < BROKEN


def test_a_start_is_reproducible_and_another_one_differs() -> None:
    first, again, other = (searched(CLOSEST, 1, index) for index in (9, 9, 10))
    assert first.loss == again.loss and first.runs == again.runs
    assert_array_equal(first.attack.start, again.attack.start)
    assert not np.array_equal(first.attack.start, other.attack.start)


@pytest.mark.parametrize("scene", ["ball", "hold", "master_slave", "imitation", "first_task"])
def test_a_link_and_a_file_make_the_same_run_in_every_scene(scene: str) -> None:
    settings = given_settings(scene=scene, pairs="single", dt=0.02)
    attack = searched(settings, 2, 0).attack
    table = attack.table()
    again = attack_of(attack.settings, attack.text())
    assert again.table().tobytes() == table.tobytes()
    recorded = replayed(again)
    assert recorded.seconds == pytest.approx(SECONDS)
    assert rerun(recorded).table.tobytes() == table.tobytes()


def test_a_search_begins_with_two_pairs_tied_just_above_the_critical_distance() -> None:
    room, ties = room_of(CLOSEST), 0
    for index in range(6):
        start, world = searched(CLOSEST, 3, index, until=0.0).attack.start, World(room, 10.0)
        world.kinematics.update(start)
        world.detector.detect()
        nearest = np.sort(world.detector.distances())[:2]
        ties += bool(np.ptp(nearest) < 0.03 and abs(nearest[0] - CLOSEST.law.critical_distance) < 0.04)
    assert ties >= 3


def test_scenes_and_robots_that_cannot_be_searched_are_refused() -> None:
    with pytest.raises(
        BadSetting,
        match="Nothing is in the way in the scene solo; choose from ball, hold, master_slave, imitation",
    ):
        check(given_settings(scene="solo"))
    with pytest.raises(BadSetting, match="ideal robot; leave out dead, lag"):
        check(given_settings(lag=0.1))


def test_a_search_can_be_stopped() -> None:
    with pytest.raises(Stopped), until(lambda: True):
        searched(CLOSEST, 1, 0)


ROOM = room_of(RunSettings())
GOOD = ",".join(f"{number:.4f}" for number in (*ROOM.start, *np.zeros(9)))


@pytest.mark.parametrize(
    ("text", "why"),
    [
        *((text, "numbers, start posture and way") for text in ("", "1,2,3", GOOD + ",1", "x" * 5000)),
        *((GOOD.replace("0.0000", number, 1), "numbers, start posture and way") for number in ("nan", "1e9")),
        (",".join(["9.0"] * 23), "outside the joints' limits"),
    ],
)
def test_a_damaged_link_is_refused(text: str, why: str) -> None:
    assert attack_of(RunSettings(), GOOD).start.shape == (14,)
    with pytest.raises(BadSetting, match=f"{why}; copy the link again"):
        attack_of(RunSettings(), text)


@given(st.text(max_size=300))
def test_any_text_is_an_attempt_or_refused(text: str) -> None:
    try:
        attack_of(RunSettings(), text)
    except BadSetting as error:
        assert str(error).endswith("copy the link again.")


def test_waypoints_are_passed_at_the_persons_speed() -> None:
    points = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.3, 0.0, 0.0], [0.3, 0.4, 0.0]])
    person = Waypoints("arm", points, 0.1)
    target = person.target(1.5)
    assert isinstance(target, HandTarget) and target.position == pytest.approx([0.15, 0.0, 0.0])
    later = person.target(3.0 + SHORTEST + 2.0)
    assert isinstance(later, HandTarget) and later.position == pytest.approx([0.3, 0.2, 0.0])
    end = Waypoints("ball", points, 0.1).target(100.0)
    assert isinstance(end, BallTarget) and end.position == pytest.approx(points[-1])
    both = Waypoints("wall and hand", np.array([[0.0] * 8, [0.1, 0, 0, 0, 0, 0.4, 0, 0]]), 0.1).target(2.0)
    assert isinstance(both, PairTarget) and isinstance(both.first, WallTarget)
    # The faster one moves at that speed; both arrive together.
    assert isinstance(both.second, HandTarget) and both.second.position == pytest.approx([0.2, 0.0, 0.0])
    assert both.first.position == pytest.approx([0.05, 0.0, 0.0])
    angles = Waypoints("person", np.arange(16.0).reshape(2, 8), 1.0).target(0.0)
    assert (
        isinstance(angles, AnglesTarget)
        and angles.angles is not None
        and angles.angles.tolist() == [[0, 1, 2, 3], [4, 5, 6, 7]]
    )
