"""embodik in the hold experiment: the same distances as ours, and what it keeps with w and without."""

import pytest

pytest.importorskip("embodik")

from app.bench import peers
from app.bench.peer_embodik import Embodik
from app.bench.peer_method import bake
from app.bench.peer_ours import Ours
from scenes.settings import RunSettings, changed

pytestmark = pytest.mark.slow

POSE = RunSettings(task="pose")


@pytest.mark.parametrize("rig", ["torso", "table"])
def test_it_has_our_pairs_distances_and_hand_overlaps_included(rig: str) -> None:
    hold = bake(changed(POSE, "rig", rig), 2)
    found = peers.disagreement(Ours(hold), Embodik(hold), hold.room)
    assert max(found["distance"], found["hand_pose"]) <= peers.AGREEMENT and found["nearest"] < -0.01


def test_it_keeps_the_distance_with_w_alone() -> None:
    hold = bake(POSE, 1200)
    methods = {
        "+w": Embodik(hold, speed="task"),
        "+w as rows": Embodik(hold, speed="rows"),
        "no w": Embodik(hold),
    }
    rows = {name: peers._summary(record, hold) for name, record in peers._interleaved(methods, hold).items()}
    assert min(rows["+w"]["d_min"], rows["+w as rows"]["d_min"]) > 0.149 > rows["no w"]["d_min"]
    assert rows["no w"]["share_below"] > rows["+w"]["share_below"]
    # It does not ring.
    assert max(row["ddq_max"] for row in rows.values()) < 50.0
    assert all(method.unsolved == 0 for method in methods.values())
