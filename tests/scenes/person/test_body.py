"""The drawn person has the joints of the model, and its arms end where the angles say."""

import importlib.metadata
import io
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import trimesh
from hypothesis import given
from numpy.testing import assert_allclose

from controllers.errors import DuetError
from controllers.kinematics import Array
from scenes.person import body
from scenes.person.angles import MODEL_PROPORTIONS, arm_points
from scenes.person.source import MissingPackage
from tests.scenes.helpers import own_cache
from tests.scenes.person.strategies import SIDES, arms, bodies

NAMES = ("body", "left_upper_arm", "left_forearm", "right_upper_arm", "right_forearm")


@pytest.fixture(scope="module", autouse=True)
def cache_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    with own_cache(tmp_path_factory.mktemp("cache"), body.body_parts) as folder:
        yield folder


@cache
def human() -> pin.Model:
    return pin.buildModelFromUrdf(str(body._human_urdf()))


def model_points(angles: Array) -> Array:
    """Shoulder, elbow and wrist of both arms (2, 3, 3) of the URDF with these angles, in the torso frame."""
    model = human()
    data, q = model.createData(), pin.neutral(model)
    for i, side in enumerate(SIDES):
        for joint, value in zip(("shoulder_Z", "shoulder_X", "shoulder_Y", "elbow_Z"), angles[i] * [1, 1, -1, 1], strict=True):
            q[model.joints[model.getJointId(f"{side}_{joint}")].idx_q] = value
    pin.framesForwardKinematics(model, data, q)
    ids = [[model.getJointId(f"{side}_{joint}_Z") for joint in ("shoulder", "elbow", "wrist")] for side in SIDES]
    points = np.array([[data.oMi[id].translation for id in arm] for arm in ids])
    return (points - points[:, 0].mean(axis=0)) @ body.TORSO_FROM_MODEL.T


def drawn_poses(angles: Array) -> dict[str, pin.SE3]:
    """Node → its pose against the body node, put together from parts and poses as a page would."""
    turns, placed = body.body_poses(angles), {"body": pin.SE3.Identity()}
    for part in body.body_parts()[1:]:
        w, x, y, z = turns[part.name]
        placed[part.name] = placed[part.parent] * pin.SE3(pin.Quaternion(w, x, y, z).toRotationMatrix(), part.pose.translation)
    return placed


@given(bodies(arms))
def test_our_angles_are_the_models_joints(angles: Array) -> None:
    wanted = [arm_points(angles[i], side) for i, side in enumerate(SIDES)]
    assert_allclose(model_points(angles), wanted, atol=1e-9)


def test_the_nodes_go_where_the_arms_go() -> None:
    for angles in np.random.default_rng(2).uniform(-1.0, 2.0, (20, 2, 4)):
        placed = drawn_poses(angles)
        for i, side in enumerate(SIDES):
            shoulder, elbow, wrist = arm_points(angles[i], side)
            assert_allclose(placed[f"{side}_upper_arm"].translation, shoulder, atol=1e-3)
            forearm = placed[f"{side}_forearm"]
            assert_allclose(forearm.translation, elbow, atol=1e-3)
            assert_allclose(forearm.act(np.array([0.0, 0.0, -MODEL_PROPORTIONS.forearm])), wrist, atol=1e-3)


def test_the_parts() -> None:
    parts = body.body_parts()
    assert tuple(part.name for part in parts) == NAMES
    assert all(part.parent in ("", *NAMES[:i]) for i, part in enumerate(parts))
    assert set(body.body_poses(np.zeros((2, 4)))) == set(NAMES[1:])
    assert sum(len(part.glb) for part in parts) < 600_000
    lowest, highest = np.inf, -np.inf
    for part in parts:
        mesh = trimesh.load(io.BytesIO(part.glb), file_type="glb", force="mesh")
        assert isinstance(mesh, trimesh.Trimesh)
        assert 300 < len(mesh.faces) < 15_000
        if part.name == "body":
            lowest, highest = (float(mesh.bounds[i][2] + part.pose.translation[2]) for i in (0, 1))
    assert abs(lowest) < 2e-3
    assert 1.75 < highest < 1.85


def test_bones_run_along_the_meshes() -> None:
    p, meshes = MODEL_PROPORTIONS, body.person_meshes()
    for side in SIDES:
        for name, length in ((f"{side}_upper_arm", p.upper_arm), (f"{side}_forearm", p.forearm)):
            low, high = meshes[name].bounds
            assert np.abs([low[:2], high[:2]]).max() < 0.07 and -0.005 < high[2] < 0.05
            assert low[2] < -0.95 * length
    for name in ("upper_arm", "forearm"):
        left, right = meshes[f"left_{name}"].bounds, meshes[f"right_{name}"].bounds
        assert_allclose(left[:, [0, 2]], right[:, [0, 2]], atol=2e-3)
        assert_allclose(left[:, 1], -right[::-1, 1], atol=8e-3)


def test_the_cache(cache_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = [part.glb for part in body.body_parts()]
    assert list(cache_folder.iterdir())
    body.body_parts.cache_clear()
    monkeypatch.setattr(body, "person_meshes", lambda: pytest.fail("built again"))
    assert [part.glb for part in body.body_parts()] == first


def test_without_the_package(cache_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:

    def missing(name: str) -> str:
        raise importlib.metadata.PackageNotFoundError(name)

    for file in cache_folder.iterdir():
        file.unlink()
    body.body_parts.cache_clear()
    with monkeypatch.context() as patch:
        patch.setattr(body, "version", missing)
        with pytest.raises(MissingPackage, match="pip install example-robot-data") as caught:
            body.body_parts()
    assert isinstance(caught.value, DuetError)
    monkeypatch.setattr(importlib.metadata, "files", lambda _: [])
    with pytest.raises(MissingPackage, match="without its human model"):
        body.body_parts()
