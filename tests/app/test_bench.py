"""The benchmark of many visitors: what it measures, and to which part a time is charged."""

import itertools
from typing import Any

import pytest

from app.bench import fairness, server_times, visitors
from app.bench.fairness import LEAST_FRAMES, LONGEST_GAP
from app.bench.measurements import compare, measure_fairness, table_text
from app.bench.server_times import PARTS, ServerTimes, limit_of
from app.bench.visitors import measure_crowd


def test_time_is_charged_to_the_innermost_part(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = itertools.count()
    monkeypatch.setattr(server_times.time, "thread_time", lambda: float(next(clock)))
    times = ServerTimes()
    step = times.timed(lambda: None, "step")

    def work(steps: int, fails: bool) -> int:
        for _ in range(steps):
            step()
        return steps // (not fails)

    # Every look at the clock takes a second of it: a step has one, a frame one more than it has steps.
    assert times.timed(work, "drawing")(2, False) == 2
    assert times.seconds == {"step": 2.0, "drawing": 3.0, "packing": 0.0, "sending": 0.0}
    with pytest.raises(ZeroDivisionError):
        times.timed(work, "packing")(1, True)
    step()
    assert times.seconds == {"step": 4.0, "drawing": 3.0, "packing": 2.0, "sending": 0.0}


def test_what_limits_is_said_below_the_table() -> None:
    parts = {"step_percent": 10.0, "drawing_percent": 25.0, "packing_percent": 3.0, "sending_percent": 2.0, "other_percent": 10.0}
    figures = {"one": {"cpu_percent_of_a_core": 14.0}, "many": {"cpu_percent_of_a_core": 50.0, **parts}}
    assert limit_of(figures["one"]) == ""
    said = limit_of(figures["many"])
    assert said == "of 50 % of a core: drawing 50 %, step 20 %, other 20 %, packing 6 %, sending 4 %"
    result: dict[str, Any] = {"figures": figures, "version": "1"}
    assert table_text(result).splitlines()[2:] == [f"{'many':36s} {said}"]
    twice = {"figures": {"many": {name: 2.0 * value for name, value in figures["many"].items()}}}
    assert compare(twice, result).count("2.00x") == 6


def test_a_lecture_is_measured_from_outside(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(visitors, "SETTLING", 0.0)
    figures = measure_crowd(3, 1.0, lecture=True)
    assert 0.0 < figures["least_frames_per_s"] <= figures["frames_per_s"] and figures["kB_per_s"] > 0.0
    assert all(figures[f"{part}_percent"] > 0.0 for part in PARTS)
    parts = sum(figures[f"{part}_percent"] for part in (*PARTS, "other"))
    assert parts == pytest.approx(figures["cpu_percent_of_a_core"])


def test_a_neighbour_is_measured_during_a_disturbance(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fairness, "SETTLING", 0.0)
    quiet, flooded = (measure_fairness(1.0, [name])["figures"][name] for name in ("nothing", "600/s of a slider"))
    for figures in (quiet, flooded):
        assert figures["frames_per_s"] > 0.0 and figures["longest_gap_ms"] > 0.0 and figures["longest_work_ms"] > 0.0
        assert figures["fair"] == (figures["frames_per_s"] >= LEAST_FRAMES and figures["longest_gap_ms"] <= 1000.0 * LONGEST_GAP)
