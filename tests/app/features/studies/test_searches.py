"""`lwr-duet hunt` and `falsify`: reproducible faults, none in our own runs, and continuation after Ctrl+C."""

import hashlib
import json
import re
import shlex
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from app.__main__ import run_command as main
from app.features.studies import counterexample
from app.features.studies.counterexample import BROKEN, LEGS, SECONDS, attack_of, searched
from app.recording.run_file import load_run
from app.runtime.terminal import INTERRUPTED
from controllers import compiled
from scenes import children, random_runs
from scenes.experiments import Series
from scenes.history import COLUMN
from scenes.promise import Condition, missing
from scenes.quantities import DISTANCE, FIRST_TASKS
from scenes.random_draws import RandomRun, random_run
from scenes.random_runs import RunVerdict, explained, run_verdict
from scenes.recording import Recording
from scenes.roles import room_of
from scenes.room import World
from scenes.settings import LATER, RunSettings, values
from scenes.simulation import Simulation
from scenes.targets import OF_HAND, OF_WALL
from scenes.world_stages import WorldStage
from tests.approved import Approve
from tests.scenes.helpers import given_settings
from tests.scenes.test_promise import BETWEEN

pytestmark = pytest.mark.slow


def interrupted(compute: Callable[..., Iterator[Any]], after: int) -> Callable[..., Iterator[Any]]:
    """The same, interrupted by Ctrl+C after `after` computations."""

    def some(*arguments: Any) -> Iterator[Any]:
        for done, found in enumerate(compute(*arguments)):
            if done == after:
                raise KeyboardInterrupt
            yield found

    return some


