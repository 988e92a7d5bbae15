"""embodik and roboplan in the hold experiment: the same hand and the same overlaps as ours, and what they keep with w and without."""

from importlib import import_module
from typing import Any

import pytest

from app.bench import peers
from app.bench.peer_method import bake
from app.bench.peer_ours import Ours
from scenes.settings import RunSettings, changed

pytestmark = pytest.mark.slow

POSE = RunSettings(task="pose")


def engine(name: str) -> Any:
    """Where it is installed: not every machine can have it."""
    pytest.importorskip(name)
    return getattr(import_module(f"app.bench.peer_{name}"), {"embodik": "Embodik", "roboplan": "RoboPlan"}[name])


@pytest.mark.parametrize("name", peers.SOMEWHERE)
@pytest.mark.parametrize("rig", ["torso", "table"])
def test_it_has_our_hand_and_overlaps_where_ours_do(name: str, rig: str) -> None:
    hold = bake(changed(POSE, "rig", rig), 2)
    found = peers.disagreement(Ours(hold), engine(name)(hold), hold.room)
    assert max(found["distance"], found["hand_pose"]) <= peers.AGREEMENT and found["nearest"] < -0.01


def test_an_engine_that_overlaps_elsewhere_is_found_out() -> None:
    hold = bake(POSE, 2)
    other = engine("roboplan")(hold)
    other._scene.setCollisions(list(hold.pairs[1:]), False)
    assert peers.disagreement(Ours(hold), other, hold.room)["distance"] > 0.001


@pytest.mark.parametrize(
    ("name", "with_w", "without"),
    [
        ("embodik", {"+w": {"speed": "task"}, "+w as rows": {"speed": "rows"}}, {}),
        ("roboplan", {"+w": {}}, {"knows_speed": False}),
    ],
)
def test_it_keeps_the_distance_with_w_alone(name: str, with_w: dict[str, dict[str, Any]], without: dict[str, Any]) -> None:
    make, hold = engine(name), bake(POSE, 1200)
    methods = {title: make(hold, **options) for title, options in (with_w | {"no w": without}).items()}
    rows = {title: peers._summary(record, hold) for title, record in peers._interleaved(methods, hold).items()}
    assert min(rows[title]["d_min"] for title in with_w) > 0.149 > rows["no w"]["d_min"]
    assert all(method.unsolved == 0 for method in methods.values())
    if name == "embodik":
        assert rows["no w"]["share_below"] > rows["+w"]["share_below"]
        # It does not ring.
        assert max(row["ddq_max"] for row in rows.values()) < 50.0
