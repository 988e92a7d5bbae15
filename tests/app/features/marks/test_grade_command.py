"""`lwr-duet grade` with nothing to grade, unwritable places and damaged archives."""

import sys
import zipfile
from functools import partial
from pathlib import Path

import pytest

from app.__main__ import run_command as main
from app.features.marks.fence import FenceLimits
from tests.app.features.marks.helpers import LAW, posix
from tests.approved import Approve

pytestmark = [pytest.mark.slow, posix, pytest.mark.usefixtures("nothing_is_left")]


def test_less_isolation_is_announced_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], approve: Approve
) -> None:
    monkeypatch.setattr("app.features.marks.fence.FenceLimits", partial(FenceLimits, isolated=False))
    for name in ("a.py", "b.py"):
        (tmp_path / name).write_text("1/0", encoding="utf-8")
    assert main(["grade", str(tmp_path), "--csv", str(tmp_path / "marks.csv")]) == 0
    said = [line for line in capfd.readouterr().err.splitlines() if line.startswith("lwr-duet: ")]
    approve("isolation.txt", "".join(f"{line}\n" for line in said))


def refusals(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> str:
    """Messages since the last call, without the name of `tmp_path`."""
    return capsys.readouterr().err.replace(str(tmp_path), "…")


def test_nothing_to_grade(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, approve: Approve
) -> None:
    monkeypatch.chdir(tmp_path)
    for arguments in (["."], ["no"], [".", "--jobs", "-1"], [".", "--points", "1", "2"]):
        assert main(["grade", *arguments]) == 2
    (tmp_path / "a.py").touch()
    assert main(["grade", str(tmp_path), "--csv", str(tmp_path / "no" / "a.csv")]) == 2
    approve("nothing to grade.txt", refusals(capsys, tmp_path))


def test_an_unwritable_place_is_named_before_the_first_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, approve: Approve
) -> None:
    monkeypatch.setattr("app.features.marks.command._graded", lambda *given: pytest.fail("a file was graded"))
    law = tmp_path / "a.py"
    law.touch()
    for option in ("csv", "moodle", "canvas", "gradescope"):
        for place in (tmp_path, *(Path("/proc/x"),) * (sys.platform == "linux")):
            assert main(["grade", str(tmp_path), f"--{option}", str(place)]) == 2
            assert f"{option} = {place}: cannot be written" in capsys.readouterr().err
    assert main(["grade", str(tmp_path), "--csv", str(tmp_path / "marks.csv"), "--feedback", str(law)]) == 2
    approve("feedback is a file.txt", refusals(capsys, tmp_path))
    assert list(tmp_path.iterdir()) == [law]


def test_a_damaged_archive_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], approve: Approve
) -> None:
    given = tmp_path / "class.zip"
    for method, place, damage in (
        # An LZMA header with invalid properties; sizes of a part in the directory.
        (zipfile.ZIP_LZMA, b"a.py", bytes((9, 4, 5, 0, 255))),
        (zipfile.ZIP_STORED, b"PK\x01\x02", b"\0" * 16 + 2 * (2**20).to_bytes(4, "little")),
    ):
        with zipfile.ZipFile(given, "w", method) as archive:
            archive.writestr("a.py", LAW)
        data = given.read_bytes()
        at = data.index(place) + 4
        given.write_bytes(data[:at] + damage + data[at + len(damage) :])
        assert main(["grade", str(given), "--csv", str(tmp_path / "a.csv")]) == 2
        approve("damaged archive.txt", refusals(capsys, tmp_path))
