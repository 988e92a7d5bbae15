"""The drawn person: arms match the angles and follow a drag as far as possible, without jumps."""

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
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from controllers.errors import DuetError
from controllers.kinematics import Array
from scenes.person import body
from scenes.person.angles import FOREARM, UPPER_ARM, arm_directions, arm_points
from scenes.person.clips import REST
from scenes.person.figure import MOST_BENT, Figure
from scenes.person.source import MissingPackage
from scenes.settings import ArmName
from tests.approved import Approve, case_lines
from tests.scenes.helpers import own_cache, refusal
from tests.scenes.person.strategies import SIDES, arms, bodies

NAMES = ("body", "left_upper_arm", "left_forearm", "right_upper_arm", "right_forearm")


@pytest.fixture(scope="module", autouse=True)
def cache_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    with own_cache(tmp_path_factory.mktemp("cache"), body.body_parts) as folder:
        yield folder


@cache
def human() -> pin.Model:
    return pin.buildModelFromUrdf(str(body.human_urdf()))


def model_points(angles: Array) -> Array:
    """Shoulder, elbow and wrist of both arms (2, 3, 3) of the URDF, in the torso frame."""
    model = human()
    data, q = model.createData(), pin.neutral(model)
    for i, side in enumerate(SIDES):
        for joint, value in zip(
            ("shoulder_Z", "shoulder_X", "shoulder_Y", "elbow_Z"), angles[i] * [1, 1, -1, 1], strict=True
        ):
            q[model.joints[model.getJointId(f"{side}_{joint}")].idx_q] = value
    pin.framesForwardKinematics(model, data, q)
    ids = [
        [model.getJointId(f"{side}_{joint}_Z") for joint in ("shoulder", "elbow", "wrist")] for side in SIDES
    ]
    points = np.array([[data.oMi[id].translation for id in arm] for arm in ids])
    return (points - points[:, 0].mean(axis=0)) @ body.TORSO_FROM_MODEL.T


def drawn_poses(angles: Array) -> dict[str, pin.SE3]:
    """Node → its pose in the body node, composed from parts and poses as on a page."""
    turns, placed = body.body_poses(angles), {"body": pin.SE3.Identity()}
    for part in body.body_parts()[1:]:
        w, x, y, z = turns[part.name]
        placed[part.name] = placed[part.parent] * pin.SE3(
            pin.Quaternion(w, x, y, z).toRotationMatrix(), part.pose.translation
        )
    return placed


@given(bodies(arms))
def test_our_angles_match_the_models_joints(angles: Array) -> None:
    wanted = [arm_points(angles[i], side) for i, side in enumerate(SIDES)]
    assert_allclose(model_points(angles), wanted, atol=1e-9)


def test_the_nodes_follow_the_arms() -> None:
    for angles in np.random.default_rng(2).uniform(-1.0, 2.0, (20, 2, 4)):
        placed = drawn_poses(angles)
        for i, side in enumerate(SIDES):
            shoulder, elbow, wrist = arm_points(angles[i], side)
            assert_allclose(placed[f"{side}_upper_arm"].translation, shoulder, atol=1e-3)
            forearm = placed[f"{side}_forearm"]
            assert_allclose(forearm.translation, elbow, atol=1e-3)
            assert_allclose(forearm.act(np.array([0.0, 0.0, -FOREARM])), wrist, atol=1e-3)


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
    meshes = body.person_meshes()
    for side in SIDES:
        for name, length in ((f"{side}_upper_arm", UPPER_ARM), (f"{side}_forearm", FOREARM)):
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


def test_without_the_package(cache_folder: Path, monkeypatch: pytest.MonkeyPatch, approve: Approve) -> None:
    def missing(name: str) -> str:
        raise importlib.metadata.PackageNotFoundError(name)

    for file in cache_folder.iterdir():
        file.unlink()
    body.body_parts.cache_clear()
    with monkeypatch.context() as patch:
        patch.setattr(body, "version", missing)
        with pytest.raises(MissingPackage, match="example-robot-data") as caught:
            body.body_parts()
    assert isinstance(caught.value, DuetError)
    monkeypatch.setattr(importlib.metadata, "files", lambda _: [])
    without = refusal(body.body_parts)
    approve("missing packages.txt", case_lines({"no package": caught.value, "no human model": without}))


SHORTEST = float(np.hypot(UPPER_ARM + FOREARM * np.cos(MOST_BENT), FOREARM * np.sin(MOST_BENT)))
LONGEST = UPPER_ARM + FOREARM

points = st.tuples(*[st.floats(-1.0, 1.0)] * 3).map(np.array)


def check_lengths(figure: Figure) -> None:
    assert np.isfinite(figure.angles()).all() and (figure.angles()[:, 3] <= MOST_BENT + 1e-6).all()
    for side in SIDES:
        shoulder, elbow, wrist = figure.points(side)
        assert np.isclose(np.linalg.norm(elbow - shoulder), UPPER_ARM)
        assert np.isclose(np.linalg.norm(wrist - elbow), FOREARM)


