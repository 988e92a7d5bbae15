"""Closest points, their label, ring and hands stay in the free part of the picture.

Checked at three sizes, during a run and at the decisive moment after it.
"""

from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from app.page.camera_follow import CameraFollow
from app.page.picture_size import FreePicture, PictureSize, free_picture
from app.session.input_source import InputSource
from app.session.replay_player import Mark
from app.stage.camera_view import AHEAD, Pose, contact_points, framed_now, project, view_of
from app.theme import DOCK_WIDTH
from scenes.history import COLUMN
from scenes.rigs import Camera
from scenes.roles import TargetSource
from scenes.settings import RunSettings
from scenes.simulation import Simulation

pytestmark = pytest.mark.slow

SIZES = ((1440, 900), (1024, 768), (390, 844))
TITLE_BAR, RAIL = 47.0, 40.0
LOOK = 0.1
"""Time between two checks of the picture [s]."""
SAID = (
    PictureSize(1440.0, 756.0, 853.0, 240.0, 344.0, 228.0),
    PictureSize(1024.0, 680.0, 721.0, 240.0, 338.0, 228.0),
    PictureSize(390.0, 390.0, 802.0, 0.0, 384.0, 132.0),
)
"""Reported sizes of a lesson's page at `SIZES`, with the card at its largest height."""


def pictures(with_lesson: bool) -> Iterator[FreePicture]:
    """Free part of a window of each size, with or without the lessons' panel."""
    if with_lesson:
        yield from (
            free_picture((said.window, said.height), said.width, "desk", False, said.covered, said[4:])
            for said in SAID
        )
        return
    for width, height in SIZES:
        yield free_picture((width, height - TITLE_BAR), width - (DOCK_WIDTH if width > 576 else 0.0), "desk")


class Watched:
    """Camera without a browser that follows a run."""

    def __init__(self, picture: FreePicture, view: Callable[[], Camera], way: Callable[[], Any]) -> None:
        self.picture, self.moves = picture, 0
        zero = np.zeros(3)
        self.camera: Any = SimpleNamespace(position=zero, look_at=zero, up_direction=zero, fov=1.0)
        report: Any = SimpleNamespace(free=lambda: picture, take_change=lambda: False)
        self.follow = CameraFollow(self.camera, self.aim, view, way, report)

    def aim(self, pose: Pose) -> None:
        self.camera.position, self.camera.look_at, self.camera.fov = pose.eye, pose.look_at, pose.fov

    def seen(self, points: Any) -> Any:
        """Projected points (k, 2) [px] of points (k, 3)."""
        pose = Pose(self.camera.position, self.camera.look_at, self.camera.fov)
        return project(pose, (self.picture.width, self.picture.height), points)

    def outside(self, points: Any) -> list[tuple[int, int]]:
        """Projected points outside the free part [px]."""
        return [(round(x), round(y)) for x, y in self.seen(points) if not self.picture.contains(x, y)]


def seen_points(simulation: Simulation) -> Any:
    """Points that must be visible, including the label between the closest points."""
    points, _ = framed_now(simulation)
    return np.vstack([points, points[:2].mean(axis=0)]) if len(contact_points(simulation)) else points


def watch(
    simulation: Simulation,
    source: TargetSource,
    seconds: float,
    view: Callable[[], Camera],
    lesson: bool,
    moment: Callable[[], Mark | None] = lambda: None,
) -> list[str]:
    """Faults of a run at any size: points outside the free part, or more than three camera moves.

    Args:
        moment: returns the moment that is shown after the run.
    """
    given = InputSource()
    given.set_source(source)
    watched = [
        Watched(picture, view, lambda: given.way(simulation, True, AHEAD)) for picture in pictures(lesson)
    ]
    for one in watched:
        one.follow.first_view(simulation, 0.0)
    wrong: list[str] = []
    gliding = [False] * len(watched)
    for _ in range(round(seconds / LOOK)):
        for _ in range(round(LOOK / simulation.settings.dt)):
            simulation.step(given.target(simulation, True))
        points = seen_points(simulation)
        for i, one in enumerate(watched):
            before = one.camera.position
            one.follow.follow(simulation, simulation.time)
            moves = bool(np.any(before != one.camera.position))
            one.moves += moves and not gliding[i]
            gliding[i] = moves
            assert not one.follow.left_alone
            outside = one.outside(points)
            if outside:
                wrong.append(
                    f"{simulation.time:.1f} s, {one.picture.width:g}×{one.picture.height:g}: {outside}"
                )
    wrong += [
        f"{one.picture.width:g}×{one.picture.height:g}: {one.moves} moves" for one in watched if one.moves > 3
    ]
    if (mark := moment()) is not None:
        table, end = simulation.history.table(), simulation.time
        row = int(np.abs(table[:, COLUMN["t"]] + simulation.settings.dt - mark.time).argmin())
        simulation.positions[:] = simulation.history.positions(table)[row]
        simulation.kinematics.update(simulation.positions)
        for one in watched:
            for look in range(round(3.0 / LOOK)):
                one.follow.follow(simulation, end + LOOK * look)
            outside = one.outside(seen_points(simulation))
            wrong += (
                [f"the moment, {one.picture.width:g}×{one.picture.height:g}: {outside}"] if outside else []
            )
    return wrong


