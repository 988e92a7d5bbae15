"""Grids of settings: values are checked first, and figures do not depend on the number of workers."""

import itertools
import math
import multiprocessing
import os
import select
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.errors import BadSetting, DuetError
from scenes.children import AHEAD, ONE_THREAD, computed
from scenes.headless import run
from scenes.settings import LATER, RunSettings, changed, specs, values
from scenes.sweep import (
    FIGURES,
    MOST_POINTS,
    TRADE_OFF_ORDERS,
    TRADE_OFF_VELOCITIES,
    Axis,
    Grid,
    is_scale,
    read_axis,
    read_grid,
    run_points,
    sweep_figures,
    trade_off,
)

pytestmark = pytest.mark.slow

USUAL = RunSettings()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("n=1:20", tuple(float(n) for n in range(1, 21))), ("n=1:3.0", (1.0, 2.0, 3.0)), ("seed=3:6", (3, 4, 5, 6)),
        ("v=0.05:0.6:12", (0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6)),
        ("dm = 0.05 : 0.15 : 3", (0.05, 0.1, 0.15)), ("seed=1:9:3", (1, 5, 9)), ("n=8, 2,4", (8.0, 2.0, 4.0)),
        ("n=4", (4.0,)), ("law=unprotected,smooth_priority", ("unprotected", "smooth_priority")), ("ff=0,1", (False, True)),
        ("one-sided=on", (True,)),
    ],
)  # fmt: skip
def test_axis(text: str, expected: tuple[object, ...]) -> None:
    axis = read_axis(text, USUAL)
    assert axis.values == expected and list(map(type, axis.values)) == list(map(type, expected))
    assert is_scale(axis) is (type(expected[0]) in (int, float))


@given(st.floats(0.0, 0.9), st.floats(0.01, 0.1), st.integers(2, 40))
def test_evenly_spaced_values_rise_from_end_to_end(first: float, width: float, count: int) -> None:
    first, last = round(first, 6), round(first + width, 6)
    found = read_axis(f"v={first!r}:{last!r}:{count}", USUAL).values
    assert len(found) == count and found[0] == first and found[-1] == last
    steps = [b - a for a, b in itertools.pairwise(found)]
    assert all(
        math.isclose(step, (last - first) / (count - 1), rel_tol=1e-6, abs_tol=1e-11) for step in steps
    )


def test_every_setting_can_be_swept() -> None:
    for key, spec in specs(RunSettings).items():
        if spec.choices:
            assert read_axis(f"{key}={','.join(spec.choices)}", USUAL).values == spec.choices
        elif spec.read is not None:
            assert read_axis(f"{key}=0:1,0.1:0; 0:1,0.2:0", USUAL).values == ("0:1,0.1:0", "0:1,0.2:0")
        elif isinstance(values(USUAL)[key], bool):
            assert read_axis(f"{key}=off,on", USUAL).values == (False, True)
        else:
            assert read_axis(f"{key}={spec.low:g}:{spec.high:g}:2", USUAL).values == (spec.low, spec.high)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("n", ["'n'", "key=a:b", "key=x,y,z", "n=1:20"]), *((text, ["key=a:b"]) for text in ("n=", "=1:3")),
        ("zz=1:3", ["'zz'", "choose from", "dm"]), ("n=1:2:3:4", ["key=a:b:count"]),
        *((text, ["must be numbers"]) for text in ("n=1:x", "n=1:")),
        *((text, ["cannot be read"]) for text in ("n=1:nan", "n=1:inf")), ("n=5:1", ["upwards", "5"]), ("n=5:5", ["upwards"]),
        ("v=0.1:0.5", ["whole numbers", "v=0.1:0.5:12"]),
        *((f"n=1:5:{count}", ["count", shown]) for count, shown in (("1", "from 2"), ("2.5", "2.5"), ("-3", "-3"))),
        ("v=0:1:1e9", ["1e+09", str(MOST_POINTS)]), ("seed=1:1e12", ["at most"]), ("n=0:3", ["n = 0.0", "1 to 20"]),
        ("n=1,,3", ["n = ''", "1 to 20"]), ("n=2,2.0", ["twice"]), ("seed=1:2:3", ["whole number"]),
        ("law=smooth_priority,strict", ["law = 'strict'", "unprotected"]), ("law=1:2", ["not a number", "smooth_priority"]),
        ("ff=0:1", ["not a number", "ff=0,1"]), ("ff=maybe", ["neither on nor off"]),
    ],
)  # fmt: skip
def test_a_bad_axis_is_refused_in_one_line(text: str, named: list[str]) -> None:
    with pytest.raises(BadSetting) as error:
        read_axis(text, USUAL)
    assert all(part in str(error.value) for part in named) and "\n" not in str(error.value), error.value


def test_grids_and_their_figures() -> None:
    grid = read_grid(changed(USUAL, "k", 3.0), ["n=2,4", "pairs=single,soft", "v=0.1:0.3:3"], 0.02)
    assert grid.shape == (2, 2, 3) and grid.size == 12
    points = grid.points()
    assert points[:4] == [
        (2.0, "single", 0.1),
        (2.0, "single", 0.2),
        (2.0, "single", 0.3),
        (2.0, "soft", 0.1),
    ]
    at = values(grid.at(points[4]))
    assert (at["n"], at["pairs"], at["v"], at["k"]) == (2.0, "soft", 0.2, 3.0)
    assert grid.fixed() == {key: value for key, value in at.items() if key not in ("n", "pairs", "v", *LATER)}
    settings = changed(changed(USUAL, "n", 3.0), "pairs", "single")
    summary = run(settings, 8.0).summary
    assert sweep_figures(settings, 8.0) == tuple(getattr(summary, name) for name in FIGURES)
    assert "step_us_median" not in FIGURES and summary.e2_max > 0.0
    grid = Grid(USUAL, (Axis("v", (0.1, 0.2)),), 0.01)
    assert [index for index, _ in run_points(grid, [0, 1])] == [0, 1]
    grid = read_grid(USUAL, ["n=1:6"], 0.05)
    assert [index for index, _ in run_points(grid, [4, 1])] == [4, 1]
    assert list(run_points(grid, [], partial(computed, workers=2))) == []


