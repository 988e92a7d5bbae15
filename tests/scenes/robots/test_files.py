"""Any arm moves as its own file says, also one from a URDF file, and two of any make start well and keep clear in a room."""

import importlib.metadata
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

from controllers.errors import BadInputFile, BadSetting, DuetError
from controllers.kinematics import Kinematics
from controllers.proximity import ProximityDetector
from scenes.headless import run
from scenes.rigs import place_bases
from scenes.robots import FILES, RobotName, robot
from scenes.robots.drawing import robot_glbs
from scenes.robots.example_data import EXAMPLES, urdf_files
from scenes.robots.fitting import fit_example
from scenes.robots.robot_files import LARGEST_MESHES, register, robot_file
from scenes.robots.start_search import start_posture
from scenes.robots.urdf_chain import landmarks
from scenes.roles import room_of
from scenes.room import build_room
from scenes.settings import RigName, RunSettings, changed, specs, validate
from scenes.simulation import Simulation
from tests.scenes.helpers import RIG_NAMES, beyond, column
from tests.scenes.robots.helpers import NAMES, link_poses, other_reader, postures


@pytest.mark.parametrize("name", NAMES)
def test_both_readers_and_the_file_agree(name: RobotName) -> None:
    model = robot(name).model
    data = model.createData()
    for q in postures(model, 10):
        pin.framesForwardKinematics(model, data, q)
        poses = link_poses(name, q)
        assert robot(name).hand in poses
        for link, pose in poses.items():
            assert_allclose(data.oMf[model.getFrameId(link)].homogeneous, pose, atol=1e-9, err_msg=link)
    model, reader = robot(name).model, other_reader(name)
    for i, joint in enumerate(list(model.names)[1:]):
        limit = reader.joint_map[joint].limit
        assert (model.lowerPositionLimit[i], model.upperPositionLimit[i]) == (limit.lower, limit.upper)
        assert model.velocityLimit[i] == limit.velocity


@pytest.mark.parametrize(("name", "joints"), [("lwr", 7), ("panda", 7), ("ur5", 6)])
def test_a_robot_is_complete(name: RobotName, joints: int) -> None:
    arm = robot(name)
    assert robot(name) is arm
    assert arm.model.nq == arm.model.nv == len(arm.labels) == len(set(arm.labels)) == joints
    assert arm.model.existFrame(arm.hand) and 1 <= arm.shoulder < arm.elbow < arm.wrist <= joints
    assert 1 <= len(arm.capsules) <= 6
    assert len({capsule.name for capsule in arm.capsules}) == len(arm.capsules)
    carriers = [capsule.joint for capsule in arm.capsules]
    assert min(carriers) == 0 and carriers == sorted(set(carriers))


def test_robots_by_name() -> None:
    assert robot("lwr") is robot("lwr") and robot("lwr").name == "KUKA LWR 4+"
    with pytest.raises(BadSetting, match=r"'r2d2'.*lwr, panda, ur5"):
        robot("r2d2")  # pyright: ignore[reportArgumentType]
    with pytest.raises(BadSetting, match=r"damaged.*pip install"):
        fit_example(replace(EXAMPLES["ur5"], urdf="ur_description/urdf/gone.urdf"))


@pytest.mark.parametrize("name", NAMES)
def test_landmarks_make_an_arm(name: RobotName) -> None:
    arm = robot(name)
    data = arm.model.createData()
    pin.forwardKinematics(arm.model, data, start_posture(name, "table", "left"))
    shoulder, elbow, wrist = (data.oMi[joint].translation.copy() for joint in (arm.shoulder, arm.elbow, arm.wrist))
    upper, fore = elbow - shoulder, wrist - elbow
    assert min(np.linalg.norm(upper), np.linalg.norm(fore)) > 0.3
    bend = np.arccos(upper @ fore / np.linalg.norm(upper) / np.linalg.norm(fore))
    assert np.radians(50) < bend < np.radians(140)