@pytest.mark.parametrize("rig", ["torso", "table"])
@pytest.mark.parametrize("scene", ["solo", "ball", "hold", "master_slave", "imitation"])
def test_everything_stays_visible_in_every_scene(scene: str, rig: str) -> None:
    simulation = Simulation(RunSettings(scene=scene, rig=rig, dt=0.004))  # type: ignore[arg-type]
    source = simulation.source()
    simulation.reset()
    assert watch(simulation, source, 12.0, lambda: view_of(simulation), False) == []


def test_space_under_the_card_and_the_panels_is_not_free() -> None:
    desk = free_picture((1440.0, 853.0), 1096.0, "desk")
    assert not desk.contains(100.0, 100.0) and desk.contains(400.0, 100.0) and desk.contains(100.0, 260.0)
    assert not desk.contains(400.0, 700.0) and not desk.contains(-1.0, 300.0)
    # On a projector the card is larger; on a phone it is as wide as the picture.
    assert not free_picture((1440.0, 853.0), 1096.0, "projector").contains(400.0, 100.0)
    phone = free_picture((390.0, 797.0), 390.0, "desk")
    assert (
        not phone.contains(380.0, 100.0) and phone.contains(380.0, 130.0) and not phone.contains(200.0, 430.0)
    )


def test_late_reports_of_the_servers_moves_do_not_count_as_the_visitors() -> None:
    simulation = Simulation(RunSettings())
    picture = next(pictures(False))
    one = Watched(picture, lambda: view_of(simulation), lambda: np.zeros((0, 3)))
    one.camera.position, one.camera.look_at = np.array([3.0, 3.0, 3.0]), np.zeros(3)
    before = one.camera.position, one.camera.look_at
    one.follow.first_view(simulation, 0.0)
    after = one.camera.position, one.camera.look_at
    # The browser reports the old view (late), then each half-updated view, then the new one.
    halves = (after[0], before[1]), (before[0], after[1])
    for now, (place, aim) in enumerate((before, *halves, after), 30):
        one.camera.position, one.camera.look_at = place, aim
        one.follow.follow(simulation, float(now))
        assert not one.follow.left_alone
    one.camera.position = after[0] + np.array([0.0, 0.05, 0.0])
    one.follow.follow(simulation, 40.0)
    assert one.follow.left_alone
    place = one.camera.position
    simulation.positions[simulation.guided.joints.start] = 2.0
    simulation.step(None)
    one.follow.follow(simulation, 50.0)
    assert one.camera.position is place, "the camera moved although the visitor chose the view"
    one.follow.first_view(simulation, 60.0)
    assert not one.follow.left_alone and one.outside(framed_now(simulation)[0]) == []


def test_late_reports_of_a_hidden_tab_do_not_count_as_the_visitors() -> None:
    simulation = Simulation(RunSettings())
    picture = next(pictures(False))
    one = Watched(picture, lambda: view_of(simulation), lambda: np.zeros((0, 3)))
    one.follow.first_view(simulation, 0.0)
    before = newest = one.camera.position, one.camera.look_at
    for turn in range(1200):
        simulation.positions[simulation.guided.joints.start] = 1e-3 * turn
        one.follow.first_view(simulation, 1.0 + turn)
        newest = one.camera.position, one.camera.look_at
        one.camera.position, one.camera.look_at = before
    for now, (one.camera.position, one.camera.look_at) in enumerate((before, newest), 2000):
        one.follow.follow(simulation, float(now))
        assert not one.follow.left_alone
    one.camera.look_at = newest[1] + 0.01
    one.follow.follow(simulation, 3000.0)
    assert one.follow.left_alone
