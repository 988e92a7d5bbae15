"""Two robots of any make in a room: they start well, and keep clear."""

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from controllers.kinematics import Kinematics
from controllers.proximity import ProximityDetector
from scenes.headless import run
from scenes.rigs import RIGS
from scenes.robots import RobotName, start_posture
from scenes.room import build_room
from scenes.settings import ArmName, RigName
from tests.scenes.helpers import RIG_NAMES, column, hold_settings
from tests.scenes.robots.helpers import NAMES, OTHERS


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("name", NAMES)
def test_arms_start_clear_of_each_other_and_of_their_stops_and_mirrored(name: RobotName, rig: RigName) -> None:
    """25 cm apart, 15° from every stop; hands at the same height, on either side, in front."""
    room = build_room(rig, name)
    kinematics = Kinematics(room.model, room.arms)
    kinematics.update(room.start)
    assert ProximityDetector(kinematics, room.geometry).detect("single").distance >= 0.25
    margin = np.minimum(room.start - room.model.lowerPositionLimit, room.model.upperPositionLimit - room.start)
    assert margin.min() > np.radians(15)
    left, right = (kinematics.hand_pose(arm).translation for arm in room.arms)
    assert_allclose(left, right * ((1, -1, 1) if rig == "torso" else (-1, -1, 1)), atol=2e-3)
    assert left[0] > 0.6 if rig == "torso" else -0.45 < left[0] < -0.15
    assert 0.8 < left[2] < 1.6


def test_a_start_posture_is_a_copy() -> None:
    first = start_posture("lwr", "torso", "left")
    assert first is not None
    first[0] = 9.0
    assert_array_equal(start_posture("lwr", "torso", "left"), RIGS["torso"].left_start)
    assert_array_equal(start_posture("lwr", "torso", "right"), RIGS["torso"].right_start)


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("name", OTHERS)
def test_the_paper_s_law_keeps_other_robots_clear(name: RobotName, rig: RigName) -> None:
    """The autopilot's hand comes as near as with the LWR, and never nearer than d_m; the start postures are chosen for that."""
    for guided in get_args(ArmName):
        chosen = replace(hold_settings(rig, seed=2), robot=name, guided=guided)
        distances = column(run(chosen, 46.0).table, "d")
        assert chosen.law.critical_distance <= distances.min() < 1.2 * chosen.law.critical_distance
