"""Any arm: the robots of example-robot-data move, collide and look as their own files say."""

import importlib.metadata
import itertools
import json
import struct
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import get_args

import coal
import numpy as np
import pinocchio as pin
import platformdirs
import pytest
import trimesh
import yourdfpy
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from controllers.errors import BadSetting
from controllers.kinematics import Arm, Array, Kinematics
from controllers.limits import VelocityBox
from scenes.guide import Guide, HandTarget
from scenes.headless import run
from scenes.rigs import RIGS
from scenes.robots import Robot, RobotName, drawing, lwr, robot, start_posture
from scenes.robots.drawing import joint_frames, link_meshes, robot_glbs
from scenes.robots.enclosing import GRID, SHORTEST, enclosing_capsule
from scenes.robots.example_data import EXAMPLES
from scenes.robots.fitting import build_example
from scenes.settings import ArmName, RigName
from tests.scenes.helpers import RIG_NAMES, column, hold_settings

NAMES: tuple[RobotName, ...] = get_args(RobotName)
OTHERS: tuple[RobotName, ...] = ("panda", "ur5")
ROOT_LINK = {"panda": "panda_link0", "ur5": "base_link"}


# ---- the same robot, read by another program ------------------------------------------------------------------------------------


@cache
def other_reader(name: RobotName) -> yourdfpy.URDF:
    """The robot's file as yourdfpy reads it."""
    files = importlib.metadata.files("example-robot-data")
    assert files is not None
    (urdf,) = (Path(str(file.locate())) for file in files if str(file).endswith(EXAMPLES[name].urdf))
    share = next(folder for folder in urdf.parents if folder.name == "robots").parent.parent
    return yourdfpy.URDF.load(
        str(urdf), load_meshes=False, filename_handler=lambda text: str(share / text.removeprefix("package://"))
    )


def link_poses(name: RobotName, q: Array) -> dict[str, Array]:
    """Pose (4, 4) of every link in the frame of the arm's base, as yourdfpy computes it."""
    reader, fingers = other_reader(name), list(EXAMPLES[name].locked.values())
    reader.update_cfg(np.r_[q, fingers[: len(reader.actuated_joint_names) - len(q)]])
    lift = np.eye(4)
    lift[2, 3] = EXAMPLES[name].column
    return {link: lift @ reader.get_transform(link, ROOT_LINK[name]) for link in reader.link_map}


@cache
def collision_points(name: RobotName) -> dict[str, Array]:
    """Points (k, 3) all over the collision shapes of every link, in its frame, read by yourdfpy and trimesh."""
    reader, found = other_reader(name), {}
    random = np.random.default_rng(4)
    for link in reader.link_map.values():
        points = [np.zeros((0, 3))]
        for collision in link.collisions:
            shape = collision.geometry
            solid = (
                trimesh.creation.box(shape.box.size)
                if shape.box is not None
                else trimesh.load_mesh(reader._filename_handler(shape.mesh.filename))
            )
            if collision.origin is not None:
                solid.apply_transform(collision.origin)
            weights = random.dirichlet(np.ones(3), (len(solid.faces), 12))
            inner = np.einsum("fkc,fcd->fkd", weights, solid.triangles).reshape(-1, 3)
            points += [np.asarray(solid.vertices), inner]
        found[link.name] = np.concatenate(points)
    return found


def postures(model: pin.Model, count: int, seed: int = 7) -> Array:
    """Postures (count, n) anywhere between the stops."""
    return np.random.default_rng(seed).uniform(model.lowerPositionLimit, model.upperPositionLimit, (count, model.nq))


@pytest.mark.parametrize("name", OTHERS)
def test_both_readers_agree_everywhere(name: RobotName) -> None:
    """Every frame that has the name of a link, the hand among them, over the whole range of the joints."""
    model = robot(name).model
    data = model.createData()
    for q in postures(model, 10):
        pin.framesForwardKinematics(model, data, q)
        poses = link_poses(name, q)
        assert robot(name).hand in poses
        for link, pose in poses.items():
            assert_allclose(data.oMf[model.getFrameId(link)].homogeneous, pose, atol=1e-9, err_msg=link)