@pytest.mark.parametrize(
    ("over", "seconds", "named"),
    [
        ([], 1.0, ["--over", "key=a:b"]),
        (["n=1:2", "n=3:4"], 1.0, ["n is swept twice"]),
        (["seed=0:200", "n=1:20", "v=0:1:11"], 1.0, ["44220 points", "20000"]),
        (["n=1:2"], 0.0, ["seconds = 0", "5000"]),
        (["n=1:2"], math.nan, ["seconds = nan"]),
        # 2000 s are only possible with the larger time step.
        (["dt=0.00125,0.02"], 2000.0, ["seconds = 2000", "1250"]),
    ],
)
def test_an_impossible_grid_is_refused(over: list[str], seconds: float, named: list[str]) -> None:
    with pytest.raises(BadSetting) as error:
        read_grid(USUAL, over, seconds)
    assert all(part in str(error.value) for part in named), error.value


def test_two_workers_and_one_give_the_same_figures() -> None:
    grid = read_grid(USUAL, ["n=1,4,16", "pairs=single,soft"], 6.0)
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    handler = signal.getsignal(signal.SIGINT)
    alone = list(run_points(grid, range(grid.size)))
    assert [index for index, _ in alone] == list(range(grid.size))
    together: dict[int, tuple[float, ...]] = {}
    for index, found in run_points(grid, range(grid.size), partial(computed, workers=2)):
        assert 1 <= len(multiprocessing.active_children()) <= 2
        together[index] = found
    assert together == dict(alone) and len(set(together.values())) == grid.size
    # Workers, environment and signal handler are restored.
    assert multiprocessing.active_children() == []
    assert {name: os.environ.get(name) for name in ONE_THREAD} == before
    assert signal.getsignal(signal.SIGINT) is handler


def test_calls_are_drawn_shortly_before_use_and_workers_stop() -> None:
    count = itertools.count()
    found = computed(abs, ((next(count),) for _ in range(10**6)), 2)
    first = dict(next(found) for _ in range(5))
    drawn = next(count)
    assert multiprocessing.active_children()
    found.close()  # pyright: ignore[reportAttributeAccessIssue]
    assert multiprocessing.active_children() == []
    assert all(index == value for index, value in first.items())
    # At most the running calls, those finished before, and those already taken.
    assert drawn <= 2 * (2 * AHEAD) + 5


def test_the_end_of_a_worker_is_reported() -> None:
    points = run_points(read_grid(USUAL, ["seed=1:200"], 2.0), range(200), partial(computed, workers=2))
    next(points)
    victim = multiprocessing.active_children()[0]
    assert victim.pid is not None
    os.kill(victim.pid, signal.SIGKILL)
    with pytest.raises(DuetError, match="same command again"):
        list(points)


ORPHANS = """
import multiprocessing
from functools import partial
from scenes.children import computed
from scenes.sweep import read_grid
from scenes.settings import RunSettings
from scenes.sweep import run_points
points = run_points(read_grid(RunSettings(), ["seed=1:300"], 1.0), range(300), partial(computed, workers=2))
next(points)
print(*(child.pid for child in multiprocessing.active_children()), flush=True)
for _ in points:
    pass
"""


@pytest.mark.thorough
@pytest.mark.skipif(
    not hasattr(os, "pidfd_open"), reason="needs Linux, to wait for a process that is not ours"
)
def test_workers_do_not_outlive_a_parent_that_is_killed() -> None:
    command, home = [sys.executable, "-c", ORPHANS], Path(__file__).parents[2]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, cwd=home
    ) as parent:
        try:
            assert parent.stdout is not None
            workers = [os.pidfd_open(int(pid)) for pid in parent.stdout.readline().split()]
            assert workers
        finally:
            parent.kill()
        try:
            # A pidfd becomes readable when its process ends.
            ended = [worker for worker in workers if select.select([worker], [], [], 120.0)[0]]
            assert ended == workers
        finally:
            for worker in workers:
                os.close(worker)


def test_trade_off_maps() -> None:
    assert len(set(itertools.product(TRADE_OFF_ORDERS, TRADE_OFF_VELOCITIES))) == 25
    chosen, orders = changed(changed(USUAL, "k", 3.0), "dt", 0.02), (2.0, 8.0)
    found = [point for order in orders for point in trade_off(chosen, 8.0, order)]
    assert [(point.order, point.nominal_velocity) for point in found] == list(
        itertools.product(orders, TRADE_OFF_VELOCITIES)
    )
    for point in found[::3]:
        summary = run(changed(changed(chosen, "n", point.order), "v", point.nominal_velocity), 8.0).summary
        assert (point.d_min, point.e2_max) == (summary.d_min, summary.e2_max)
    # There is a trade-off: more distance costs more error.
    by_distance = sorted(found, key=lambda point: point.d_min)
    assert by_distance[0].e2_max < by_distance[-1].e2_max


def test_a_script_without_a_main_guard_gets_an_explanation(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "from scenes.children import computed\nprint(list(computed(abs, [(1,), (2,)], 2)))\n",
        encoding="utf-8",
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=120, check=False)
    assert 'could not start; in a script, compute below if __name__ == "__main__":' in done.stderr
