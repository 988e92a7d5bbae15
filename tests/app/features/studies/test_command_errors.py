"""Wrong options of a search give one line."""

from pathlib import Path

import pytest

from tests.app.cli.test_commands import LONG, assert_said

ERRORS = {
    "hunt --seconds 0": "seconds = 0|above 0 and up to 600.",
    "falsify --out my_law.py": "out = my_law.py|ends in .npz",
    **dict.fromkeys((f"hunt --out {LONG}", f"falsify --out {LONG}/a.npz"), LONG),
}


@pytest.mark.parametrize("arguments", ERRORS)
def test_one_line_says_what_is_wrong(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: str
) -> None:
    assert_said(capsys, tmp_path, arguments, ERRORS[arguments])