@pytest.mark.parametrize("name", OTHERS)
def test_limits_are_those_of_the_file(name: RobotName) -> None:
    model, reader = robot(name).model, other_reader(name)
    for i, joint in enumerate(list(model.names)[1:]):
        limit = reader.joint_map[joint].limit
        assert (model.lowerPositionLimit[i], model.upperPositionLimit[i]) == (limit.lower, limit.upper)
        assert model.velocityLimit[i] == limit.velocity


# ---- what a robot is --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "joints"), [("lwr", 7), ("panda", 7), ("ur5", 6)])
def test_a_robot_is_complete(name: RobotName, joints: int) -> None:
    arm = robot(name)
    assert robot(name) is arm
    assert arm.model.nq == arm.model.nv == len(arm.labels) == len(set(arm.labels)) == joints
    assert arm.model.existFrame(arm.hand)
    assert 1 <= arm.shoulder < arm.elbow < arm.wrist <= joints
    assert 1 <= len(arm.capsules) <= 6
    assert len({capsule.name for capsule in arm.capsules}) == len(arm.capsules)
    carriers = [capsule.joint for capsule in arm.capsules]
    assert min(carriers) == 0 and carriers == sorted(set(carriers))


def test_the_paper_s_robot_is_the_one_it_was() -> None:
    assert lwr() is robot("lwr") and lwr().name == "KUKA LWR 4+"


@pytest.mark.parametrize("name", NAMES)
def test_landmarks_make_an_arm(name: RobotName) -> None:
    """Shoulder, elbow and wrist stand well apart and off one line, so that there is an elbow to swivel; the shoulder is at rest."""
    arm = robot(name)
    data = arm.model.createData()
    pin.forwardKinematics(arm.model, data, start_posture(name, "table", "left"))
    shoulder, elbow, wrist = (data.oMi[joint].translation.copy() for joint in (arm.shoulder, arm.elbow, arm.wrist))
    upper, fore = elbow - shoulder, wrist - elbow
    assert min(np.linalg.norm(upper), np.linalg.norm(fore)) > 0.3
    bend = np.arccos(upper @ fore / np.linalg.norm(upper) / np.linalg.norm(fore))
    assert np.radians(50) < bend < np.radians(140)


def test_an_unknown_robot_names_the_known_ones() -> None:
    with pytest.raises(BadSetting, match=r"'r2d2'.*lwr, panda, ur5"):
        robot("r2d2")  # pyright: ignore[reportArgumentType]


def test_a_missing_package_is_named_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr("importlib.metadata.files", missing)
    with pytest.raises(BadSetting, match="pip install example-robot-data"):
        build_example(EXAMPLES["panda"])


def test_an_empty_package_is_named_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.metadata.files", lambda _: [])
    with pytest.raises(BadSetting, match=r"without its robots.*pip install"):
        build_example(EXAMPLES["panda"])


def test_a_damaged_package_is_named_with_its_remedy() -> None:
    with pytest.raises(BadSetting, match=r"damaged.*pip install"):
        build_example(replace(EXAMPLES["ur5"], urdf="ur_description/urdf/gone.urdf"))


# ---- capsules ---------------------------------------------------------------------------------------------------------------------


def outside(name: RobotName, points: dict[str, Array], q: Array, slimmer: dict[str, float] | None = None) -> float:
    """How far the farthest of the links' points is outside the union of the capsules at q, some of them made slimmer [m]."""
    arm = robot(name)
    data = arm.model.createData()
    pin.forwardKinematics(arm.model, data, q)
    poses = link_poses(name, q)
    world = np.vstack([cloud @ poses[link][:3, :3].T + poses[link][:3, 3] for link, cloud in points.items()])
    return float(np.min([_away(capsule, data, world, slimmer or {}) for capsule in arm.capsules], axis=0).max())


def _away(capsule, data: pin.Data, world: Array, slimmer: dict[str, float]) -> Array:
    pose = data.oMi[capsule.joint]
    return capsule.outside((world - pose.translation) @ pose.rotation) + slimmer.get(capsule.name, 0.0)


