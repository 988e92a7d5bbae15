"""Arms from URDF files start clear and keep clear in a room; other files are refused in one line."""

import importlib.metadata
import pickle
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from app.features.robot_files.file_robot import FileRobot, register
from app.features.robot_files.robot_file import LARGEST_MESHES, robot_file
from app.features.robot_files.urdf_chain import landmarks
from app.settings import LANGUAGES
from controllers.errors import BadInputFile, BadSetting, DuetError
from scenes.given_robots import GIVEN
from scenes.headless import run
from scenes.robots import robot
from scenes.robots.drawing import robot_glbs
from scenes.robots.example_data import urdf_files
from scenes.roles import room_of
from scenes.settings import RunSettings, changed, specs, validate
from tests.app.features.robot_files.arm_urdf import LENGTHS, arm_urdf
from tests.app.features.robot_files.refusals import refusal_lines, refusals
from tests.approved import Approve
from tests.scenes.helpers import beyond, column
from tests.scenes.robots.helpers import assert_they_keep_clear


@pytest.fixture
def box_arm(tmp_path: Path, registry: None) -> str:
    (tmp_path / "Box Arm.urdf").write_text(arm_urdf(), encoding="utf-8")
    return register(tmp_path / "Box Arm.urdf")


def test_landmarks_of_known_robots_are_found() -> None:
    assert [landmarks(robot(name).model) for name in ("lwr", "panda", "ur5")] == [
        (2, 4, 6),
        (2, 4, 6),
        (2, 3, 4),
    ]


@pytest.mark.parametrize("rig", ["torso", "table"])
@pytest.mark.parametrize("pair", ["file", "lwr_file", "file_ur5"])
def test_two_arms_start_clear_and_keep_clear(pair: str, rig: str, box_arm: str) -> None:
    assert_they_keep_clear(pair.replace("file", box_arm), rig)


def test_an_arm_of_boxes_gets_landmarks_capsules_and_drawable_links(box_arm: str) -> None:
    made = robot(box_arm)
    assert (made.model.nv, made.shoulder, made.elbow, made.hand) == (6, 2, 3, "l6")
    assert [capsule.name for capsule in made.capsules] == [
        "pedestal",
        "link 2",
        "link 3",
        "link 4",
        "link 5",
        "hand",
    ]
    upper = made.capsules[1]
    rims = np.array([(x, y, z) for z in (0.0, LENGTHS[1]) for x, y in ((0.05, 0.0), (0.0, -0.05))])
    assert beyond(rims, upper.start, upper.end, upper.radius).max() <= 1e-9
    assert len(robot_glbs(box_arm, "silver", coarse=True)) == 7


def test_a_link_without_collision_shapes_gets_a_capsule_around_its_visuals(
    tmp_path: Path, registry: None
) -> None:
    head, link, rest = arm_urdf().partition('<link name="l2">')
    seen, _, rest = rest.partition("<collision>")
    knob = '<visual><origin xyz="0.2 0 0"/><geometry><sphere radius="0.04"/></geometry></visual>'
    text = head + link + seen + knob + rest.partition("</collision>")[2]
    (tmp_path / "bare.urdf").write_text(text, encoding="utf-8")
    upper = robot(register(tmp_path / "bare.urdf")).capsules[1]
    assert upper.name == "link 2"
    assert (
        beyond(
            np.array([[0.24, 0.0, 0.0], [0.0, 0.0, LENGTHS[1]]]), upper.start, upper.end, upper.radius
        ).max()
        <= 1e-9
    )


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["so100", "so101"])
def test_two_short_arms_of_five_joints_hold_follow_and_keep_clear(name: str, registry: None) -> None:
    files = importlib.metadata.files("example-robot-data")
    assert files is not None
    (file,) = (Path(str(one.locate())) for one in files if one.name == f"{name}.urdf")
    given = replace(RunSettings(), robot=register(file), rig="table", dt=0.01)
    for scene in ("hold", "master_slave"):
        settings = validate(replace(given, scene=scene))
        room = room_of(settings)
        assert [arm.joints for arm in room.arms] == [slice(0, 5), slice(5, 10)]
        done = run(settings, 20.0)
        # The arms do meet: they are mounted closer together than longer arms.
        assert (
            settings.law.critical_distance
            <= column(done.table, "law_d").min()
            < column(done.table, "d").min()
            < 0.25
        )
        assert column(done.table, "lambda").max() > 0.1
        # Small levers do not give the full rate, which is reported; the distance is kept nevertheless.
        assert done.summary.out_of_authority_s < 10.0
    assert (
        room.rig.bases[1].translation[0]
        < 0.46
        < room_of(replace(given, robot="lwr")).rig.bases[1].translation[0]
    )


def test_five_joints_keep_a_position_and_not_an_orientation(tmp_path: Path, registry: None) -> None:
    path = tmp_path / "five.urdf"
    path.write_text(arm_urdf(count=5), encoding="utf-8")
    settings = validate(replace(RunSettings(), robot=register(path), scene="solo"))
    as_pose = replace(settings, task="pose")
    assert room_of(settings).task(as_pose) == "position" and room_of(RunSettings()).task(as_pose) == "pose"
    tables = [run(one, 3.0).table for one in (settings, as_pose)]
    assert tables[0].tobytes() == tables[1].tobytes() and column(tables[0], "e2").max() < 1e-4


