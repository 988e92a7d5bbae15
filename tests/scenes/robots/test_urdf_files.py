"""Arms from URDF files, and two different ones in a room: they are found, start well, and keep clear."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from controllers.errors import BadInputFile, BadSetting, DuetError
from scenes.headless import run
from scenes.rigs import place_bases
from scenes.robots import FILES, robot
from scenes.robots.drawing import robot_glbs
from scenes.robots.example_data import urdf_files
from scenes.robots.robot_files import LARGEST_MESHES, register, robot_file
from scenes.robots.urdf_chain import landmarks
from scenes.settings import RunSettings, changed, specs, validate
from scenes.simulation import Simulation
from tests.scenes.helpers import column

AXES = "zyyzyz"
LENGTHS = (0.18, 0.14, 0.38, 0.20, 0.18, 0.10)


def arm_urdf(count: int = 6, kind: str = "revolute", more: str = "", shape: str = "") -> str:
    """An arm of cylinders and boxes; its third joint is of a kind."""
    shape = shape or '<cylinder radius="0.05" length="{length}"/>'
    links, joints = ['<link name="base"><collision><geometry><box size="0.2 0.2 0.04"/></geometry></collision></link>'], []
    for i, (axis, length) in enumerate(zip(AXES[:count], LENGTHS, strict=False), start=1):
        place = f'<origin xyz="0 0 {length / 2}"/><geometry>{shape.format(length=length)}</geometry>'
        links.append(f'<link name="l{i}"><visual>{place}</visual><collision>{place}</collision></link>')
        xyz = {"z": "0 0 1", "y": "0 1 0"}[axis]
        before = 0.04 if i == 1 else LENGTHS[i - 2]
        joints.append(
            f'<joint name="l{i}" type="{kind if i == 3 else "revolute"}"><parent link="{"base" if i == 1 else f"l{i - 1}"}"/>'
            f'<child link="l{i}"/><origin xyz="0 0 {before}"/><axis xyz="{xyz}"/>'
            '<limit lower="-2.7" upper="2.7" velocity="2" effort="1"/></joint>'
        )
    return f'<robot name="box arm">{"".join(links + joints)}{more}</robot>'


@pytest.fixture
def box_arm(tmp_path: Path, registry: None) -> str:
    (tmp_path / "Box Arm.urdf").write_text(arm_urdf(), encoding="utf-8")
    return register(tmp_path / "Box Arm.urdf")


def test_landmarks_are_found_where_they_are_known() -> None:
    assert [landmarks(robot(name).model) for name in ("lwr", "panda", "ur5")] == [(2, 4, 6), (2, 4, 6), (2, 3, 4)]


def test_an_arm_of_boxes_gets_landmarks_capsules_and_links_to_draw(box_arm: str) -> None:
    made = robot(box_arm)
    assert (made.model.nv, made.shoulder, made.elbow, made.hand) == (6, 2, 3, "l6")
    assert [capsule.name for capsule in made.capsules] == ["pedestal", "link 2", "link 3", "link 4", "link 5", "hand"]
    upper = made.capsules[1]
    for z in (0.0, LENGTHS[1]):
        for x, y in ((0.05, 0.0), (0.0, -0.05)):
            along = np.clip((np.array([x, y, z]) - upper.start) @ (upper.end - upper.start), 0.0, None)
            share = min(along / float(np.sum((upper.end - upper.start) ** 2)), 1.0)
            nearest = upper.start + share * (upper.end - upper.start)
            assert np.linalg.norm(np.array([x, y, z]) - nearest) <= upper.radius + 1e-9
    assert len(robot_glbs(box_arm, "silver", coarse=True)) == 7


@pytest.mark.parametrize("rig", ["torso", "table"])
@pytest.mark.parametrize("pair", ["lwr_panda", "ur5_panda", "file", "lwr_file", "file_ur5"])
def test_two_arms_start_clear_and_keep_clear(pair: str, rig: str, box_arm: str) -> None:
    """For 5 s d ≥ d_law ≥ d_m, from a start that is comfortably farther apart, away from the stops, with the hand in front."""
    settings = validate(replace(RunSettings(), robot=pair.replace("file", box_arm), rig=rig))
    simulation = Simulation(settings, 1)
    start, model = simulation.positions.copy(), simulation.room.model
    assert simulation.sample().distance > 1.2 * settings.law.critical_distance
    assert np.minimum(start - model.lowerPositionLimit, model.upperPositionLimit - start).min() > np.radians(14)
    for arm in simulation.room.arms:
        assert np.linalg.svd(simulation.kinematics.hand_jacobian(arm, 3), compute_uv=False)[-1] > 0.1
    table = run(settings, 5.0).table
    assert (column(table, "d") >= column(table, "law_d") - 1e-9).all()
    assert column(table, "law_d").min() >= settings.law.critical_distance


def test_a_slave_with_fewer_joints_follows_with_those_it_has() -> None:
    table = run(replace(RunSettings(), robot="ur5_lwr", scene="master_slave", rig="table"), 1.0).table
    assert np.isfinite(column(table, "d")).all()


def test_given_bases(registry: None) -> None:
    name = place_bases("0,0.5,0.2,0", "0,-0.5,0.2,0")
    settings = changed(replace(RunSettings(), robot="ur5_panda"), "rig", name)
    left, right = Simulation(settings, 1).room.bases()
    assert left.translation.tolist() == [0.0, 0.5, 0.2] and right.translation.tolist() == [0.0, -0.5, 0.2]
    assert column(run(settings, 2.0).table, "d").min() >= settings.law.critical_distance
    for text in ("1,2,3", "0,0,9,0", "nan,0,0,0", "a,b,c,d"):
        with pytest.raises(BadSetting, match=r"no place for a base; give x,y,z,yaw"):
            place_bases(text, "")


BAD = {
    "prismatic": (arm_urdf(kind="prismatic"), "joint l3 is prismatic"),
    "floating": (arm_urdf(kind="floating"), "joint l3 is floating"),
    "short": (arm_urdf(count=5), "has 5 revolute joints"),
    "no_urdf": ("<robot", "is no URDF file"),
    "no_links": ("<robot name='x'/>", "is no URDF file"),
    "fork": (
        arm_urdf(more='<link name="x"/><joint name="x" type="revolute"><parent link="l1"/><child link="x"/></joint>'),
        "forks into .* after 1 joints",
    ),
    "two_roots": (arm_urdf(more='<link name="x"/>'), "2 links without a parent"),
    "missing": (arm_urdf(shape='<mesh filename="package://there/no.stl"/>'), "mesh package://there/no.stl is missing"),
    "huge": (arm_urdf(shape='<mesh filename="huge.stl"/>'), r"larger than 64 MB"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_no_arm_is_named_in_one_line(case: str, tmp_path: Path) -> None:
    text, reason = BAD[case]
    path = tmp_path / "arm.urdf"
    path.write_text(text, encoding="utf-8")
    with open(tmp_path / "huge.stl", "wb") as mesh:
        # Takes no room on the disk.
        mesh.truncate(200_000_000)
    assert LARGEST_MESHES < 200_000_000
    with pytest.raises(BadInputFile, match=reason) as error:
        robot_file(path)
    assert "\n" not in str(error.value)


def test_a_setting_never_names_a_path(box_arm: str) -> None:
    """Only what was given at the start is a value; the name of another file says what to do."""
    assert box_arm in specs(RunSettings)["robot"].choices
    for text in (str(FILES[box_arm].path), "Box Arm.urdf", "../x.urdf", f"lwr_{FILES[box_arm].path}"):
        with pytest.raises(BadSetting, match="is not possible; choose from"):
            changed(RunSettings(), "robot", text)
    with pytest.raises(BadSetting, match=r"not given here: start Duet with --robot and the same file, other\.urdf, unchanged"):
        changed(RunSettings(), "robot", "lwr_other-0123456789ab")
    with pytest.raises(BadSetting, match=r"--base-left=-0\.5,0,0\.75,0 --base-right=0\.5,0,0\.75,180"):
        changed(RunSettings(), "rig", "-0.5,0,0.75,0:0.5,0,0.75,180")


def test_another_content_is_another_robot(box_arm: str, tmp_path: Path) -> None:
    path = tmp_path / "Box Arm.urdf"
    path.write_text(arm_urdf().replace("0.05", "0.04"), encoding="utf-8")
    assert robot_file(path).key != box_arm


def test_every_serial_arm_of_the_package_avoids_or_is_refused_for_a_reason(registry: None) -> None:
    fits: dict[str, str] = {}
    for path in urdf_files():
        try:
            fits[path.stem] = register(path)
        except DuetError as error:
            assert str(path) in str(error)
    assert {"kinova", "panda", "talos_left_arm", "ur3_robot", "ur5_robot", "ur10_robot", "xarm7", "z1"} <= set(fits)
    for stem in ("kinova", "talos_left_arm", "ur10_robot", "ur3_gripper", "xarm7", "z1"):
        settings = replace(RunSettings(), robot=fits[stem], rig="table")
        assert column(run(settings, 5.0).table, "d").min() >= settings.law.critical_distance, stem
        assert len(robot_glbs(fits[stem], "orange", coarse=True)) == robot(fits[stem]).model.nv + 1
