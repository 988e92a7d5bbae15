"""Effect of one visitor on the others."""

import pytest

from tests.tools.bench import fairness
from tests.tools.bench.fairness import LEAST_FRAMES, LONGEST_GAP, measure_fairness
from tests.tools.bench.processes import process, serve_app

pytestmark = pytest.mark.thorough


def test_a_neighbour_is_measured_during_disturbances_of_one_server(monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[object] = []
    monkeypatch.setattr(
        fairness, "process", lambda work, *arguments: started.append(work) or process(work, *arguments)
    )
    names = ["600/s of a slider", "600/s of the hand", "30/s of the languages", "600/s of a box"]
    found = dict(measure_fairness(0.5, names))
    assert list(found) == names and started.count(serve_app) == 1
    for figures in found.values():
        assert (
            figures["frames_per_s"] > 0.0
            and figures["longest_gap_ms"] > 0.0
            and figures["longest_work_ms"] > 0.0
        )
        assert figures["fair"] == (
            figures["frames_per_s"] >= LEAST_FRAMES and figures["longest_gap_ms"] <= 1000.0 * LONGEST_GAP
        )
