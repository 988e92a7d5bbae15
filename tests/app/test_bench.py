"""The benchmark of a house full of visitors: that it measures what it says, and whom time is charged to."""

from __future__ import annotations

import itertools
from typing import Any

import pytest

from app.bench import fairness
from app.bench import visitors as crowd
from app.bench.fairness import FRAMES, GAP
from app.bench.measurements import compare, measure_fairness, table_text
from app.bench.visitors import PARTS, Shares, limit_of, measure_crowd


def test_time_is_charged_to_the_innermost_part(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = itertools.count()
    monkeypatch.setattr(crowd.time, "thread_time", lambda: float(next(clock)))
    shares = Shares()
    step = shares.timed(lambda: None, "step")

    def draw(times: int) -> int:
        for _ in range(times):
            step()
        return times

    frame = shares.timed(draw, "drawing")
    # Every look at the clock takes a second of it: a step has one, a frame one more than it has steps.
    assert frame(2) == 2
    assert shares.seconds == {"step": 2.0, "drawing": 3.0, "packing": 0.0, "sending": 0.0}
    assert frame(1) == 1
    assert shares.seconds["drawing"] == 5.0

    def fail() -> None:
        step()
        raise ValueError

    with pytest.raises(ValueError):
        shares.timed(fail, "packing")()
    assert shares.seconds["packing"] == 2.0
    step()
    assert shares.seconds["step"] == 5.0


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
    monkeypatch.setattr(crowd, "SETTLING", 0.0)
    figures = measure_crowd(3, 1.0, lecture=True)
    assert 0.0 < figures["least_frames_per_s"] <= figures["frames_per_s"] and figures["kB_per_s"] > 0.0
    assert all(figures[f"{part}_percent"] > 0.0 for part in PARTS)
    parts = sum(figures[f"{part}_percent"] for part in (*PARTS, "other"))
    assert parts == pytest.approx(figures["cpu_percent_of_a_core"])


def test_a_neighbour_is_watched_while_somebody_else_does_something(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fairness, "SETTLING", 0.0)
    quiet, flooded = (measure_fairness(1.0, [name])["figures"][name] for name in ("nothing", "600/s of a slider"))
    for figures in (quiet, flooded):
        assert figures["frames_per_s"] > 0.0 and figures["longest_gap_ms"] > 0.0 and figures["longest_work_ms"] > 0.0
        assert figures["fair"] == (figures["frames_per_s"] >= FRAMES and figures["longest_gap_ms"] <= 1000.0 * GAP)
