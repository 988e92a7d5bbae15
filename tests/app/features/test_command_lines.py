"""Commands of features: refusals in one line, and help texts."""

from pathlib import Path

import pytest

from app.__main__ import run_command as main
from tests.app.cli.test_commands import LONG, assert_said

ERRORS = {
    "sweep --over n=2:3 --n 4 --out {}/new": "n is swept|leave out --over",
    "sweep --over n=2:3 --out {}/hand.csv": "hand.csv is a file; give a folder",
    "league --out {}/hand.csv": "hand.csv is a file; give a folder",
    "bench --steps 0": "--steps must be at least 1",
    "bench --seconds -1": "seconds = -1 is out of range; give a number above 0 and up to 3600.",
    "bench --seconds nan": "seconds = nan is out of range",
    f"grade {LONG}": LONG,
    f"league {LONG}": LONG,
}


@pytest.mark.parametrize("arguments", ERRORS)
def test_one_line_says_what_is_wrong(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: str
) -> None:
    assert_said(capsys, tmp_path, arguments, ERRORS[arguments])


def test_help(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    with pytest.raises(SystemExit, match="0"):
        main(["bench", "--help"])
    said = capsys.readouterr().out
    assert [
        part for part in ("--out", "--compare", "--seconds", "--steps", "--robot") if part not in said
    ] == []
