"""Invalid options of lessons give a one-line message."""

from pathlib import Path

import pytest

from tests.app.cli.test_commands import LONG, assert_said

ERRORS = {
    "lessons --only nonsense": "1 redundancy",
    f"lessons --check --out {LONG}/a.html": LONG,
    **dict.fromkeys((f"serve --lessons {LONG}", f"serve --playlist {LONG}"), LONG),
}


@pytest.mark.parametrize("arguments", ERRORS)
def test_one_line_says_what_is_wrong(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: str
) -> None:
    assert_said(capsys, tmp_path, arguments, ERRORS[arguments])
