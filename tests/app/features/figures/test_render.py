"""Pictures: perspective, occlusion, light and shadow, and arms at their joint angles."""

from typing import Final

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from app.features.figures import fig8_film as film
from app.features.figures.render import Mesh, Viewpoint, arms, ball, furniture, links, meshes, render
from controllers.kinematics import Array
from scenes.person.source import MissingPackage
from scenes.rigs import Camera
from scenes.room import build_room
from scenes.room_shells import MATERIALS, furniture_glb
from scenes.solo import build_alone

WIDE, HIGH = 90, 60
CAMERA: Final = Camera((0.0, 0.0, 1.0), (3.0, 0.0, 0.0), 1.2, 0.8, float(np.radians(20.0)))
"""Horizontal view from +x; y points right."""

RED, BLUE = np.array([0.7, 0.02, 0.02]), np.array([0.02, 0.02, 0.7])


def shot(*meshes: Mesh) -> Array:
    return render(meshes, CAMERA, WIDE, HIGH).astype(float)


def is_red(picture: Array) -> NDArray[np.bool_]:
    return picture[..., 0] > picture[..., 2] + 40.0


def test_the_view_is_centred_and_scaled() -> None:
    view = Viewpoint(CAMERA, WIDE, HIGH)
    flat = view.project(np.array([CAMERA.centre, (0.0, 0.1, 1.0), (0.0, 0.0, 1.1)]))
    assert_allclose(flat[0], (WIDE / 2, HIGH / 2), atol=1e-9)
    # At the centre's distance the picture is 0.8 m high.
    assert_allclose(flat[1:] - flat[0], [(0.1 * HIGH / 0.8, 0.0), (0.0, -0.1 * HIGH / 0.8)], atol=1e-9)
    assert_allclose(np.linalg.norm(view.eye - CAMERA.centre), 0.4 / np.tan(np.radians(10.0)))
    flat = Viewpoint(CAMERA, 40, 80).project(np.array([(0.0, -0.6, 1.0), (0.0, 0.6, 1.0)]))
    assert_allclose(flat[:, 0], (0.0, 40.0), atol=1e-9)


def test_a_sphere_is_a_smooth_disc_and_nothing_behind_the_eye_is_seen() -> None:
    # Shifted by a few mm, so that no outline falls on a pixel border.
    radius, middle = 0.2, np.array([0.0, 0.154, 1.053])
    scene = ball(middle, radius, RED), ball(np.array([9.0, 0.0, 1.0]), 0.5, BLUE)
    raw, picture = render(scene, CAMERA, WIDE, HIGH), shot(*scene)
    assert raw.dtype == np.uint8 and raw.shape == (HIGH, WIDE, 3) and (raw == picture).all()
    assert not (picture[..., 2] > picture[..., 0] + 60.0).any()
    covered, view = is_red(picture), Viewpoint(CAMERA, WIDE, HIGH)
    ((x, y),), depth = view.project(middle[None]), view.axes[2] @ (middle - view.eye)
    # The outline is where the line of sight touches the sphere.
    seen_radius = view.focal * radius / np.sqrt(depth**2 - radius**2)
    rows, columns = np.mgrid[:HIGH, :WIDE] + 0.5
    away = np.hypot(columns - x, rows - y)
    assert covered[away < seen_radius - 1.0].all() and not covered[away > seen_radius + 1.0].any()
    assert covered.sum() == pytest.approx(np.pi * seen_radius**2, rel=0.03)
    row = picture[round(y), :, 1]
    between = (row > row[round(x)] + 25.0) & (
        row < shot(ball(np.array([0.0, 0.0, 9.0]), 0.01, RED))[round(y), :, 1] - 25.0
    )
    assert 1 <= between.sum() <= 6


