"""A robot from a file: at the command line, in links, in run files, and in exports of two different arms."""

from pathlib import Path

import pytest

from app.cli.main import main
from app.cli.options import RunOptions, chosen
from app.export.scene_film import film_scene
from app.recording.run_file import load_run, saved_bytes
from app.settings import PageSettings, Settings, from_query, to_query
from controllers.errors import BadInputFile
from scenes.given_choices import added_choices, makes
from scenes.robots import FILES
from scenes.settings import RunSettings
from tests.scenes.helpers import recorded_run
from tests.scenes.robots.test_urdf_files import arm_urdf


@pytest.fixture
def urdf(tmp_path: Path, registry: None) -> Path:
    path = tmp_path / "box.urdf"
    path.write_text(arm_urdf(), encoding="utf-8")
    return path


def test_options_name_robots_and_files(urdf: Path) -> None:
    left = chosen(RunOptions(robot_left=str(urdf), robot_right="ur5"), RunSettings()).robot  # type: ignore[call-arg]
    assert makes(left)[0] in FILES and makes(left)[1] == "ur5"
    one = chosen(RunOptions(robot_right="panda"), RunSettings()).robot  # type: ignore[call-arg]
    assert one == "lwr_panda"
    assert chosen(RunOptions(robot_left="ur5", robot_right="ur5"), RunSettings()).robot == "ur5"  # type: ignore[call-arg]


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


def test_a_link_keeps_a_pair_and_names_no_file(urdf: Path) -> None:
    start = Settings(chosen(RunOptions(robot_left="panda", robot_right="ur5"), RunSettings()))  # type: ignore[call-arg]
    assert from_query(to_query(start), Settings()) == (start, ())
    settings, problems = from_query({"robot": str(urdf)}, Settings())
    assert settings == Settings() and len(problems) == 1


def test_a_run_file_needs_the_same_robot(urdf: Path) -> None:
    settings = chosen(RunOptions(robot_left=str(urdf), robot_right="panda", rig="table"), RunSettings())  # type: ignore[call-arg]
    _, recorded = recorded_run(settings, 1.0, 99.0, {})
    data = saved_bytes(recorded)
    assert load_run(data, "run.duet.npz").verification.verdict == "exact"
    film = film_scene(recorded, 0.5, PageSettings(picture="fast"))
    assert any("/arms/left/base/arm_joint_1" in track.node for track in film.tracks)
    given = dict(FILES), {key: dict(found) for key, found in added_choices().items()}
    FILES.clear()
    added_choices().clear()
    with pytest.raises(BadInputFile, match=r"start Duet with --robot and the same file, box\.urdf, unchanged"):
        load_run(data, "run.duet.npz")
    # A worker takes over what its server was given.
    from scenes.robots.robot_files import take_over

    take_over(given)
    assert load_run(data, "run.duet.npz").verification.verdict == "exact"


def test_the_list_of_robots(urdf: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots"]) == 0
    said = capsys.readouterr().out
    assert "panda  Franka Emika Panda, 7 joints" in said
    assert "xarm7.urdf   7 joints" in said and "pr2.urdf: its joint torso_lift_joint is prismatic" in said
