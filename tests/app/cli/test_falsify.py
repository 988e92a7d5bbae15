"""`lwr-duet falsify`: it finds what the closest pair loses, writes the run, goes on where it was interrupted, and refuses nonsense."""

from pathlib import Path

import pytest

from app.cli.main import main
from app.recording.run_file import load_run
from app.runtime.terminal import INTERRUPTED
from scenes.counterexample import SECONDS

pytestmark = pytest.mark.slow

CLOSEST = ["falsify", "--pairs", "single", "--v", "0.05", "--dt", "0.01"]


def test_the_closest_pair_is_broken_and_its_run_can_be_made_again(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    out = tmp_path / "worst.duet.npz"
    assert main([*CLOSEST, "--starts", "2", "--skip", "6", "--seconds", "600", "--workers", "2", "--out", str(out)]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("2 start postures, ") and lines[1].endswith("Closest pair (paper), v = 0.05 m/s.")
    assert lines[2].startswith("The promise breaks: d_law falls 1") and lines[2].endswith("mm below d_m, at dt and at dt/4.")
    assert lines[3] == "All of this held: w ≤ v, J_d regular, no joint at its limit, an ideal robot."
    assert lines[4].startswith("What was missing: one closest pair.") and lines[-1] == str(out)
    loaded = load_run(out.read_bytes(), out.name)
    assert loaded.verdict == "exact" and loaded.recorded.seconds == pytest.approx(SECONDS)


def test_a_smooth_distance_is_not_broken(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["falsify", "--starts", "3", "--seconds", "600", "--workers", "1", "--dt", "0.01"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[2].startswith("No run broke the promise.") and lines[3].startswith("The nearest approach: d_law − d_m = ")
    assert lines[4].startswith("Lost where a condition was missing: w ≤ v ")


def test_a_law_without_a_promise_breaks_none(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["falsify", "--law", "unprotected", "--starts", "1", "--seconds", "600", "--workers", "1", "--dt", "0.01"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[2] == "This law makes no promise." and lines[3].startswith("d_law falls ")


@pytest.mark.usefixtures("interrupted_after_two")
def test_an_interrupted_search_says_what_it_has_and_how_to_go_on(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*CLOSEST, "--seed", "3", "--starts", "9", "--skip", "5", "--workers", "1"]) == INTERRUPTED
    said = capsys.readouterr()
    assert said.out.startswith("2 start postures, ") and said.err.endswith("Interrupted; --seed 3 --skip 7 goes on from here.\n")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--scene", "solo"], "Nothing is in the way in the scene solo"),
        (["--lag", "0.1"], "The promise is made for an ideal robot"),
        (["--seconds", "0"], "seconds = 0 is out of range; give a number above 0 and up to 86400."),
        (["--seconds", "nan"], "seconds = nan is out of range"),
        (["--workers", "-1"], "workers from 1, or 0 for one a core"),
        (["--starts", "-1"], "starts and skip from 0"),
        (["--out", "nowhere/at/all.npz"], "/nowhere/at; make it first"),
    ],
)
def test_nonsense_is_refused_before_anything_runs(options: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["falsify", *options]) == 2
    said = capsys.readouterr()
    assert message in said.err and said.out == "" and said.err.count("\n") == 1