def test_nearer_objects_hide_farther_ones() -> None:
    for red, blue in ((0.5, -0.5), (-0.5, 0.5)):
        picture = shot(
            ball(np.array([red, 0.0, 1.0]), 0.15, RED), ball(np.array([blue, 0.0, 1.0]), 0.15, BLUE)
        )
        assert is_red(picture)[HIGH // 2, WIDE // 2] == (red > blue)
        # In perspective the nearer ball hides the other one completely.
        assert is_red(picture).any() == (red > blue)


def test_light_comes_from_above_and_casts_a_shadow() -> None:
    sphere = ball(np.array([0.0, 0.0, 1.0]), 0.2, RED)
    alone = shot(sphere)
    column = alone[:, WIDE // 2, 0]
    assert column[HIGH // 2 - 10] > column[HIGH // 2 + 10] + 30.0
    towards_light = np.array([2.4, -2.0, 4.0]) / np.linalg.norm([2.4, -2.0, 4.0])
    shaded = shot(sphere, ball(np.array([0.0, 0.0, 1.0]) + 0.9 * towards_light, 0.22, BLUE))
    both_red = is_red(alone) & is_red(shaded)
    assert both_red.sum() > 200 and (alone[both_red, 0] - shaded[both_red, 0]).max() > 30.0
    assert (shaded[both_red, 0] <= alone[both_red, 0] + 1.0).all()


@pytest.mark.thorough
@pytest.mark.parametrize("makes", ["lwr", "panda_ur5"])
def test_links_are_drawn_at_their_joint_angles(makes: str) -> None:
    room = build_room("torso", makes)
    left, right = (robot.key for robot in room.robots)
    q = room.start + np.linspace(-0.3, 0.3, len(room.start))
    data = room.model.createData()
    pin.forwardKinematics(room.model, data, q)
    drawn = arms(room, q, ("silver", "orange"))
    looks = ("silver", left), ("orange", right)
    count = [sum(len(parts) for parts in links(*look)) for look in looks]
    assert len(drawn) == sum(count)
    ends = room.robots[0].model.nq, room.model.nq
    for look, last, joint in zip(looks, (count[0], sum(count)), ends, strict=True):
        pose, own = data.oMi[joint], links(*look)[-1]
        for mesh, part in zip(drawn[last - len(own) : last], own, strict=True):
            assert_allclose((mesh.vertices - pose.translation) @ pose.rotation, part.vertices, atol=1e-12)
            assert_allclose(mesh.normals @ pose.rotation, part.normals, atol=1e-12)


def test_a_single_arm_is_on_a_bench() -> None:
    room = build_alone()
    drawn = arms(room, room.start, ("orange",))
    foot = min(mesh.vertices[:, 2].min() for mesh in drawn)
    top = max(mesh.vertices[:, 2].max() for mesh in furniture(room))
    assert foot == pytest.approx(room.rig.bases[0].translation[2], abs=2e-3)
    assert top == pytest.approx(foot, abs=0.02)


@pytest.mark.parametrize("rig", ["torso", "table", "0,0.6,1,0:0.3,-0.6,1,0", "0,0.5,1,0:0,-0.5,1,0"])
def test_arms_are_on_the_furniture_of_the_page(rig: str) -> None:
    room = build_room(rig)
    drawn = furniture(room)
    shown = meshes(furniture_glb(room.rig, coarse=False), MATERIALS)
    assert [len(mesh.vertices) for mesh in drawn] == [len(mesh.vertices) for mesh in shown]
    for base in room.rig.bases:
        near = [np.linalg.norm(mesh.vertices - base.translation, axis=1).min() for mesh in drawn]
        assert min(near) < 0.12, "nothing is below a foot"


def test_the_film_shows_only_robots_without_the_model_of_the_person(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(film, "body_parts", lambda: (_ for _ in ()).throw(MissingPackage("not installed")))
    film.person_parts.cache_clear()
    assert film.posed_person(np.zeros((2, 4))) == []
    film.person_parts.cache_clear()


def test_the_person_bends_an_elbow() -> None:
    if not film.person_parts():
        pytest.skip("the drawing of a person is not installed")
    straight, bent = (
        film.posed_person(np.array([[0.0, 0.0, 0.0, angle], [0.0] * 4])) for angle in (0.0, 1.2)
    )
    moved = [not np.array_equal(a.vertices, b.vertices) for a, b in zip(straight, bent, strict=True)]
    names = [part.name for part, looks in film.person_parts() for _ in looks]
    assert [name for name, flag in zip(names, moved, strict=True) if flag] == ["left_forearm"]
    forearm = names.index("left_forearm")
    # Forward and up: the hand was the lowest point of the straight arm.
    assert bent[forearm].vertices[:, 0].max() > straight[forearm].vertices[:, 0].max() + 0.1
    assert bent[forearm].vertices[:, 2].min() > straight[forearm].vertices[:, 2].min() + 0.1