@pytest.fixture
def interrupted_after_two(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(children, "computed", interrupted(children.computed, 2))


@pytest.mark.thorough
def test_forty_random_runs_break_nothing(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["hunt", "--runs", "40", "--seed", "2", "--seconds", "1.5", "--out", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("40 runs, 0 broken. The law promises d ≥ d_law ≥ d_m in ") and len(lines) == 3


@pytest.mark.usefixtures("interrupted_after_two")
def test_an_interrupted_hunt_reports_its_results(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["hunt", "--runs", "9", "--seconds", "0.5", "--workers", "1"]) == INTERRUPTED
    said = capsys.readouterr()
    assert said.out.startswith("2 runs, 0 broken.") and said.err.endswith(
        "the runs that were not made are not counted.\n"
    )


def test_random_runs_cover_all_scenes_pairs_and_robots() -> None:
    drawn = [random_run(1, index) for index in range(60)]
    for index in (0, 7):
        again = random_run(1, index)
        assert again.settings == drawn[index].settings and repr(again.start) == repr(drawn[index].start)
    assert random_run(2, 0).settings != drawn[0].settings
    assert {run.settings.scene for run in drawn} == {"solo", "ball", "hold", "master_slave", "imitation"}
    assert {run.settings.law.pairs for run in drawn} == {"single", "soft", "smooth"}
    assert {run.settings.robot for run in drawn} >= {"lwr", "panda", "ur5"}
    overlapping = 0
    for run in drawn:
        if run.start is not None:
            world = World(room_of(run.settings), 10.0)
            world.kinematics.update(run.start)
            overlapping += world.detector.detect().distance < 0.0
    assert overlapping >= 5


def test_the_usual_series_of_a_seed_never_changes() -> None:
    """Bit for bit, whatever other series draw; settings added later are not drawn."""
    drawn = [random_run(7, index) for index in range(20)]
    assert all(values(one.settings)[key] == usual for one in drawn for key, usual in LATER.items())
    known = [
        [(key, value) for key, value in values(one.settings).items() if key not in LATER] for one in drawn
    ]
    said = repr([known, [None if one.start is None else one.start.tolist() for one in drawn]])
    assert hashlib.sha256(said.encode()).hexdigest()[:16] == "bda414a7dfdfd4ed"


def test_random_runs_cover_all_first_tasks_and_begin_above_the_threshold() -> None:
    drawn = [random_run(1, index, "first-tasks") for index in range(60)]
    again = random_run(1, 7, "first-tasks")
    assert again.settings == drawn[7].settings and repr(again.start) == repr(drawn[7].start)
    assert {one.settings.first for one in drawn} == set(FIRST_TASKS)
    assert {one.settings.together for one in drawn} == {"ratios", "stages"}
    assert {one.settings.world for one in drawn} == {one.hand is None for one in drawn} == {True, False}
    near = 0
    for one in drawn:
        simulation = Simulation(one.settings)
        if one.start is not None:
            simulation.reset(one.start)
        assert simulation.start_problem is None
        near += simulation.sample().distance < one.settings.law.critical_distance + 0.05
    assert near > 10


def test_some_runs_of_first_tasks_break_nothing(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    options = ("--runs", "8", "--seconds", "1", "--workers", "1", "--out", str(tmp_path))
    assert main(["hunt", "--series", "first-tasks", *options]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("8 runs, 0 broken. The law promises h ≥ h_law ≥ h_m in ")
    units = [
        re.fullmatch(r"It falls there by more than 0\.01 (.+?) with every .*", line) for line in lines[2:-1]
    ]
    known = {kept.page_unit for kept in FIRST_TASKS.values()}
    assert {unit[1] for unit in units if unit} <= known and all(units)


@pytest.mark.thorough
@pytest.mark.parametrize("series", ["first-tasks", "world"])
def test_forty_runs_of_a_series_break_nothing(series: str, tmp_path: Path) -> None:
    options = ("--runs", "40", "--seed", "2", "--seconds", "3", "--out", str(tmp_path))
    assert main(["hunt", "--series", series, *options]) == 0


def test_an_arm_that_does_not_glide_is_detected_inside_an_obstacle(monkeypatch: pytest.MonkeyPatch) -> None:
    compiled.load_now()
    below = Recording(np.zeros(1), np.array([[0.3, 0.25, 0.3]]))
    settings = given_settings(rig="table", world=True, wmax=0.5, dt=0.01)
    monkeypatch.setattr(random_runs, "random_run", lambda *_: RandomRun(settings, None, below))
    kept = run_verdict(1, 0, 3.0, "world")
    assert 0.02 < kept.clear < 0.05 and kept.faults == ()
    monkeypatch.setattr(WorldStage, "keep", lambda self, velocities: None)
    entered = run_verdict(1, 0, 3.0, "world")
    (fault,) = entered.faults
    assert entered.clear < -0.01 and fault.startswith("an arm is inside of something, by ")


def test_a_broken_promise_that_a_smaller_step_does_not_repair_is_a_fault(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Between two pairs, without the condition that explains it."""
    monkeypatch.setattr(random_runs, "random_run", lambda *_: RandomRun(BETWEEN, None))
    assert run_verdict(1, 0, 6.0).faults == ()

    def without(settings: RunSettings, table: np.ndarray) -> dict[Condition, np.ndarray]:
        return {
            condition: steps
            for condition, steps in missing(settings, table).items()
            if condition is not Condition.PAIRS
        }

    monkeypatch.setattr("scenes.promise.missing", without)
    (fault,) = run_verdict(1, 0, 6.0).faults
    assert fault.startswith("d_law falls below d_m with every condition met, by 42.")


@pytest.mark.parametrize(
    ("excesses", "fine"),
    [
        ((1e-6,), True),
        ((8e-4, 4e-4, 2e-4, 1e-4), True),
        ((8e-4, 0.0, 0.0, 9e-4, 4e-4, 2e-4), True),
        ((8e-4, 8e-4, 8e-4, 8e-4), False),
        ((8e-4, 0.0, 7e-4, 0.0), False),
        ((1e-4, 2e-4, 4e-4, 8e-4, 16e-4, 32e-4), False),
    ],
)
def test_an_excess_that_vanishes_with_the_time_step_is_explained_by_it(
    excesses: tuple[float, ...], fine: bool
) -> None:
    assert explained(excesses) is fine


def started(series: Series) -> int:
    """First run with its own start posture and, in other series than the usual one, its own hand path."""
    drawn = ((index, random_run(1, index, series)) for index in range(40))
    return next(
        index for index, one in drawn if one.start is not None and (series == "usual" or one.hand is not None)
    )


@pytest.mark.parametrize("series", ["usual", "first-tasks", "world"])
def test_a_broken_run_comes_with_the_command_that_repeats_it(
    series: Series, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    broken = started(series)

    def broken_once(seed: int, index: int, seconds: float, series: Series) -> RunVerdict:
        faults = ("as an example",) if index == broken else ()
        return RunVerdict(index, faults, True, 0.1, (0.0,), DISTANCE)

    monkeypatch.setattr(random_runs, "run_verdict", broken_once)
    options = ("--runs", str(broken + 1), "--seconds", "0.2", "--workers", "1", "--out", str(tmp_path))
    assert main(["hunt", "--series", series, *options]) == 1
    found, command, *_ = capsys.readouterr().out.splitlines()
    assert found == f"run {broken}: as an example"
    program, *words = shlex.split(command)
    assert program == "lwr-duet"
    assert main([*words, "--csv", str(tmp_path / "again.csv")]) == 0
    summary, drawn = json.loads(capsys.readouterr().out), random_run(1, broken, series)
    again = random_runs.run(drawn.settings, 0.2, drawn.hand, drawn.start).summary
    assert (summary["d_min"], summary["e2_end"], summary["dq_step_max"]) == (
        again.d_min,
        again.e2_end,
        again.dq_step_max,
    )


CLOSEST = ["falsify", "--pairs", "single", "--v", "0.05", "--dt", "0.01", "--workers", "1"]


@pytest.mark.thorough
def test_the_closest_pair_breaks_and_its_run_can_be_repeated(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "worst.duet.npz"
    assert main([*CLOSEST, "--starts", "1", "--skip", "6", "--seconds", "600", "--out", str(out)]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("1 start postures, ") and lines[1].endswith(
        "Closest pair (paper), v = 0.05 m/s."
    )
    # About 100 mm, as in lesson 10.
    fall = re.fullmatch(
        r"The promise breaks: d_law falls ([\d.]+) mm below d_m, at dt and at dt/4\.", lines[2]
    )
    assert fall is not None and float(fall[1]) > 80.0
    assert lines[3] == "All of this held: w ≤ v, J_d regular, no joint at its limit, an ideal robot."
    assert lines[4].startswith("What was missing: one closest pair.") and lines[-1] == str(out)
    loaded = load_run(out.read_bytes(), out.name)
    assert loaded.verdict == "exact" and loaded.recorded.seconds == pytest.approx(SECONDS)


def test_a_smooth_distance_is_not_broken(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["falsify", "--starts", "3", "--seconds", "600", "--workers", "1", "--dt", "0.01"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[2].startswith("No run broke the promise.") and lines[3].startswith(
        "The nearest approach: d_law − d_m = "
    )
    assert lines[4].startswith("Lost where a condition was missing: w ≤ v ")


@pytest.mark.thorough
def test_a_law_without_a_promise_breaks_no_promise(capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        main(
            [
                "falsify",
                "--law",
                "unprotected",
                "--starts",
                "1",
                "--seconds",
                "600",
                "--workers",
                "1",
                "--dt",
                "0.01",
            ]
        )
        == 1
    )
    lines = capsys.readouterr().out.splitlines()
    assert lines[2] == "This law makes no promise." and lines[3].startswith("d_law falls ")


@pytest.mark.parametrize(
    ("first", "rate", "least"),
    [
        ("wall", "v = 0.3 m/s.", r"d_law − d_m = [\d.]+ mm\."),
        ("stops", "v = 0.3 rad/s.", r"h_law − h_m = [\d.]+ mrad\."),
        ("singular", "v = 0.3 m/rad/s.", r"σ_law − σ_m = [\d.]+ mm/rad\."),
    ],
)
def test_another_first_task_is_searched_in_its_unit(
    first: str, rate: str, least: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "worst.duet.npz"
    options = ("--starts", "1", "--seconds", "600", "--workers", "1", "--dt", "0.02", "--out", str(out))
    assert main(["falsify", "--scene", "first_task", "--first", first, *options]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert FIRST_TASKS[first].label in lines[1] and lines[1].endswith(rate)
    assert lines[2].startswith("No run broke the promise.")
    assert re.fullmatch(f"The nearest approach: {least}", lines[3])
    assert load_run(out.read_bytes(), out.name).verdict == "exact"


def test_without_a_law_a_first_task_is_lost(capsys: pytest.CaptureFixture[str]) -> None:
    options = ("--starts", "1", "--seconds", "600", "--workers", "1", "--dt", "0.02", "--law", "unprotected")
    assert main(["falsify", "--scene", "first_task", "--first", "stops", *options]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert re.fullmatch(r"h_law falls [\d.]+ mrad below h_m, at dt and at dt/4\.", lines[3])


def test_a_path_of_a_wall_and_a_hand_is_read_from_its_link() -> None:
    settings = given_settings(scene="first_task", dt=0.02)
    attack = searched(settings, 1, 0, 0.0).attack
    again = attack_of(settings, attack.text())
    assert attack.points.shape == (LEGS + 1, 8) and again.text() == attack.text()
    table, room = attack.table(), room_of(settings)
    assert room.wall is not None and np.ptp(table[:, COLUMN["w"]]) > 0.0
    # Wall and hand each begin at their start position and move independently.
    assert_allclose(attack.points[0, OF_WALL], attack.start[room.wall], atol=1e-4)
    for moved in (OF_WALL, OF_HAND):
        points = attack.points.copy()
        points[:, moved] = points[0, moved]
        other = replace(attack, points=points).tables()[0]
        assert np.abs(other - table)[:, COLUMN["e2"]].max() > 1e-4, "its movement must change the run"


def test_a_wall_faster_than_v_wins_and_the_speed_is_named() -> None:
    settings = given_settings(scene="first_task", dt=0.02, v=0.05, wmax=1.0)
    found = [searched(settings, 1, index, 0.0) for index in range(3)]
    assert max(one.missing[Condition.SPEED] for one in found) > 0.02
    assert max(one.loss.lost for one in found) < BROKEN


@pytest.mark.parametrize(("law", "code"), [("unprotected", 1), ("smooth_priority", 0)])
def test_each_stage_is_checked_and_the_broken_one_named(
    law: str, code: int, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(counterexample, "REFINEMENTS", 1)
    options = ("--together", "stages", "--starts", "1", "--seconds", "600", "--workers", "1", "--dt", "0.02")
    assert main(["falsify", "--scene", "first_task", "--first", "all", "--law", law, *options]) == code
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].endswith("by stages, v = 0.3 m/s, rad/s.")
    assert lines[2] == "Each stage is checked: A wall, Out of singularity, Joint stops, Not to tip."
    if code:
        # The later stages use the paper's own law.
        assert re.fullmatch(r"A wall: d falls [\d.]+ mm below d_m, at dt and at dt/4\.", lines[4])
        assert lines[5].endswith("an ideal robot, no later stage acting against it.")
    else:
        assert lines[3].startswith("No run broke the promise.")
        assert re.fullmatch(
            r"The nearest approach: [A-Z][a-z ]+: . − ._m = [\d.]+ m(?:m|rad|m/rad)\.", lines[4]
        )


@pytest.mark.thorough
@pytest.mark.usefixtures("interrupted_after_two")
def test_an_interrupted_search_reports_its_results_and_how_to_continue(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main([*CLOSEST, "--seed", "3", "--starts", "9", "--skip", "5"]) == INTERRUPTED
    said = capsys.readouterr()
    assert said.out.startswith("2 start postures, ") and said.err.endswith(
        "Interrupted; --seed 3 --skip 7 continues from here.\n"
    )


REFUSED: tuple[str, ...] = (
    "hunt --runs 0",
    "hunt --seconds nan",
    "hunt --out /no/such",
    "falsify --scene solo",
    "falsify --scene first_task --first tip --dm 0.3",
    "falsify --lag 0.1",
    "falsify --seconds 0",
    "falsify --seconds nan",
    "falsify --workers -1",
    "falsify --starts -1",
    "falsify --out nowhere/at/all.npz",
)


def test_invalid_options_are_refused_before_anything_runs(
    approve: Approve, capsys: pytest.CaptureFixture[str]
) -> None:
    lines: list[str] = []
    for arguments in REFUSED:
        assert main(arguments.split()) == 2
        said = capsys.readouterr()
        assert said.out == "" and said.err.count("\n") == 1
        lines.append(f"{arguments}\n    {said.err.replace(str(Path.cwd()), '…')}")
    approve("refused searches.txt", "".join(lines))
