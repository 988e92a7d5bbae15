"""`lwr-duet bench`: a step and one visitor, as a table, a file and ratios."""

import json
import math
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.__main__ import run_command as main
from app.features.bench.figures_table import printed
from app.features.bench.process_use import used_by_tree

pytestmark = pytest.mark.thorough


def test_a_row_is_printed_before_the_next_one_is_measured(capsys: pytest.CaptureFixture[str]) -> None:
    seen: list[str] = []

    def rows() -> Iterator[tuple[str, dict[str, float]]]:
        for name in ("first", "second"):
            seen.append(capsys.readouterr().out)
            yield name, {"frames_per_s": 60.0}

    assert list(printed(rows())["figures"]) == ["first", "second"]
    assert seen == ["", f"{'first':36s} frames_per_s 60.0\n"]


needs_proc = pytest.mark.skipif(not Path("/proc").exists(), reason="CPU and memory are read from /proc")


@needs_proc
def test_cpu_time_of_child_processes_is_counted() -> None:
    # More than the clock's tick of 10 ms.
    busy = "import subprocess, sys, time\nwhile time.process_time() < 0.05: pass\n"
    code = f"{busy}child = subprocess.Popen(['sleep', '60']); print(child.pid, flush=True); sys.stdin.read(); child.kill()"
    with subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as parent:
        assert parent.stdout is not None
        child = used_by_tree(int(parent.stdout.readline()))
        both = used_by_tree(parent.pid)
        assert (child.processes, both.processes) == (1, 2)
        assert both.seconds > child.seconds >= 0.0 and both.memory > child.memory > 0.0
        parent.communicate("")
    assert math.isnan(used_by_tree(parent.pid).seconds)


def test_the_command_measures_the_step_and_one_visitor(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, before = tmp_path / "figures.json", tmp_path / "before.json"
    before.write_text(
        '{"version": "0.0", "figures": {"one visitor": {"frames_per_s": 1.0}}}', encoding="utf-8"
    )
    assert (
        main(["bench", "--steps", "1", "--seconds", "0.5", "--out", str(out), "--compare", str(before)]) == 0
    )
    figures = json.loads(out.read_text(encoding="utf-8"))["figures"]
    steps = {name: row for name, row in figures.items() if "median_us" in row}
    assert list(figures)[len(steps) :] == ["one visitor", "one visitor, ghost and four plots"]
    assert "hold, smooth everywhere" in steps and all(row["median_us"] > 0.0 for row in steps.values())
    for name in figures.keys() - steps.keys():
        assert figures[name]["frames_per_s"] > 0.0 and figures[name]["arms_s"] > 0.0, name
    table, ratios = capsys.readouterr().out.split("\n\nratio to version 0.0\n")
    assert [line[:36].rstrip() for line in table.splitlines()] == list(figures)
    assert (
        f"{'one visitor':36s} frames_per_s {figures['one visitor']['frames_per_s']:.2f}x"
        in ratios.splitlines()
    )