def test_missing_packages_are_named_with_their_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr("importlib.metadata.files", missing)
    with pytest.raises(BadSetting, match="pip install example-robot-data"):
        fit_example(EXAMPLES["panda"])
    monkeypatch.setattr("importlib.metadata.files", lambda _: [])
    with pytest.raises(BadSetting, match=r"without its robots.*pip install"):
        fit_example(EXAMPLES["panda"])


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("name", NAMES)
def test_arms_start_clear_of_each_other_and_of_their_stops_and_mirrored(name: RobotName, rig: RigName) -> None:
    """25 cm apart, 15° from every stop; hands at the same height, on either side, in front."""
    room = build_room(rig, name)
    kinematics = Kinematics(room.model, room.arms)
    kinematics.update(room.start)
    assert ProximityDetector(kinematics, room.geometry).detect("single").distance >= 0.25
    margin = np.minimum(room.start - room.model.lowerPositionLimit, room.model.upperPositionLimit - room.start)
    assert margin.min() > np.radians(15)
    left, right = (kinematics.hand_pose(arm).translation for arm in room.arms)
    assert_allclose(left, right * ((1, -1, 1) if rig == "torso" else (-1, -1, 1)), atol=2e-3)
    assert left[0] > 0.6 if rig == "torso" else -0.45 < left[0] < -0.15
    assert 0.8 < left[2] < 1.6


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
    rims = np.array([(x, y, z) for z in (0.0, LENGTHS[1]) for x, y in ((0.05, 0.0), (0.0, -0.05))])
    assert beyond(rims, upper.start, upper.end, upper.radius).max() <= 1e-9
    assert len(robot_glbs(box_arm, "silver", coarse=True)) == 7


def test_a_link_without_collision_shapes_gets_a_capsule_around_all_that_is_drawn_of_it(tmp_path: Path, registry: None) -> None:
    head, link, rest = arm_urdf().partition('<link name="l2">')
    seen, _, rest = rest.partition("<collision>")
    knob = '<visual><origin xyz="0.2 0 0"/><geometry><sphere radius="0.04"/></geometry></visual>'
    text = head + link + seen + knob + rest.partition("</collision>")[2]
    (tmp_path / "bare.urdf").write_text(text, encoding="utf-8")
    upper = robot(register(tmp_path / "bare.urdf")).capsules[1]
    assert upper.name == "link 2"
    assert beyond(np.array([[0.24, 0.0, 0.0], [0.0, 0.0, LENGTHS[1]]]), upper.start, upper.end, upper.radius).max() <= 1e-9


@pytest.mark.parametrize("rig", ["torso", "table"])
@pytest.mark.parametrize("pair", ["lwr_panda", "ur5_panda", "file", "lwr_file", "file_ur5"])
def test_two_arms_start_clear_and_keep_clear(pair: str, rig: str, box_arm: str) -> None:
    """For 5 s d ≥ d_law ≥ d_m, from a start that is comfortably farther apart, away from the stops, with the hand in front."""
    settings = validate(replace(RunSettings(), robot=pair.replace("file", box_arm), rig=rig, dt=0.01))
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


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["so100", "so101"])
def test_two_short_arms_of_five_joints_hold_follow_and_keep_clear_on_the_table(name: str, registry: None) -> None:
    files = importlib.metadata.files("example-robot-data")
    assert files is not None
    (file,) = (Path(str(one.locate())) for one in files if one.name == f"{name}.urdf")
    given = replace(RunSettings(), robot=register(file), rig="table", dt=0.01)
    for scene in ("hold", "master_slave"):
        settings = validate(replace(given, scene=scene))
        room = room_of(settings)
        assert [arm.joints for arm in room.arms] == [slice(0, 5), slice(5, 10)]
        done = run(settings, 20.0)
        # They come near each other, for they stand nearer than longer arms do.
        assert settings.law.critical_distance <= column(done.table, "law_d").min() < column(done.table, "d").min() < 0.25
        assert column(done.table, "lambda").max() > 0.1
        # Levers that are small do not give the whole rate, which is said; the distance holds all the same.
        assert done.summary.out_of_authority_s < 10.0
    assert room.rig.bases[1].translation[0] < 0.46 < room_of(replace(given, robot="lwr")).rig.bases[1].translation[0]


def test_five_joints_keep_a_place_and_not_a_turn(tmp_path: Path, registry: None) -> None:
    path = tmp_path / "five.urdf"
    path.write_text(arm_urdf(count=5), encoding="utf-8")
    settings = validate(replace(RunSettings(), robot=register(path), scene="solo"))
    as_pose = replace(settings, task="pose")
    assert room_of(settings).task(as_pose) == "position" and room_of(RunSettings()).task(as_pose) == "pose"
    tables = [run(one, 3.0).table for one in (settings, as_pose)]
    assert tables[0].tobytes() == tables[1].tobytes() and column(tables[0], "e2").max() < 1e-4