@pytest.mark.parametrize("name", OTHERS)
def test_capsules_enclose_all_that_can_collide(name: RobotName) -> None:
    """Vertices of the robot's own collision shapes, and points all over them, at any posture."""
    points = collision_points(name)
    assert sum(len(cloud) for cloud in points.values()) > 10_000
    for q in postures(robot(name).model, 15):
        assert outside(name, points, q) < 1e-9


@pytest.mark.parametrize(("name", "part"), [(name, segment.name) for name in OTHERS for segment in EXAMPLES[name].segments])
def test_capsules_are_tight(name: RobotName, part: str) -> None:
    """Each capsule, made 3 mm slimmer, would let something stick out."""
    points = collision_points(name)
    assert max(outside(name, points, q, {part: 0.003}) for q in postures(robot(name).model, 8)) > 0


@pytest.mark.parametrize(("coarse", "slack"), [(False, 0.001), (True, 0.003)])
@pytest.mark.parametrize("name", OTHERS)
def test_what_is_seen_is_inside_the_capsules(name: RobotName, coarse: bool, slack: float) -> None:
    """Drawn links lie inside the capsules but for a millimetre, so that what a person sees touch has touched."""
    arm = robot(name)
    data = arm.model.createData()
    for q in postures(arm.model, 5):
        pin.forwardKinematics(arm.model, data, q)
        world = np.vstack(
            [
                part.vertices @ data.oMi[joint].rotation.T + data.oMi[joint].translation
                for joint, parts in enumerate(link_meshes(name, coarse))
                for part in parts.values()
            ]
        )
        assert np.min([_away(capsule, data, world, {}) for capsule in arm.capsules], axis=0).max() < slack


def test_outside_of_a_capsule() -> None:
    capsule = lwr().capsules[1]
    points = np.array([(0.0, 0.0, 0.2), (0.1, 0.0, 0.2), (0.0, 0.0, 0.5), (0.0, -0.3, -0.4)])
    assert_allclose(capsule.outside(points), [-0.07, 0.03, 0.03, 0.43], atol=1e-12)


turns = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(lambda v: pin.exp3(np.array(v)))


