"""Pairs of links of one arm that can meet."""

import pinocchio as pin
import pytest

from controllers.kinematics import Kinematics
from scenes.own_pairs import own_pairs
from scenes.robots import robot
from scenes.room import build_room

CLEAR = 0.06


@pytest.mark.parametrize("made", ["lwr", "panda", "ur5"])
def test_neighbours_and_links_in_permanent_contact_are_left_out(made: str) -> None:
    room = build_room("table", made)
    kinematics = Kinematics(room.model, room.arms)
    kinematics.update(room.start)
    names = [capsule.name for capsule in robot(made).capsules]
    for arm in room.arms:
        geometry = own_pairs(room, arm, CLEAR)
        data = geometry.createData()
        pin.updateGeometryPlacements(room.model, kinematics.data, geometry, data)
        pin.computeDistances(geometry, data)
        pairs = [(pair.first, pair.second) for pair in geometry.collisionPairs]
        assert len(pairs) >= 3
        assert [body.name for body in geometry.geometryObjects] == [f"{arm.name} {name}" for name in names]
        assert all(b - a >= 2 for a, b in pairs)
        assert min(result.min_distance for result in data.distanceResults) >= CLEAR
    assert own_pairs(room, room.arms[0], 9.0).collisionPairs.tolist() == []
