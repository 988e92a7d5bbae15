"""`lwr-duet hunt`: it finds what is broken, says how to repeat it, and finds nothing in our own runs."""

import json
import shlex
from pathlib import Path

import numpy as np
import pytest

from app.cli.main import main
from app.runtime.terminal import INTERRUPTED
from scenes import random_runs
from scenes.promise import Condition, missing
from scenes.random_runs import RandomRun, RunVerdict, explained, random_run, run_verdict
from scenes.room import World, room_of
from scenes.settings import RunSettings
from tests.scenes.test_promise import BETWEEN

pytestmark = pytest.mark.slow


def test_forty_random_runs_break_nothing(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["hunt", "--runs", "40", "--seed", "2", "--seconds", "1.5", "--out", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("40 runs, 0 broken. The law promises d ≥ d_law ≥ d_m in ") and len(lines) == 3


@pytest.mark.usefixtures("interrupted_after_two")
def test_an_interrupted_hunt_says_what_it_has(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["hunt", "--runs", "9", "--seconds", "0.5", "--workers", "1"]) == INTERRUPTED
    said = capsys.readouterr()
    assert said.out.startswith("2 runs, 0 broken.") and said.err.endswith("the runs that were not made are not counted.\n")


def test_the_runs_are_drawn_from_everything() -> None:
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


def test_a_promise_that_a_smaller_step_does_not_mend_is_a_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    """Between two pairs, where the condition is not known that explains it."""
    monkeypatch.setattr(random_runs, "random_run", lambda seed, index: RandomRun(BETWEEN, None))
    assert run_verdict(1, 0, 6.0).faults == ()

    def without(settings: RunSettings, table: np.ndarray) -> dict[Condition, np.ndarray]:
        return {condition: steps for condition, steps in missing(settings, table).items() if condition is not Condition.PAIRS}

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
def test_a_time_step_explains_what_vanishes_with_it(excesses: tuple[float, ...], fine: bool) -> None:
    assert explained(excesses) is fine


def broken_once(seed: int, index: int, seconds: float) -> RunVerdict:
    return RunVerdict(index, ("as an example",) if index == STARTED else (), True, 0.1, (0.0,))


STARTED = next(index for index in range(20) if random_run(1, index).start is not None)


def test_a_broken_run_comes_with_the_command_that_repeats_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr(random_runs, "run_verdict", broken_once)
    options = ("--runs", str(STARTED + 1), "--seconds", "0.2", "--workers", "1", "--out", str(tmp_path))
    assert main(["hunt", *options]) == 1
    found, command, *_ = capsys.readouterr().out.splitlines()
    assert found == f"run {STARTED}: as an example"
    program, *words = shlex.split(command)
    assert program == "lwr-duet"
    assert main([*words, "--csv", str(tmp_path / "again.csv")]) == 0
    summary, drawn = json.loads(capsys.readouterr().out), random_run(1, STARTED)
    again = random_runs.run(drawn.settings, 0.2, start=drawn.start).summary
    assert (summary["d_min"], summary["e2_end"], summary["dq_step_max"]) == (again.d_min, again.e2_end, again.dq_step_max)


@pytest.mark.parametrize(
    ("options", "named"),
    [(("--runs", "0"), "at least 1 run"), (("--seconds", "nan"), "seconds = nan"), (("--out", "/no/such"), "no such folder")],
)
def test_what_cannot_be_hunted(capsys: pytest.CaptureFixture[str], options: tuple[str, ...], named: str) -> None:
    assert main(["hunt", *options]) == 2
    assert named in capsys.readouterr().err