@settings(max_examples=12)
@given(turns, st.floats(0.02, 0.4), st.floats(0.03, 0.12), st.integers(0, 99))
def test_a_capsule_is_found_again(turn: Array, length: float, radius: float, seed: int) -> None:
    """Points on a capsule, anywhere and however turned: the capsule found encloses them and is hardly larger."""
    normals = np.random.default_rng(seed).normal(size=(600, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    on_axis = np.where(normals[:, 2:] > 0, length, 0.0) * np.array([0.0, 0.0, 1.0])
    points = (radius * normals + on_axis) @ turn.T + np.array([0.1, -0.2, 0.3])
    start, end, found = enclosing_capsule(points)
    axis = end - start
    share = np.clip((points - start) @ axis / (axis @ axis), 0.0, 1.0)
    assert np.linalg.norm(points - start - share[:, None] * axis, axis=1).max() <= found + 1e-9
    volume = np.pi * found**2 * (np.linalg.norm(axis) + 4 / 3 * found)
    assert volume < 1.1 * np.pi * radius**2 * (length + 4 / 3 * radius)


def test_a_point_like_cloud_gets_a_capsule_with_an_axis() -> None:
    corners = 0.02 * np.array(list(itertools.product((-1, 1), repeat=3)))
    start, end, radius = enclosing_capsule(corners)
    assert np.linalg.norm(end - start) >= SHORTEST - 1e-9
    assert radius <= 0.02 * np.sqrt(3) + 2 * GRID


def test_capsules_come_out_alike_every_time() -> None:
    for a, b in zip(robot("ur5").capsules, build_example(EXAMPLES["ur5"]).capsules, strict=True):
        assert_array_equal(np.r_[a.start, a.end, a.radius], np.r_[b.start, b.end, b.radius])


# ---- two of them in a room ----------------------------------------------------------------------------------------------------------


class Duo:
    """Two arms on a rig, with the pairs of their capsules that can come closer."""

    def __init__(self, names: tuple[RobotName, RobotName], rig_name: RigName) -> None:
        rig, sides = RIGS[rig_name], get_args(ArmName)
        self.robots = [robot(name) for name in names]
        self.model, self.geometry, self.arms = pin.Model(), pin.GeometryModel(), []
        for side, arm, base in zip(sides, self.robots, (rig.left_base, rig.right_base), strict=True):
            first, before = self.model.nv, self.model.njoints - 1
            self.model = pin.appendModel(self.model, _renamed(arm.model, side), 0, base)
            hand = self.model.getFrameId(f"{side} {arm.hand}")
            landmarks = (arm.shoulder + before, arm.elbow + before, arm.wrist + before)
            self.arms.append(Arm(side, slice(first, first + arm.model.nv), hand, *landmarks, arm.labels))
            for capsule in arm.capsules:
                joint = capsule.joint + before if capsule.joint else 0
                axis = capsule.end - capsule.start
                turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), axis / np.linalg.norm(axis)).toRotationMatrix()
                pose = pin.SE3(turn, (capsule.start + capsule.end) / 2.0)
                shape = coal.Capsule(capsule.radius, float(np.linalg.norm(axis)))
                self.geometry.addGeometryObject(
                    pin.GeometryObject(f"{side} {capsule.name}", joint, pose if joint else base * pose, shape)
                )
        bodies, half = self.geometry.geometryObjects, len(self.robots[0].capsules)
        for a, b in itertools.product(range(half), range(half, len(bodies))):
            if bodies[a].parentJoint or bodies[b].parentJoint:
                self.geometry.addCollisionPair(pin.CollisionPair(a, b))
        self.start = np.concatenate(
            [start_posture(name, rig_name, side) for name, side in zip(names, sides, strict=True)], dtype=float
        )

    def distance(self, q: Array) -> float:
        """Smallest distance between the arms at q (nv,) [m]."""
        data, pairs = self.model.createData(), self.geometry.createData()
        pin.computeDistances(self.model, data, self.geometry, pairs, q)
        return min(result.min_distance for result in pairs.distanceResults)


def _renamed(model: pin.Model, side: str) -> pin.Model:
    model = model.copy()
    for i in range(1, model.njoints):
        model.names[i] = f"{side} {model.names[i]}"
    for i in range(1, model.nframes):
        model.frames[i].name = f"{side} {model.frames[i].name}"
    return model


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("names", list(itertools.product(NAMES, NAMES)), ids="-".join)
def test_arms_start_clear_of_each_other(names: tuple[RobotName, RobotName], rig: RigName) -> None:
    """Also where the two are not of one make."""
    duo = Duo(names, rig)
    assert duo.distance(duo.start) >= 0.25


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("name", NAMES)
def test_arms_start_far_from_their_stops_and_mirrored(name: RobotName, rig: RigName) -> None:
    """At least 15° from every stop; hands at the same height, on either side, in front."""
    duo = Duo((name, name), rig)
    room = np.minimum(duo.start - duo.model.lowerPositionLimit, duo.model.upperPositionLimit - duo.start)
    assert room.min() > np.radians(15)
    data = duo.model.createData()
    pin.framesForwardKinematics(duo.model, data, duo.start)
    left, right = (data.oMf[arm.hand].translation for arm in duo.arms)
    flip = (1, -1, 1) if rig == "torso" else (-1, -1, 1)
    assert_allclose(left, right * flip, atol=2e-3)
    assert left[0] > 0.6 if rig == "torso" else -0.45 < left[0] < -0.15
    assert 0.8 < left[2] < 1.6


def test_a_start_posture_is_a_copy() -> None:
    start_posture("lwr", "torso", "left")[0] = 9.0
    assert_array_equal(start_posture("lwr", "torso", "left"), RIGS["torso"].left_start)
    assert_array_equal(start_posture("lwr", "torso", "right"), RIGS["torso"].right_start)


