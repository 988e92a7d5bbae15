"""Options of `lwr-duet run`: start postures in all formats, refused files, and robots."""

import json
from pathlib import Path

import numpy as np
import pytest

from app.__main__ import run_command as main
from app.cli.options import RunOptions, settings_of_options
from app.settings import Settings, from_query, to_query
from scenes.ball import build_ball_room
from scenes.room import build_room
from scenes.settings import RunSettings
from scenes.starts import BETWEEN, read_start

ROOM = build_room("torso")
NAMES = ",".join(column.format("q") for column in ROOM.columns)
POSTURE = BETWEEN.tolist()
COMMAS = ",".join(map(str, POSTURE))


@pytest.mark.parametrize(
    "text",
    [
        COMMAS,
        " ".join(map(str, POSTURE)) + "\n",
        "# a posture\n" + "\n".join(map(str, POSTURE)) + "\n\n",
        f"{NAMES}\n{COMMAS}\n",
        f"t,pair,{NAMES}\n0.0,left hand / right hand,{COMMAS}\n",
        "\ufeff" + NAMES.replace(",", " ") + "\n" + COMMAS.replace(",", " "),
    ],
)
def test_every_format_of_a_posture_is_read(tmp_path: Path, text: str) -> None:
    file = tmp_path / "start.txt"
    file.write_text(text, encoding="utf-8")
    assert read_start(file, ROOM).tolist() == POSTURE


def test_a_run_begins_at_the_posture_of_its_file(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """A file with the built-in posture gives the same run, and its name is in the output."""
    file = tmp_path / "start.txt"
    file.write_text(COMMAS)
    tables = []
    for start in (str(file), "between"):
        out = tmp_path / "out.csv"
        assert (
            main(["run", "--seconds", "0.3", "--avoid", "guided", "--start", start, "--csv", str(out)]) == 0
        )
        capsys.readouterr()
        lines = out.read_text().splitlines()
        tables.append([line for line in lines if not line.startswith("#")])
        assert ("# start_file = start.txt" in lines) == (start != "between")
    assert tables[0] == tables[1]


def test_the_ball_has_a_start_too(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    room = build_ball_room()
    file, start = tmp_path / "start.txt", room.start + 0.01
    np.savetxt(file, start)
    assert main(["run", "--scene", "ball", "--seconds", "0.01", "--start", str(file)]) == 0
    moved = json.loads(capsys.readouterr().out)["d_min"]
    assert main(["run", "--scene", "ball", "--seconds", "0.01"]) == 0
    assert moved != json.loads(capsys.readouterr().out)["d_min"]


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "has 0 numbers, but 14 joints move: left_q1,"),
        ("0.1 0.2", "has 2 numbers, but 14 joints move"),
        (COMMAS + ",0.0", "has 15 numbers"),
        (f"{COMMAS}\n{COMMAS}", "has 2 lines of numbers; give one line or one column"),
        (COMMAS.replace("0.9", "nan", 1), "left_q1 = nan is not finite"),
        (COMMAS.replace("0.9", "inf", 1), "left_q1 = inf is not finite"),
        (COMMAS.replace("0.9", "x", 1), "left_q1 = 'x' is not a number"),
        (COMMAS.replace("1.48", "148", 1), "left_q2 = 148 is outside its limits; give -2.0944 to 2.0944 rad"),
        (f"{NAMES}\n{COMMAS}\n{COMMAS}", "give one row of 14 values"),
        (NAMES, "give one row of 14 values"),
        (f"{NAMES[9:]}\n{COMMAS}", "has no column left_q1"),
    ],
)
def test_a_bad_posture_is_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, text: str, named: str
) -> None:
    file = tmp_path / "start.txt"
    file.write_text(text)
    assert main(["run", "--seconds", "0.1", "--start", str(file)]) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and len(captured.err.splitlines()) == 1
    assert named in captured.err


def test_unreadable_start_files_are_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "bytes").write_bytes(bytes(range(128, 256)))
    for path, named in (
        (tmp_path / "no", "no such file"),
        (tmp_path, "a folder"),
        (tmp_path / "bytes", "not a text file"),
    ):
        assert main(["run", "--start", str(path)]) == 2
        assert named in capsys.readouterr().err
    assert main(["run", "--start", "betwen"]) == 2
    assert "choose from usual, between" in capsys.readouterr().err


def test_options_name_robots() -> None:
    one = settings_of_options(RunOptions(robot_right="panda"), RunSettings()).robot  # type: ignore[call-arg]
    assert one == "lwr_panda"
    assert settings_of_options(RunOptions(robot_left="ur5", robot_right="ur5"), RunSettings()).robot == "ur5"  # type: ignore[call-arg]


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--robot", "r2d2"], "robot = 'r2d2' is not possible; choose from lwr, panda, ur5"),
        (["--robot-left", "r2d2"], "robot = 'r2d2_lwr' is not possible"),
        (
            ["--hand-right", "l6"],
            "hand-right = 'l6': the hand of the arm lwr is known; name a link of a URDF file",
        ),
        (["--base-left=1,2"], "base-left = '1,2' is not a place for a base"),
        (["--base-left=0,0,0.7,0", "--base-right=0,0,0.7,0"], "find no start on the rig"),
    ],
)
def test_what_cannot_be_is_one_line_and_exit_code_2(
    arguments: list[str], line: str, capsys: pytest.CaptureFixture[str], registry: None
) -> None:
    assert main(["run", "--seconds", "0.1", *arguments]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and line in said


def test_a_link_keeps_a_pair_of_robots_but_not_a_file(tmp_path: Path) -> None:
    start = Settings(settings_of_options(RunOptions(robot_left="panda", robot_right="ur5"), RunSettings()))  # type: ignore[call-arg]
    assert from_query(to_query(start), Settings()) == (start, ())
    settings, problems = from_query({"robot": str(tmp_path / "box.urdf")}, Settings())
    assert settings == Settings() and len(problems) == 1