@given(bodies(arms), st.sampled_from(SIDES), points)
def test_a_wrist_and_an_elbow_follow_a_drag(start: Array, side: ArmName, point: Array) -> None:
    arm, wrist, elbow = SIDES.index(side), Figure(start=start), Figure(start=start)
    shoulder = wrist.points(side)[0]
    distance = float(np.linalg.norm(point - shoulder))
    if distance < 0.01:
        return
    for _ in range(3):
        wrist.drag_wrist(side, point)
        elbow.drag_elbow(side, point)
    for figure in (wrist, elbow):
        check_lengths(figure)
        assert_allclose(figure.angles()[1 - arm], start[1 - arm], atol=0.0)
    way, before = (point - shoulder) / distance, arm_directions(start[arm], side)[1]
    assert_allclose(wrist.points(side)[2], shoulder + way * np.clip(distance, SHORTEST, LONGEST), atol=1e-3)
    upper, forearm = arm_directions(elbow.angles()[arm], side)
    assert_allclose(upper, way, atol=2e-3)
    if upper @ before > np.cos(MOST_BENT) + 1e-3:
        assert_allclose(forearm, before, atol=4e-3)


@pytest.mark.parametrize("side", SIDES)
def test_a_drag_in_small_steps_moves_in_small_steps(side: ArmName) -> None:
    figure = Figure()
    worst = 0.0
    before = np.array(figure.points(side))
    centre = before[2] + [0.0, 0.0, 0.15]
    for angle in np.linspace(-0.5 * np.pi, 3.5 * np.pi, 1600):
        figure.drag_wrist(side, centre + np.array([0.4 * np.cos(angle), 0.0, 0.15 * np.sin(angle)]))
        now = np.array(figure.points(side))
        worst = max(worst, float(np.abs(now - before).max()))
        before = now
    # Near the stretched arm the elbow moves with the square root of the wrist's motion.
    assert worst < 0.03


def test_swivel_and_reset() -> None:
    # A drag to the same place moves no elbow; a drag towards the shoulder keeps the elbow's plane.
    figure = Figure(start=np.radians([[40.0, 35.0, 20.0, 70.0]] * 2))
    shoulder, elbow, wrist = figure.points("left")
    figure.drag_wrist("left", wrist)
    assert_allclose(figure.points("left")[1], elbow, atol=1e-9)
    plane = np.cross(wrist - shoulder, elbow - shoulder)
    figure.drag_wrist("left", shoulder + 0.8 * (wrist - shoulder))
    assert abs(plane @ (figure.points("left")[1] - shoulder)) < 1e-9
    # Reset restores the start; returned angles are a copy.
    figure = Figure()
    figure.drag_wrist("left", np.array([0.3, 0.2, 0.1]))
    check_lengths(figure)
    figure.reset()
    figure.angles()[:] = 9.0
    assert_allclose(figure.angles(5.0), REST, atol=0.0)


@pytest.mark.parametrize("point", [[np.nan, 0, 0], [np.inf, 0, 0], [1e200, 0, 0], [0.0, 0.21, 0.0]])
def test_an_invalid_point_or_the_shoulder_keeps_the_figure_intact(point: list[float]) -> None:
    for drag in (Figure.drag_wrist, Figure.drag_elbow):
        figure = Figure()
        with np.errstate(over="ignore"):
            drag(figure, "left", np.array(point))
        check_lengths(figure)


@pytest.mark.parametrize("direction", np.vstack([np.eye(3), -np.eye(3)]))
def test_straight_arms_bend_somewhere(direction: Array) -> None:
    figure = Figure(start=np.zeros((2, 4)))
    shoulder = figure.points("right")[0]
    figure.drag_elbow("right", shoulder + direction)
    figure.drag_wrist("right", shoulder + direction)
    check_lengths(figure)
    figure.drag_wrist("right", shoulder + 0.4 * direction)
    check_lengths(figure)
    assert_allclose(figure.points("right")[2], shoulder + 0.4 * direction, atol=2e-3)


@given(bodies(arms), st.sampled_from(SIDES), st.booleans(), st.floats(0.1, 1.5), points)
def test_a_grasped_point_follows_the_pull(
    start: Array, side: ArmName, forearm: bool, share: float, way: Array
) -> None:
    """From the shoulder to beyond the wrist: a short pull moves the point there if its bone allows."""
    figure = Figure(start=start)
    shoulder, elbow, wrist = figure.points(side)
    first, last = (elbow, wrist) if forearm else (shoulder, elbow)
    taken = first + min(share, 1.5 if forearm else 1.0) * (last - first)
    grasp = figure.grasp(side, forearm, taken)
    goal = taken + 0.02 * way
    figure.pull(grasp, taken)
    assert_allclose(figure.points(side), (shoulder, elbow, wrist), atol=5e-3)
    figure.pull(grasp, goal)
    check_lengths(figure)
    if grasp.forearm and 0.2 < np.linalg.norm(goal - shoulder) < 0.8 * LONGEST and grasp.along <= 0.0:
        _, elbow, wrist = figure.points(side)
        held = wrist + (wrist - elbow) * (grasp.along / FOREARM) + grasp.aside
        assert np.linalg.norm(held - goal) < 0.02