def axis_points(arm: Robot, data: pin.Data, first: int) -> Array:
    """Points (k, 3) all along the axes of an arm's moving capsules."""
    return np.array(
        [
            data.oMi[capsule.joint + first].act(capsule.start + part * (capsule.end - capsule.start))
            for capsule in arm.capsules
            if capsule.joint
            for part in (0.0, 0.3, 0.7, 1.0)
        ]
    )


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("name", NAMES)
def test_a_hand_can_be_dragged_towards_the_other_arm(name: RobotName, rig: RigName) -> None:
    """10 cm towards the other hand, reached to a millimetre, at no more than a person's speed anywhere on the arm's axes."""
    duo, dt, top_speed = Duo((name, name), rig), 0.005, 0.25
    kinematics = Kinematics(duo.model, tuple(duo.arms))
    other, arm = duo.arms
    joints, q, make = arm.joints, duo.start.copy(), duo.robots[1]
    model = duo.model
    box = VelocityBox(
        model.lowerPositionLimit[joints].copy(), model.upperPositionLimit[joints].copy(), model.velocityLimit[joints].copy(), 10.0
    )
    guide = Guide(kinematics, arm, make, box, duo.start[joints])
    kinematics.update(q)
    hand, aim = kinematics.hand_pose(arm).translation.copy(), kinematics.hand_pose(other).translation.copy()
    goal = hand + 0.10 * (aim - hand) / np.linalg.norm(aim - hand)
    first = arm.shoulder - make.shoulder
    before, fastest = axis_points(make, kinematics.data, first), 0.0
    for _ in range(400):
        box.update(q[joints])
        q[joints] += guide.follow(HandTarget(goal), q[joints], dt, top_speed) * dt
        kinematics.update(q)
        after = axis_points(make, kinematics.data, first)
        fastest = max(fastest, float(np.linalg.norm(after - before, axis=1).max()) / dt)
        before = after
    assert np.linalg.norm(kinematics.hand_pose(arm).translation - goal) < 1e-3
    assert 0.5 * top_speed < fastest <= 1.005 * top_speed
    assert 0 < duo.distance(q) < duo.distance(duo.start) + 0.01


@pytest.mark.parametrize("rig", RIG_NAMES)
@pytest.mark.parametrize("name", OTHERS)
def test_the_paper_s_law_keeps_other_robots_clear(name: RobotName, rig: RigName) -> None:
    """The autopilot's hand comes as near as with the LWR, and never nearer than d_m; the start postures are chosen for that."""
    for guided in get_args(ArmName):
        chosen = replace(hold_settings(rig, seed=2), robot=name, guided=guided)
        distances = column(run(chosen, 46.0).table, "d")
        assert chosen.law.critical_distance <= distances.min() < 1.2 * chosen.law.critical_distance


