"""Capsules enclose all collision shapes tightly; drawn shells are small and inside the capsules."""

import itertools
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from controllers.kinematics import Array
from scenes.robots import RobotName, robot
from scenes.robots.drawing import joint_frames, robot_glbs, robot_link_meshes
from scenes.robots.example_data import EXAMPLES
from scenes.robots.fitting import GRID, SHORTEST, enclosing_capsule, fit_example
from tests.scenes.helpers import beyond, glb_head, own_cache
from tests.scenes.robots.helpers import NAMES, OTHERS, away, collision_points, link_poses, outside, postures

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module", autouse=True)
def cache_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    with own_cache(tmp_path_factory.mktemp("cache"), robot_glbs) as folder:
        yield folder


@pytest.mark.parametrize("coarse", [False, True])
@pytest.mark.parametrize("name", NAMES)
def test_a_robot_is_small_and_its_ghost_is_translucent(name: RobotName, coarse: bool) -> None:
    for palette, mode in (("ghost", "BLEND"), ("silver", "OPAQUE")):
        links = robot_glbs(name, palette, coarse)
        assert len(links) == robot(name).model.njoints and sum(map(len, links)) <= (
            200_000 if coarse else 1_000_000
        )
        heads = [glb_head(data) for data in links]
        assert not coarse or all(len(head["meshes"]) == 1 for head in heads)
        materials = [material for head in heads for material in head["materials"]]
        assert materials and all(material["alphaMode"] == mode for material in materials)
        opacities = {material["pbrMetallicRoughness"]["baseColorFactor"][3] for material in materials}
        assert max(opacities) < 0.5 if palette == "ghost" else opacities == {1}
    with pytest.raises(ValueError, match="orange"):
        robot_glbs(name, "mauve", coarse)


@pytest.mark.parametrize("name", OTHERS)
def test_palettes_and_normals(name: RobotName) -> None:
    orange, silver = (robot_glbs(name, palette) for palette in ("orange", "silver"))
    # Base and flange of the UR5 are bare metal.
    assert sum(a != b for a, b in zip(orange, silver, strict=True)) >= len(orange) - 2
    for parts in robot_link_meshes(name, False):
        for part in parts.values():
            assert_allclose(np.linalg.norm(part.vertex_normals, axis=1), 1, atol=1e-6)
            agree = np.einsum("ij,ij->i", part.face_normals, part.vertex_normals[part.faces].mean(1))
            assert np.percentile(agree[part.area_faces > 1e-8], 1) > 0.3


@pytest.mark.parametrize("coarse", [False, True])
@pytest.mark.parametrize("name", OTHERS)
def test_shells_have_the_size_of_the_collision_shapes(name: RobotName, coarse: bool) -> None:
    model, points = robot(name).model, collision_points(name)
    poses = link_poses(name, np.zeros(model.nq))
    data = model.createData()
    pin.forwardKinematics(model, data, np.zeros(model.nq))
    clouds: dict[int, list[Array]] = {}
    for link, cloud in points.items():
        joint, pose = model.frames[model.getFrameId(link)].parentJoint, poses[link]
        world = cloud @ pose[:3, :3].T + pose[:3, 3]
        clouds.setdefault(joint, []).append((world - data.oMi[joint].translation) @ data.oMi[joint].rotation)
    for joint, parts in enumerate(robot_link_meshes(name, coarse)):
        seen, solid = np.vstack([part.vertices for part in parts.values()]), np.vstack(clouds[joint])
        if joint == 0 and EXAMPLES[name].column:
            assert seen[:, 2].min() == pytest.approx(0.0, abs=1e-9)
            seen = seen[seen[:, 2] > EXAMPLES[name].column - 0.005]
        assert_allclose(
            (seen.min(0), seen.max(0)), (solid.min(0), solid.max(0)), atol=0.012 if coarse else 0.006
        )


@pytest.mark.parametrize("name", NAMES)
def test_joint_frames_rebuild_the_chain(name: RobotName) -> None:
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


@pytest.mark.parametrize(("coarse", "slack"), [(False, 0.001), (True, 0.003)])
@pytest.mark.parametrize("name", NAMES)
def test_shells_are_inside_the_capsules(name: RobotName, coarse: bool, slack: float) -> None:
    """Our own arm needs no slack, by construction."""
    arm = robot(name)
    data = arm.model.createData()
    for q in postures(arm.model, 5):
        pin.forwardKinematics(arm.model, data, q)
        drawn = [
            (data.oMi[joint], part)
            for joint, parts in enumerate(robot_link_meshes(name, coarse))
            for part in parts.values()
        ]
        world = np.vstack([part.vertices @ pose.rotation.T + pose.translation for pose, part in drawn])
        assert np.min([away(capsule, data, world, {}) for capsule in arm.capsules], axis=0).max() < (
            0.0 if name == "lwr" else slack
        )


@pytest.mark.parametrize("name", OTHERS)
def test_capsules_enclose_all_collision_shapes(name: RobotName) -> None:
    points = collision_points(name)
    assert sum(len(cloud) for cloud in points.values()) > 10_000
    for q in postures(robot(name).model, 15):
        assert outside(name, points, q) < 1e-9


@pytest.mark.parametrize(
    ("name", "part"), [(name, segment.name) for name in OTHERS for segment in EXAMPLES[name].segments]
)
def test_capsules_are_tight(name: RobotName, part: str) -> None:
    points = collision_points(name)
    assert max(outside(name, points, q, {part: 0.003}) for q in postures(robot(name).model, 8)) > 0


def test_fitting_by_example() -> None:
    corners = 0.02 * np.array(list(itertools.product((-1, 1), repeat=3)))
    start, end, radius = enclosing_capsule(corners)
    assert np.linalg.norm(end - start) >= SHORTEST - 1e-9
    assert radius <= 0.02 * np.sqrt(3) + 2 * GRID
    for a, b in zip(robot("ur5").capsules, fit_example(EXAMPLES["ur5"]), strict=True):
        assert_array_equal(np.r_[a.start, a.end, a.radius], np.r_[b.start, b.end, b.radius])


turns = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(lambda v: pin.exp3(np.array(v)))


@settings(max_examples=6)
@given(turns, st.floats(0.02, 0.4), st.floats(0.03, 0.12), st.integers(0, 99))
def test_fitting_recovers_a_capsule(turn: Array, length: float, radius: float, seed: int) -> None:
    normals = np.random.default_rng(seed).normal(size=(300, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    on_axis = np.where(normals[:, 2:] > 0, length, 0.0) * np.array([0.0, 0.0, 1.0])
    points = (radius * normals + on_axis) @ turn.T + np.array([0.1, -0.2, 0.3])
    start, end, found = enclosing_capsule(points)
    assert beyond(points, start, end, found).max() <= 1e-9
    volume = np.pi * found**2 * (np.linalg.norm(end - start) + 4 / 3 * found)
    assert volume < 1.1 * np.pi * radius**2 * (length + 4 / 3 * radius)