BAD = {
    "prismatic": arm_urdf(kind="prismatic"),
    "floating": arm_urdf(kind="floating"),
    "short": arm_urdf(count=4),
    "no_urdf": "<robot",
    "cut off": arm_urdf()[:-300],
    "no_links": "<robot name='x'/>",
    "a page": "<html><body><p>404</p></body></html>",
    "xacro": (
        '<robot name="x" xmlns:xacro="http://ros.org/wiki/xacro"><xacro:include filename="arm.xacro"/></robot>'
    ),
    "no axis": arm_urdf().replace('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>', 1),
    "parallel": arm_urdf().replace('<axis xyz="0 1 0"/>', '<axis xyz="0 0 1"/>'),
    "millimetres": re.sub(r"(?<=[ \"])(0\.\d+|\.\d+)", lambda m: str(1000 * float(m[0])), arm_urdf()),
    "tiny": re.sub(r'xyz="0 0 0\.\d+"', 'xyz="0 0 0.0015"', arm_urdf()),
    "speed none": arm_urdf().replace('velocity="2"', 'velocity="nan"', 1),
    "too slow": arm_urdf().replace('velocity="2"', 'velocity="1e-9"', 1),
    "mimic": arm_urdf().replace('<axis xyz="0 1 0"/>', '<axis xyz="0 1 0"/><mimic joint="l1"/>', 1),
    "fork": arm_urdf(
        more='<link name="x"/><joint name="x" type="revolute"><parent link="l1"/><child link="x"/></joint>'
    ),
    "two_roots": arm_urdf(more='<link name="x"/>'),
    "missing": arm_urdf(shape='<mesh filename="package://there/no.stl"/>'),
    "huge": arm_urdf(shape='<mesh filename="huge.stl"/>'),
}


def test_a_file_that_is_not_an_arm_is_refused_in_one_line(tmp_path: Path, approve: Approve) -> None:
    with open(tmp_path / "huge.stl", "wb") as mesh:
        # A sparse file: it uses no disk space.
        mesh.truncate(200_000_000)
    assert LARGEST_MESHES < 200_000_000

    def read(text: str | bytes) -> None:
        (tmp_path / "arm.urdf").write_text(str(text), encoding="utf-8")
        robot_file(tmp_path / "arm.urdf")

    said = refusals(BAD, read)
    for language in LANGUAGES:
        approve(f"refused files {language}.txt", refusal_lines(said, tmp_path, language))


def test_a_mesh_without_triangles_is_named(tmp_path: Path, registry: None) -> None:
    (tmp_path / "hand.stl").write_bytes(b"solid nothing\nendsolid nothing\n")
    path = tmp_path / "arm.urdf"
    path.write_text(arm_urdf(shape='<mesh filename="hand.stl"/>'), encoding="utf-8")
    with pytest.raises(BadInputFile, match=r"hand\.stl: cannot"):
        robot(register(path))


def test_a_setting_never_names_a_path(box_arm: str) -> None:
    """Only robots given at the start are valid values."""
    assert box_arm in specs(RunSettings)["robot"].choices
    for text in (str(GIVEN[box_arm].origin), "Box Arm.urdf", "../x.urdf", f"lwr_{GIVEN[box_arm].origin}"):
        with pytest.raises(BadSetting, match="choose from"):
            changed(RunSettings(), "robot", text)


def test_another_content_is_another_robot(box_arm: str, tmp_path: Path) -> None:
    path = tmp_path / "Box Arm.urdf"
    path.write_text(arm_urdf().replace("0.05", "0.04"), encoding="utf-8")
    assert robot_file(path).key != box_arm


@pytest.mark.thorough
def test_every_serial_arm_of_the_package_avoids_or_is_refused_with_a_reason(registry: None) -> None:
    fits: dict[str, str] = {}
    for path in urdf_files():
        try:
            fits[path.stem] = register(path)
        except DuetError as error:
            assert str(path) in str(error)
    assert {
        "kinova",
        "panda",
        "talos_left_arm",
        "ur3_robot",
        "ur5_robot",
        "ur10_robot",
        "xarm7",
        "z1",
    } <= set(fits)
    for stem in ("kinova", "talos_left_arm", "ur10_robot", "ur3_gripper", "xarm7", "z1"):
        settings = replace(RunSettings(), robot=fits[stem], rig="table", dt=0.01)
        assert column(run(settings, 5.0).table, "d").min() >= settings.law.critical_distance, stem
        assert len(robot_glbs(fits[stem], "orange", coarse=True)) == robot(fits[stem]).model.nv + 1


@pytest.mark.parametrize("hand", ["", "l6"])
def test_other_meshes_under_the_same_path_are_named(hand: str, tmp_path: Path) -> None:
    path, mesh = tmp_path / "arm.urdf", tmp_path / "box.stl"
    trimesh.creation.box((0.1, 0.1, 0.2)).export(mesh)
    path.write_text(arm_urdf(shape='<mesh filename="box.stl"/>'), encoding="utf-8")
    # Serialised as for another process.
    robot = pickle.loads(pickle.dumps(FileRobot(robot_file(path, hand))))
    robot.check_files()
    mesh.write_bytes(mesh.read_bytes() + b" ")
    with pytest.raises(BadInputFile, match=r"arm\.urdf: is another"):
        robot.check_files()
    # Without meshes the whole robot is sent.
    path.write_text(arm_urdf(), encoding="utf-8")
    alone = FileRobot(robot_file(path, hand))
    path.unlink()
    alone.check_files()
