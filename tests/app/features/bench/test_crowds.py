"""Cost of many visitors: the parts of the server's time, a lecture, private sessions."""

import itertools
from pathlib import Path

import pytest

from app.features.bench.figures_table import ratio_table
from tests.approved import Approve
from tests.tools.bench import crowds, processes
from tests.tools.bench.__main__ import printed_with_limits
from tests.tools.bench.crowds import measure_capacity, measure_crowd
from tests.tools.bench.processes import PARTS, ServerTimes, limit_of

pytestmark = pytest.mark.thorough


def test_time_is_charged_to_the_innermost_part(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = itertools.count()
    monkeypatch.setattr(processes.time, "thread_time", lambda: float(next(clock)))
    times = ServerTimes()
    step = times.timed(lambda: None, "step")

    def work(steps: int, fails: bool) -> int:
        for _ in range(steps):
            step()
        return steps // (not fails)

    # Each reading of the clock adds 1 s to it: a step reads it once, a frame once more than its steps.
    assert times.timed(work, "drawing")(2, False) == 2
    assert times.seconds == {"step": 2.0, "drawing": 3.0, "packing": 0.0, "sending": 0.0}
    with pytest.raises(ZeroDivisionError):
        times.timed(work, "packing")(1, True)
    step()
    assert times.seconds == {"step": 4.0, "drawing": 3.0, "packing": 2.0, "sending": 0.0}


def test_the_bottleneck_is_printed_below_the_table(
    capsys: pytest.CaptureFixture[str], approve: Approve
) -> None:
    parts = {
        "step_percent": 10.0,
        "drawing_percent": 25.0,
        "packing_percent": 3.0,
        "sending_percent": 2.0,
        "other_percent": 10.0,
    }
    figures = {"one": {"cpu_percent_of_a_core": 14.0}, "many": {"cpu_percent_of_a_core": 50.0, **parts}}
    assert limit_of(figures["one"]) == ""
    said = limit_of(figures["many"])
    approve("limits.txt", f"{said}\n")
    result = printed_with_limits(iter(figures.items()))
    assert capsys.readouterr().out.splitlines()[2:] == [f"{'many':36s} {said}"]
    twice = {"figures": {"many": {name: 2.0 * value for name, value in figures["many"].items()}}}
    assert ratio_table(twice, result).count("2.00x") == 6


def test_a_lecture_is_measured_from_outside(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(crowds, "SETTLING", 0.0)
    figures = measure_crowd(2, 1.0, lecture=True)
    assert (
        0.0 < figures["least_frames_per_s"] <= figures["frames_per_s"] * (1.0 + 1e-9)
        and figures["kB_per_s"] > 0.0
    )
    assert all(figures[f"{part}_percent"] > 0.0 for part in PARTS)
    parts = sum(figures[f"{part}_percent"] for part in (*PARTS, "other"))
    assert parts == pytest.approx(figures["cpu_percent_of_a_core"])


@pytest.mark.skipif(not Path("/proc").exists(), reason="CPU and memory are read from /proc")
def test_private_sessions_are_measured_with_all_server_processes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(crowds, "SETTLING", 0.0)
    # Visitors come for all places at once and are spread over the workers; none is refused on the way.
    ((name, figures),) = measure_capacity([6], 1.0)
    assert name == "6 private sessions"
    assert (
        0.0 < figures["least_frames_per_s"] <= figures["frames_per_s"] * (1.0 + 1e-9)
        and figures["kB_per_s"] > 0.0
    )
    assert (
        figures["cpu_percent_of_a_core"] > 0.0 and figures["memory_MB"] > 50.0 and figures["processes"] >= 1.0
    )
