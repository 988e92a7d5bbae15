"""roboplan in the hold experiment: the same hand and the same overlaps as ours, and what it keeps with w and without."""

import pytest

pytest.importorskip("roboplan")

from app.bench import peers
from app.bench.peer_method import bake
from app.bench.peer_ours import Ours
from app.bench.peer_roboplan import RoboPlan
from scenes.settings import RunSettings, changed

pytestmark = pytest.mark.slow

POSE = RunSettings(task="pose")


@pytest.mark.parametrize("rig", ["torso", "table"])
def test_it_has_our_hand_and_overlaps_where_ours_do(rig: str) -> None:
    hold = bake(changed(POSE, "rig", rig), 2)
    found = peers.disagreement(Ours(hold), RoboPlan(hold), hold.room)
    assert max(found["distance"], found["hand_pose"]) <= peers.AGREEMENT and found["nearest"] < -0.01


def test_an_engine_that_overlaps_elsewhere_is_found_out() -> None:
    hold = bake(POSE, 2)
    engine = RoboPlan(hold)
    engine._scene.setCollisions(list(hold.pairs[1:]), False)
    assert peers.disagreement(Ours(hold), engine, hold.room)["distance"] > 0.001


def test_it_keeps_the_distance_with_w_alone() -> None:
    hold = bake(POSE, 1200)
    methods = {"+w": RoboPlan(hold), "no w": RoboPlan(hold, knows_speed=False)}
    rows = {name: peers._summary(record, hold) for name, record in peers._interleaved(methods, hold).items()}
    assert rows["+w"]["d_min"] > 0.149 > rows["no w"]["d_min"]
    assert all(method.unsolved == 0 for method in methods.values())
