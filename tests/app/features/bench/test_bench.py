"""The benchmarks: what many visitors cost, what their figures say, and what one of them leaves for the others."""

import itertools
import math
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.features.bench import fairness, processes, visitors
from app.features.bench.fairness import LEAST_FRAMES, LONGEST_GAP, measure_fairness
from app.features.bench.measurements import measure_capacity, printed, ratio_table
from app.features.bench.processes import PARTS, ServerTimes, limit_of, process, serve_app, used_by_tree
from app.features.bench.visitors import measure_crowd

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

    # Every look at the clock takes a second of it: a step has one, a frame one more than it has steps.
    assert times.timed(work, "drawing")(2, False) == 2
    assert times.seconds == {"step": 2.0, "drawing": 3.0, "packing": 0.0, "sending": 0.0}
    with pytest.raises(ZeroDivisionError):
        times.timed(work, "packing")(1, True)
    step()
    assert times.seconds == {"step": 4.0, "drawing": 3.0, "packing": 2.0, "sending": 0.0}


def test_what_limits_is_said_below_the_table(capsys: pytest.CaptureFixture[str]) -> None:
    parts = {"step_percent": 10.0, "drawing_percent": 25.0, "packing_percent": 3.0, "sending_percent": 2.0, "other_percent": 10.0}
    figures = {"one": {"cpu_percent_of_a_core": 14.0}, "many": {"cpu_percent_of_a_core": 50.0, **parts}}
    assert limit_of(figures["one"]) == ""
    said = limit_of(figures["many"])
    assert said == "of 50 % of a core: drawing 50 %, step 20 %, other 20 %, packing 6 %, sending 4 %"
    result = printed(iter(figures.items()))
    assert capsys.readouterr().out.splitlines()[2:] == [f"{'many':36s} {said}"]
    twice = {"figures": {"many": {name: 2.0 * value for name, value in figures["many"].items()}}}
    assert ratio_table(twice, result).count("2.00x") == 6


def test_a_row_is_printed_before_the_next_one_is_measured(capsys: pytest.CaptureFixture[str]) -> None:
    seen: list[str] = []

    def rows() -> Iterator[tuple[str, dict[str, float]]]:
        for name in ("first", "second"):
            seen.append(capsys.readouterr().out)
            yield name, {"frames_per_s": 60.0}

    assert list(printed(rows())["figures"]) == ["first", "second"]
    assert seen == ["", f"{'first':36s} frames_per_s 60.0\n"]


def test_a_lecture_is_measured_from_outside(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(visitors, "SETTLING", 0.0)
    figures = measure_crowd(2, 1.0, lecture=True)
    assert 0.0 < figures["least_frames_per_s"] <= figures["frames_per_s"] * (1.0 + 1e-9) and figures["kB_per_s"] > 0.0
    assert all(figures[f"{part}_percent"] > 0.0 for part in PARTS)
    parts = sum(figures[f"{part}_percent"] for part in (*PARTS, "other"))
    assert parts == pytest.approx(figures["cpu_percent_of_a_core"])


needs_proc = pytest.mark.skipif(not Path("/proc").exists(), reason="CPU and memory are read from /proc")


@needs_proc
def test_private_sessions_are_measured_with_all_processes_of_the_server(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(visitors, "SETTLING", 0.0)
    # As many as there are places come at once, and are spread over the workers; none is refused on the way to another one.
    ((name, figures),) = measure_capacity([6], 1.0)
    assert name == "6 private sessions"
    assert 0.0 < figures["least_frames_per_s"] <= figures["frames_per_s"] * (1.0 + 1e-9) and figures["kB_per_s"] > 0.0
    assert figures["cpu_percent_of_a_core"] > 0.0 and figures["memory_MB"] > 50.0 and figures["processes"] >= 1.0


@needs_proc
def test_what_a_process_has_started_counts_as_its_own() -> None:
    # More than the clock's tick, which is 10 ms.
    busy = "import subprocess, sys, time\nwhile time.process_time() < 0.05: pass\n"
    code = f"{busy}child = subprocess.Popen(['sleep', '60']); print(child.pid, flush=True); sys.stdin.read(); child.kill()"
    with subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        child = used_by_tree(int(parent.stdout.readline()))
        both = used_by_tree(parent.pid)
        assert (child.processes, both.processes) == (1, 2)
        assert both.seconds > child.seconds >= 0.0 and both.memory > child.memory > 0.0
        parent.communicate("")
    assert math.isnan(used_by_tree(parent.pid).seconds)


def test_a_neighbour_is_measured_during_disturbances_of_one_server(monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[object] = []
    monkeypatch.setattr(fairness, "process", lambda work, *arguments: started.append(work) or process(work, *arguments))
    names = ["600/s of a slider", "600/s of the hand", "30/s of the languages", "600/s of a box"]
    found = dict(measure_fairness(0.5, names))
    assert list(found) == names and started.count(serve_app) == 1
    for figures in found.values():
        assert figures["frames_per_s"] > 0.0 and figures["longest_gap_ms"] > 0.0 and figures["longest_work_ms"] > 0.0
        assert figures["fair"] == (figures["frames_per_s"] >= LEAST_FRAMES and figures["longest_gap_ms"] <= 1000.0 * LONGEST_GAP)