# ---- what they look like ------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module", autouse=True)
def cache_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A cache of our own, so that the shells really are built."""
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(platformdirs, "user_cache_dir", lambda *_: str(folder))
        robot_glbs.cache_clear()
        yield folder
    robot_glbs.cache_clear()


def head_of(data: bytes) -> dict:
    size, kind = struct.unpack("<II", data[12:20])
    assert data[:4] == b"glTF" and kind == 0x4E4F534A
    return json.loads(data[20 : 20 + size])


@pytest.mark.parametrize("palette", ["orange", "ghost"])
@pytest.mark.parametrize("name", NAMES)
def test_a_robot_is_small(name: RobotName, palette: str) -> None:
    fine, coarse = robot_glbs(name, palette), robot_glbs(name, palette, coarse=True)
    assert len(fine) == len(coarse) == robot(name).model.njoints
    assert sum(map(len, fine)) <= 1_000_000
    assert sum(map(len, coarse)) <= 200_000
    assert all(len(head_of(data)["meshes"]) == 1 for data in coarse)


@pytest.mark.parametrize("coarse", [False, True])
@pytest.mark.parametrize("name", NAMES)
def test_a_ghost_can_be_seen_through(name: RobotName, coarse: bool) -> None:
    """And a solid arm cannot (positive control)."""
    for palette, mode in (("ghost", "BLEND"), ("silver", "OPAQUE")):
        materials = [material for data in robot_glbs(name, palette, coarse) for material in head_of(data)["materials"]]
        assert materials and all(material["alphaMode"] == mode for material in materials)
        opacities = {material["pbrMetallicRoughness"]["baseColorFactor"][3] for material in materials}
        assert max(opacities) < 0.5 if palette == "ghost" else opacities == {1}


@pytest.mark.parametrize("name", OTHERS)
def test_the_two_palettes_differ(name: RobotName) -> None:
    orange, silver = (robot_glbs(name, palette) for palette in ("orange", "silver"))
    # Base and flange of the UR5 are bare metal.
    assert sum(a != b for a, b in zip(orange, silver, strict=True)) >= len(orange) - 2


@pytest.mark.parametrize("coarse", [False, True])
@pytest.mark.parametrize("name", OTHERS)
def test_shells_are_as_large_as_the_shapes_that_collide(name: RobotName, coarse: bool) -> None:
    """Nothing was lost, and nothing stands in a wrong place: boxes around drawn links agree with those of the collision shapes."""
    model, points = robot(name).model, collision_points(name)
    poses = link_poses(name, np.zeros(model.nq))
    data = model.createData()
    pin.forwardKinematics(model, data, np.zeros(model.nq))
    clouds: dict[int, list[Array]] = {}
    for link, cloud in points.items():
        joint, pose = model.frames[model.getFrameId(link)].parentJoint, poses[link]
        world = cloud @ pose[:3, :3].T + pose[:3, 3]
        clouds.setdefault(joint, []).append((world - data.oMi[joint].translation) @ data.oMi[joint].rotation)
    for joint, parts in enumerate(link_meshes(name, coarse)):
        seen = np.vstack([part.vertices for part in parts.values()])
        solid = np.vstack(clouds[joint])
        if joint == 0 and EXAMPLES[name].column:
            assert seen[:, 2].min() == pytest.approx(0.0, abs=1e-9)
            seen = seen[seen[:, 2] > EXAMPLES[name].column - 0.005]
        assert_allclose(seen.max(0), solid.max(0), atol=0.012 if coarse else 0.006)
        assert_allclose(seen.min(0), solid.min(0), atol=0.012 if coarse else 0.006)


@pytest.mark.parametrize("name", OTHERS)
def test_normals_are_unit_and_agree_with_the_faces(name: RobotName) -> None:
    for parts in link_meshes(name):
        for part in parts.values():
            assert_allclose(np.linalg.norm(part.vertex_normals, axis=1), 1, atol=1e-6)
            agree = np.einsum("ij,ij->i", part.face_normals, part.vertex_normals[part.faces].mean(1))
            assert np.percentile(agree[part.area_faces > 1e-8], 1) > 0.3


@pytest.mark.parametrize("name", NAMES)
def test_joint_frames_rebuild_the_chain(name: RobotName) -> None:
    """Position, rotation and axis of every joint give Pinocchio's joint poses."""
    model = robot(name).model
    data = model.createData()
    for q in postures(model, 5):
        pin.forwardKinematics(model, data, q)
        pose = pin.SE3.Identity()
        for joint, (frame, angle) in enumerate(zip(joint_frames(name), q, strict=True), start=1):
            turn = pin.Quaternion(*frame.rotation).toRotationMatrix() @ pin.exp3(np.array(frame.axis) * angle)
            pose = pose * pin.SE3(turn, np.array(frame.position))
            assert frame.name == model.names[joint]
            assert_allclose(pose.homogeneous, data.oMi[joint].homogeneous, atol=1e-9)


def test_an_unknown_palette_names_the_valid_ones() -> None:
    with pytest.raises(ValueError, match="orange"):
        robot_glbs("panda", "mauve")


def test_shells_come_from_the_cache(monkeypatch: pytest.MonkeyPatch) -> None:
    first = robot_glbs("ur5", "silver", coarse=True)
    robot_glbs.cache_clear()
    monkeypatch.setattr(drawing, "link_meshes", lambda *_: pytest.fail("built again"))
    assert robot_glbs("ur5", "silver", coarse=True) == first
