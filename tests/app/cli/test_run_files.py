"""Files for `lwr-duet run`: a start posture and robots; every way to write them, and how a wrong one is refused."""

import json
from pathlib import Path

import numpy as np
import pytest

from app.__main__ import run_command as main
from app.cli.options import RunOptions, settings_of_options
from app.recording.run_file import load_run, saved_bytes
from app.settings import Settings, from_query, to_query
from controllers.errors import BadInputFile
from scenes.ball import build_ball_room
from scenes.children import computed
from scenes.robots import FILES, robot
from scenes.room import build_room
from scenes.setting_spec import added_choices, makes
from scenes.settings import RunSettings
from scenes.starts import BETWEEN, read_start
from tests.scenes.helpers import recorded_run
from tests.scenes.robots.test_files import arm_urdf

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
def test_every_way_to_write_it(tmp_path: Path, text: str) -> None:
    file = tmp_path / "start.txt"
    file.write_text(text, encoding="utf-8")
    assert read_start(file, ROOM).tolist() == POSTURE


def test_a_run_begins_there(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """A file with the built-in posture gives the built-in run, and says where it came from."""
    file = tmp_path / "start.txt"
    file.write_text(COMMAS)
    tables = []
    for start in (str(file), "between"):
        out = tmp_path / "out.csv"
        assert main(["run", "--seconds", "0.3", "--avoid", "guided", "--start", start, "--csv", str(out)]) == 0
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
def test_what_is_no_posture(capsys: pytest.CaptureFixture[str], tmp_path: Path, text: str, named: str) -> None:
    file = tmp_path / "start.txt"
    file.write_text(text)
    assert main(["run", "--seconds", "0.1", "--start", str(file)]) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and len(captured.err.splitlines()) == 1
    assert named in captured.err


def test_files_that_are_none(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "bytes").write_bytes(bytes(range(128, 256)))
    for path, named in ((tmp_path / "no", "no such file"), (tmp_path, "a folder"), (tmp_path / "bytes", "not a text file")):
        assert main(["run", "--start", str(path)]) == 2
        assert named in capsys.readouterr().err
    assert main(["run", "--start", "betwen"]) == 2
    assert "choose from usual, between" in capsys.readouterr().err


def hand_of(name: str) -> str:
    """Runs in a worker."""
    return robot(name).hand


@pytest.fixture
def urdf(tmp_path: Path, registry: None) -> Path:
    path = tmp_path / "box.urdf"
    path.write_text(arm_urdf(), encoding="utf-8")
    return path


def test_options_name_robots_and_files(urdf: Path) -> None:
    left = settings_of_options(RunOptions(robot_left=str(urdf), robot_right="ur5"), RunSettings()).robot  # type: ignore[call-arg]
    assert makes(left)[0] in FILES and makes(left)[1] == "ur5"
    one = settings_of_options(RunOptions(robot_right="panda"), RunSettings()).robot  # type: ignore[call-arg]
    assert one == "lwr_panda"
    assert settings_of_options(RunOptions(robot_left="ur5", robot_right="ur5"), RunSettings()).robot == "ur5"  # type: ignore[call-arg]


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--robot", "no/such.urdf"], "no/such.urdf: cannot be read"),
        (["--robot", "r2d2"], "robot = 'r2d2' is not possible; choose from lwr, panda, ur5"),
        (["--robot-left", "r2d2"], "robot = 'r2d2_lwr' is not possible"),
        (["--base-left=1,2"], "base-left = '1,2' is no place for a base"),
        (["--base-left=0,0,0.7,0", "--base-right=0,0,0.7,0"], "find no start on the rig"),
    ],
)
def test_what_cannot_be_is_one_line_and_exit_code_2(
    arguments: list[str], line: str, urdf: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", "--seconds", "0.1", *arguments]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and line in said


CLAW = arm_urdf(
    more='<link name="claw"/><joint name="claw_joint" type="revolute"><parent link="l6"/><child link="claw"/>'
    '<origin xyz="0 0 0.1"/><limit lower="-1" upper="1"/></joint>'
    '<link name="my_tool0_cable"/><joint name="c" type="fixed"><parent link="claw"/><child link="my_tool0_cable"/></joint>'
)


@pytest.mark.thorough
def test_guesses_are_said_and_the_hand_can_be_named(tmp_path: Path, registry: None, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "claw.urdf"
    path.write_text(CLAW, encoding="utf-8")
    guessed = settings_of_options(RunOptions(robot=str(path), rig="table"), RunSettings()).robot  # type: ignore[call-arg]
    assert capsys.readouterr().err == (
        "claw.urdf: the arm has the 7 joints l1, l2, l3, l4, l5, l6, claw_joint, its hand is my_tool0_cable "
        '(by "tool0" in its name; --hand-left or --hand-right LINK names another one). '
        "Taken with 2 rad/s, as their own top speed is missing or not one of an arm: claw_joint.\n"
    )
    assert (robot(guessed).hand, robot(guessed).model.nv) == ("my_tool0_cable", 7)
    options = RunOptions(robot=str(path), hand_left="l6", hand_right="claw", rig="table")  # type: ignore[call-arg]
    left, right = makes(settings_of_options(options, RunSettings()).robot)
    assert len({guessed, left, right}) == 3
    assert [(robot(name).hand, robot(name).model.nv) for name in (left, right)] == [("l6", 6), ("claw", 7)]
    said = capsys.readouterr().err.splitlines()
    assert said[0] == "claw.urdf: the arm has the 6 joints l1, l2, l3, l4, l5, l6, its hand is l6. Held still: claw_joint."
    assert len(said) == 2


def test_a_named_hand_ends_a_fork(tmp_path: Path, registry: None, capsys: pytest.CaptureFixture[str]) -> None:
    fork = '<link name="x"/><joint name="x" type="revolute"><parent link="l1"/><child link="x"/><limit lower="-1" upper="1"/></joint>'
    path = tmp_path / "fork.urdf"
    path.write_text(arm_urdf(more=fork), encoding="utf-8")
    assert main(["run", "--robot-left", str(path), "--seconds", "0.1"]) == 2
    assert "or name the hand with --hand-left" in capsys.readouterr().err
    name = makes(settings_of_options(RunOptions(robot_left=str(path), hand_left="l6"), RunSettings()).robot)[0]  # type: ignore[call-arg]
    assert robot(name).model.nv == 6 and "Held still: x." in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (["--hand-left", "l9"], "box.urdf: has no link l9 that could be the hand; its links are base, l1, l2, l3, l4, l5, l6."),
        (["--hand-left", "l3"], "has 3 revolute joints on the way to the hand l3; Duet takes arms of 5 to 7."),
        (["--hand-right", "l6"], "hand-right = 'l6': the hand of the arm lwr is known; name a link of a URDF file"),
    ],
)
def test_a_hand_that_cannot_be_is_one_line(options: list[str], line: str, urdf: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "--robot-left", str(urdf), "--seconds", "0.1", *options]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and line in said


