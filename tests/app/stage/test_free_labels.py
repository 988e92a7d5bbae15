"""Labels of the closest pair are never cut at the edge or covered by plots, sheet and card."""

import numpy as np
import pytest

from app.page.camera_follow import kept_free
from app.page.picture_size import FreePicture
from app.stage.camera_view import PointView, Pose, axes, project, view_of
from app.stage.contact_view import label_size
from app.web.headless_client import CAMERA
from controllers.kinematics import Array
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from tests.app.conftest import Arrive, OpenHouse, visitor_of
from tests.app.page.test_camera_follow import Watched, pictures
from tests.app.stage.conftest import drawn, settle, visible

EXACTLY = 0.01
"""Tolerance [CSS px]."""


def free(picture: FreePicture, at: Array, size: tuple[float, float]) -> bool:
    """True if a label is inside one of the picture's free parts. `at`: middle of its lower edge."""
    (x, y), (width, height), off = at.tolist(), size, EXACTLY
    corners = (x - width / 2.0 + off, y - height + off), (x + width / 2.0 - off, y - off)
    return any(all(part.contains(*corner) for corner in corners) for part in picture.free)


@pytest.mark.parametrize("lesson", [False, True])
def test_a_label_that_would_be_cut_moves_into_the_free_part(lesson: bool) -> None:
    simulation, label = Simulation(RunSettings()), label_size("150 mm of overlap", 1.0)
    rng, moved = np.random.default_rng(1), 0
    for picture in pictures(lesson):
        watched = Watched(picture, lambda: view_of(simulation), lambda: np.zeros((0, 3)))
        follow, camera = watched.follow, watched.camera
        follow.first_view(simulation, 0.0)
        pose, size = Pose(camera.position, camera.look_at, camera.fov), (picture.width, picture.height)
        middle = np.array(view_of(simulation).centre)
        for place in middle + rng.uniform(-1.5, 1.5, (200, 3)):
            assert PointView(pose).pixel(place, *size)[:2] == pytest.approx(
                project(pose, size, place[None])[0], abs=1e-6, nan_ok=True
            )
            kept, was_free = follow.keep_free(place, label)
            before, after = project(pose, size, np.array([place, kept]))
            if not np.isfinite(before).all():
                continue
            assert free(picture, after, label), (place, after)
            assert not was_free or (kept == place).all()
            assert free(picture, before, label) or not was_free
            # Its depth stays the same, and so does its size.
            assert abs((kept - place) @ axes(pose.eye - pose.look_at)[2]) < 1e-9
            moved += not was_free
    assert moved > 100


def test_a_place_outside_any_picture_is_not_moved() -> None:
    picture, label = next(pictures(False)), (100.0, 18.0)
    eye, behind = np.array([2.0, 0.0, 1.0]), np.array([4.0, 5.0, 1.0])
    kept, was_free = kept_free(PointView(Pose(eye, np.array([0.0, 0.0, 1.0]), 1.0)), picture, behind, label)
    assert was_free and (kept == behind).all(), "moved although behind the camera"
    simulation = Simulation(RunSettings())
    watched = Watched(picture, lambda: view_of(simulation), lambda: np.zeros((0, 3)))
    place = np.array([0.0, 9.0, 0.0])
    assert watched.follow.keep_free(place, label)[1], "moved without a known camera"
    watched.follow.first_view(simulation, 0.0)
    assert not watched.follow.keep_free(place, label)[1]
    watched.camera.position, watched.camera.look_at, watched.follow.left_alone = (
        np.array([0.0, 0.0, 3.0]),
        np.zeros(3),
        True,
    )
    assert watched.follow.keep_free(place, label)[1], "moved in a view straight down"


def test_labels_stay_in_the_picture_after_a_turn_of_the_camera(house: OpenHouse, arrive: Arrive) -> None:
    """The camera looks past the arms: the closest pair is at an edge of the picture or outside it."""
    opened = house()
    guest = arrive(opened, "autopilot=0")
    follow = visitor_of(opened).view.cameras[visitor_of(opened).client.client_id]
    rims = [name for name in drawn(guest.visitor) if "rim_around" in name]
    seen: set[bool] = set()
    for aside in (-2.5, -0.9, 0.0, 0.9, 2.5):
        eye, look_at = np.array([2.2, aside, 1.3]), np.array([0.2, aside, 1.0])
        guest.visitor.send({**CAMERA, "position": eye.tolist(), "look_at": look_at.tolist()})
        guest.visitor.wait_for(
            lambda _, aside=aside: abs(float(follow._camera.look_at[1]) - aside) < 1e-6 and follow.left_alone
        )
        settle(guest)
        pose, picture = Pose(eye, look_at, CAMERA["fov"]), follow.picture.free()
        node = guest.visitor.mirror.nodes["/closest/distance"]
        at = project(pose, (picture.width, picture.height), np.array([node["position"]]))[0]
        assert free(picture, at, label_size(node["text"], 1.0)), (aside, at)
        seen.add(any(visible(guest, name) for name in rims))
    assert seen == {True, False}, "the label d_m is never hidden, or always"