def test_given_bases(registry: None) -> None:
    name = place_bases("0,0.5,0.2,0", "0,-0.5,0.2,0")
    settings = changed(replace(RunSettings(), robot="ur5_panda"), "rig", name)
    left, right = Simulation(settings, 1).room.rig.bases
    assert left.translation.tolist() == [0.0, 0.5, 0.2] and right.translation.tolist() == [0.0, -0.5, 0.2]
    assert column(run(settings, 2.0).table, "d").min() >= settings.law.critical_distance
    for text in ("1,2,3", "0,0,9,0", "nan,0,0,0", "a,b,c,d"):
        with pytest.raises(BadSetting, match=r"no place for a base; give x,y,z,yaw"):
            place_bases(text, "")


BAD = {
    "prismatic": (arm_urdf(kind="prismatic"), "joint l3 is prismatic"),
    "floating": (arm_urdf(kind="floating"), "joint l3 is floating"),
    "short": (arm_urdf(count=4), "has 4 revolute joints in a chain; Duet takes arms of 5 to 7"),
    "no_urdf": ("<robot", "its XML is damaged"),
    "cut off": (arm_urdf()[:-300], "its XML is damaged"),
    "no_links": ("<robot name='x'/>", "it has no links"),
    "a page": ("<html><body><p>404</p></body></html>", "begins with <html>"),
    "xacro": (
        '<robot name="x" xmlns:xacro="http://ros.org/wiki/xacro"><xacro:include filename="arm.xacro"/></robot>',
        r"run `xacro .*arm\.urdf > robot\.urdf`",
    ),
    "no axis": (arm_urdf().replace('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>', 1), "axis of its joint l2 is no direction"),
    "parallel": (arm_urdf().replace('<axis xyz="0 1 0"/>', '<axis xyz="0 0 1"/>'), "all its axes are parallel"),
    "millimetres": (
        re.sub(r"(?<=[ \"])(0\.\d+|\.\d+)", lambda m: str(1000 * float(m[0])), arm_urdf()),
        "lengths in a URDF are in metres",
    ),
    "tiny": (re.sub(r'xyz="0 0 0\.\d+"', 'xyz="0 0 0.0015"', arm_urdf()), "lengths in a URDF are in metres"),
    "speed none": (arm_urdf().replace('velocity="2"', 'velocity="nan"', 1), "joint l1 has a top speed of nan rad/s"),
    "too slow": (arm_urdf().replace('velocity="2"', 'velocity="1e-9"', 1), "joint l1 has a top speed of 1e-09 rad/s"),
    "mimic": (
        arm_urdf().replace('<axis xyz="0 1 0"/>', '<axis xyz="0 1 0"/><mimic joint="l1"/>', 1),
        "has 1 revolute joints in a chain, then l2, which only follows another",
    ),
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


def test_a_mesh_without_triangles_is_named(tmp_path: Path, registry: None) -> None:
    (tmp_path / "hand.stl").write_bytes(b"solid nothing\nendsolid nothing\n")
    path = tmp_path / "arm.urdf"
    path.write_text(arm_urdf(shape='<mesh filename="hand.stl"/>'), encoding="utf-8")
    with pytest.raises(BadInputFile, match=r"hand\.stl: cannot be read"):
        robot(register(path))


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


@pytest.mark.thorough
def test_every_serial_arm_of_the_package_avoids_or_is_refused_for_a_reason(registry: None) -> None:
    fits: dict[str, str] = {}
    for path in urdf_files():
        try:
            fits[path.stem] = register(path)
        except DuetError as error:
            assert str(path) in str(error)
    assert {"kinova", "panda", "talos_left_arm", "ur3_robot", "ur5_robot", "ur10_robot", "xarm7", "z1"} <= set(fits)
    for stem in ("kinova", "talos_left_arm", "ur10_robot", "ur3_gripper", "xarm7", "z1"):
        settings = replace(RunSettings(), robot=fits[stem], rig="table", dt=0.01)
        assert column(run(settings, 5.0).table, "d").min() >= settings.law.critical_distance, stem
        assert len(robot_glbs(fits[stem], "orange", coarse=True)) == robot(fits[stem]).model.nv + 1