@pytest.mark.thorough
def test_a_named_hand_is_in_the_run_file_and_in_workers(tmp_path: Path, registry: None) -> None:
    path = tmp_path / "claw.urdf"
    path.write_text(CLAW, encoding="utf-8")
    options = RunOptions(robot_left=str(path), hand_left="l6", robot_right="lwr", rig="table")  # type: ignore[call-arg]
    settings = settings_of_options(options, RunSettings())
    data = saved_bytes(recorded_run(settings, 0.5, 99.0, {})[1])
    assert load_run(data, "run.duet.npz").verdict == "exact"
    # One call would run in this process.
    assert [hand for _, hand in computed(hand_of, 2 * [(makes(settings.robot)[0],)], workers=2)] == ["l6", "l6"]
    FILES.clear()
    added_choices().clear()
    # The same file with another hand is another robot.
    settings_of_options(RunOptions(robot_left=str(path), rig="table"), RunSettings())  # type: ignore[call-arg]
    with pytest.raises(BadInputFile, match=r"claw\.urdf, unchanged, and with the same --hand-left"):
        load_run(data, "run.duet.npz")


@pytest.mark.parametrize("command", ["run", "serve"])
@pytest.mark.usefixtures("registry")
def test_a_file_in_other_units_is_one_line_before_any_work(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "tiny.urdf"
    path.write_text(arm_urdf(shape='<sphere radius="0.00005"/>'), encoding="utf-8")
    more = ["--seconds", "1"] if command == "run" else ["--no-open", "--port", "0"]
    assert main([command, "--robot", str(path), *more]) == 2
    said = capsys.readouterr()
    assert said.out == "" and said.err.count("\n") == 1 and "link l1 are 0.0001 m large, and its arm is" in said.err


def test_a_link_keeps_a_pair_and_names_no_file(urdf: Path) -> None:
    start = Settings(settings_of_options(RunOptions(robot_left="panda", robot_right="ur5"), RunSettings()))  # type: ignore[call-arg]
    assert from_query(to_query(start), Settings()) == (start, ())
    settings, problems = from_query({"robot": str(urdf)}, Settings())
    assert settings == Settings() and len(problems) == 1


def test_a_run_file_needs_the_same_robot(urdf: Path) -> None:
    settings = settings_of_options(RunOptions(robot_left=str(urdf), robot_right="panda", rig="table"), RunSettings())  # type: ignore[call-arg]
    _, recorded = recorded_run(settings, 1.0, 99.0, {})
    data = saved_bytes(recorded)
    assert load_run(data, "run.duet.npz").verdict == "exact"
    given = dict(FILES), {key: dict(found) for key, found in added_choices().items()}
    FILES.clear()
    added_choices().clear()
    with pytest.raises(BadInputFile, match=r"start Duet with --robot and the same file, box\.urdf, unchanged"):
        load_run(data, "run.duet.npz")
    # A worker takes over what its server was given.
    from scenes.robots.robot_files import take_over

    take_over(given)
    assert load_run(data, "run.duet.npz").verdict == "exact"


def test_the_list_of_robots(urdf: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots"]) == 0
    said = capsys.readouterr().out
    assert "panda  Franka Emika Panda, 7 joints" in said
    assert "xarm7.urdf   7 joints" in said and "pr2.urdf: its joint torso_lift_joint is prismatic" in said
