"""Robots from files on the command line, in links, in run files and in other processes."""

from pathlib import Path

import pytest

from app.__main__ import run_command as main
from app.cli.options import RunOptions, settings_of_options
from app.recording.run_file import load_run, saved_bytes
from app.settings import Settings, from_query
from controllers.errors import BadInputFile
from scenes.children import computed
from scenes.given_robots import GIVEN, take_over
from scenes.robots import robot
from scenes.setting_spec import added_choices, makes
from scenes.settings import RunSettings
from tests.app.features.robot_files.arm_urdf import arm_urdf
from tests.approved import Approve
from tests.scenes.helpers import recorded_run


def hand_of(name: str) -> str:
    """The hand's frame of a robot; runs in a worker."""
    return robot(name).hand


@pytest.fixture
def urdf(tmp_path: Path, registry: None) -> Path:
    path = tmp_path / "box.urdf"
    path.write_text(arm_urdf(), encoding="utf-8")
    return path


def test_options_name_files(urdf: Path) -> None:
    left = settings_of_options(RunOptions(robot_left=str(urdf), robot_right="ur5"), RunSettings()).robot  # type: ignore[call-arg]
    assert makes(left)[0] in GIVEN and makes(left)[1] == "ur5"


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--robot", "no/such.urdf"], "no/such.urdf: cannot be read"),
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
def test_guesses_are_announced_and_the_hand_can_be_named(
    tmp_path: Path, registry: None, capsys: pytest.CaptureFixture[str], approve: Approve
) -> None:
    path = tmp_path / "claw.urdf"
    path.write_text(CLAW, encoding="utf-8")
    guessed = settings_of_options(RunOptions(robot=str(path), rig="table"), RunSettings()).robot  # type: ignore[call-arg]
    said = capsys.readouterr().err
    assert (robot(guessed).hand, robot(guessed).model.nv) == ("my_tool0_cable", 7)
    options = RunOptions(robot=str(path), hand_left="l6", hand_right="claw", rig="table")  # type: ignore[call-arg]
    left, right = makes(settings_of_options(options, RunSettings()).robot)
    assert len({guessed, left, right}) == 3
    assert [(robot(name).hand, robot(name).model.nv) for name in (left, right)] == [("l6", 6), ("claw", 7)]
    approve("guesses.txt", said + capsys.readouterr().err)


def test_a_named_hand_ends_a_fork(tmp_path: Path, registry: None, capsys: pytest.CaptureFixture[str]) -> None:
    fork = '<link name="x"/><joint name="x" type="revolute"><parent link="l1"/><child link="x"/><limit lower="-1" upper="1"/></joint>'
    path = tmp_path / "fork.urdf"
    path.write_text(arm_urdf(more=fork), encoding="utf-8")
    assert main(["run", "--robot-left", str(path), "--seconds", "0.1"]) == 2
    assert "--hand-left" in capsys.readouterr().err
    name = makes(settings_of_options(RunOptions(robot_left=str(path), hand_left="l6"), RunSettings()).robot)[
        0
    ]  # type: ignore[call-arg]
    assert robot(name).model.nv == 6 and "Held still: x." in capsys.readouterr().err


@pytest.mark.parametrize("link", ["l9", "l3"])
def test_an_impossible_hand_gives_one_line(
    link: str, urdf: Path, capsys: pytest.CaptureFixture[str], approve: Approve
) -> None:
    assert main(["run", "--robot-left", str(urdf), "--seconds", "0.1", "--hand-left", link]) == 2
    approve(f"hand {link}.txt", capsys.readouterr().err.replace(str(urdf.parent), "FOLDER"))


@pytest.mark.thorough
def test_a_named_hand_is_in_the_run_file_and_in_workers(tmp_path: Path, registry: None) -> None:
    path = tmp_path / "claw.urdf"
    path.write_text(CLAW, encoding="utf-8")
    options = RunOptions(robot_left=str(path), hand_left="l6", robot_right="lwr", rig="table")  # type: ignore[call-arg]
    settings = settings_of_options(options, RunSettings())
    data = saved_bytes(recorded_run(settings, 0.5, 99.0, {})[1])
    assert load_run(data, "run.duet.npz").verdict == "exact"
    # A single call would run in this process.
    assert [hand for _, hand in computed(hand_of, 2 * [(makes(settings.robot)[0],)], workers=2)] == [
        "l6",
        "l6",
    ]
    GIVEN.clear()
    added_choices().clear()
    # The same file with another hand is another robot.
    settings_of_options(RunOptions(robot_left=str(path), rig="table"), RunSettings())  # type: ignore[call-arg]
    with pytest.raises(BadInputFile, match="the same --hand-left"):
        load_run(data, "run.duet.npz")


@pytest.mark.parametrize("command", ["run", "serve"])
@pytest.mark.usefixtures("registry")
def test_a_file_in_other_units_gives_one_line_before_any_work(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], approve: Approve
) -> None:
    path = tmp_path / "tiny.urdf"
    path.write_text(arm_urdf(shape='<sphere radius="0.00005"/>'), encoding="utf-8")
    more = ["--seconds", "1"] if command == "run" else ["--no-open", "--port", "0", "--store", "memory"]
    assert main([command, "--robot", str(path), *more]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    approve("other units.txt", said.err.replace(str(tmp_path), "FOLDER"))


def test_a_link_cannot_name_a_file(urdf: Path) -> None:
    settings, problems = from_query({"robot": str(urdf)}, Settings())
    assert settings == Settings() and len(problems) == 1


def test_a_run_file_needs_the_same_robot(urdf: Path, approve: Approve) -> None:
    settings = settings_of_options(
        RunOptions(robot_left=str(urdf), robot_right="panda", rig="table"), RunSettings()
    )  # type: ignore[call-arg]
    _, recorded = recorded_run(settings, 1.0, 99.0, {})
    data = saved_bytes(recorded)
    assert load_run(data, "run.duet.npz").verdict == "exact"
    given = dict(GIVEN), {key: dict(found) for key, found in added_choices().items()}
    GIVEN.clear()
    added_choices().clear()
    with pytest.raises(BadInputFile) as error:
        load_run(data, "run.duet.npz")
    approve("run of another robot.txt", f"{error.value}\n")
    # A worker takes over the robots given to its server.
    take_over(given)
    assert load_run(data, "run.duet.npz").verdict == "exact"


def test_the_list_of_robots(urdf: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots"]) == 0
    said = capsys.readouterr().out
    assert "panda  Franka Emika" in said
    assert "xarm7.urdf   7 joints" in said and "torso_lift_joint" in said
