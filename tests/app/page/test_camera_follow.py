"""Closest points, ring and hands stay in the free part of the picture, in every scene and every step of a lesson, at three sizes."""

from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from app.hosting.private_host import PrivateHost
from app.lessons.lesson import Step
from app.lessons.loading import load_lessons
from app.lessons.reference_runs import begin, person_of
from app.page.camera_follow import CameraFollow
from app.page.free_picture import FreePicture, free_picture
from app.page.lessons.lesson_camera import lesson_view
from app.page.lessons.lesson_panel import NARROW_WIDTH, WIDTH
from app.session.input_source import InputSource
from app.stage.camera_fit import Pose, project
from app.stage.framed_points import AHEAD, framed_now
from app.stage.stage_camera import view_of
from app.theme import DOCK_WIDTH
from scenes.rigs import Camera
from scenes.roles import TargetSource
from scenes.settings import RunSettings
from scenes.simulation import Simulation
from tests.app.conftest import OpenHouse, ask
from tests.app.page.by_hand import run_on, visit
from tests.browser import PageAt, screenshot, settled_view, until, world_to_px

SIZES = ((1440, 900), (1024, 768), (390, 844))
TITLE_BAR, RAIL = 47.0, 40.0
LOOK = 0.1
"""Between two looks at the picture [s]."""
LESSONS = load_lessons().lessons


def pictures(with_lesson: bool) -> Iterator[FreePicture]:
    """The free parts of a window of each size, with the panel of the lessons or without."""
    for width, height in SIZES:
        docked = 0.0
        if width > 576:
            docked = DOCK_WIDTH + (0.0 if not with_lesson else WIDTH if width > 1180 else NARROW_WIDTH)
        yield free_picture((width, height - TITLE_BAR), width - docked, "desk")


class Watched:
    """A camera without a browser, which follows a run."""

    def __init__(self, picture: FreePicture, view: Callable[[], Camera], way: Callable[[], Any]) -> None:
        self.picture, self.moves = picture, 0
        zero = np.zeros(3)
        self.camera: Any = SimpleNamespace(position=zero, look_at=zero, up_direction=zero, fov=1.0)
        self.follow = CameraFollow(self.camera, view, way, lambda: picture)

    def outside(self, points: Any) -> list[tuple[int, int]]:
        """Where points are seen that are not in the free part [px]."""
        pose = Pose(self.camera.position, self.camera.look_at, self.camera.fov)
        seen = project(pose, (self.picture.width, self.picture.height), points)
        return [(round(x), round(y)) for x, y in seen if not self.picture.contains(x, y)]


def watch(simulation: Simulation, source: TargetSource, seconds: float, view: Callable[[], Camera], lesson: bool) -> list[str]:
    """What was seen outside the free part in a run, at any size; a camera that moves more than three times is as bad."""
    given = InputSource()
    given.set_source(source)
    watched = [Watched(picture, view, lambda: given.way(simulation, True, AHEAD)) for picture in pictures(lesson)]
    for one in watched:
        one.follow.first_view(simulation, 0.0)
    wrong: list[str] = []
    gliding = [False] * len(watched)
    for _ in range(round(seconds / LOOK)):
        for _ in range(round(LOOK / simulation.settings.dt)):
            simulation.step(given.target(simulation, True))
        points, _ = framed_now(simulation)
        for i, one in enumerate(watched):
            before = one.camera.position
            one.follow.follow(simulation, simulation.time)
            moves = bool(np.any(before != one.camera.position))
            one.moves += moves and not gliding[i]
            gliding[i] = moves
            assert not one.follow.left_alone
            outside = one.outside(points)
            if outside:
                wrong.append(f"{simulation.time:.1f} s, {one.picture.width:g}×{one.picture.height:g}: {outside}")
    wrong += [f"{one.picture.width:g}×{one.picture.height:g}: {one.moves} moves" for one in watched if one.moves > 3]
    return wrong


@pytest.mark.parametrize("rig", ["torso", "table"])
@pytest.mark.parametrize("scene", ["solo", "ball", "hold", "master_slave", "imitation"])
def test_every_scene(scene: str, rig: str) -> None:
    simulation = Simulation(RunSettings(scene=scene, rig=rig, dt=0.004))  # type: ignore[arg-type]
    source = simulation.source()
    simulation.reset()
    assert watch(simulation, source, 12.0, lambda: view_of(simulation), False) == []


@pytest.mark.parametrize(
    "step", [pytest.param(step, id=f"{lesson.number}-{step.id}") for lesson in LESSONS for step in lesson.steps]
)
def test_every_step_of_a_lesson(step: Step) -> None:
    simulation = Simulation(step.setup.run)
    begin(simulation, step.setup)
    source = simulation.source() if step.yours else person_of(simulation, step.setup)
    view = lambda: lesson_view(simulation, step.camera)  # noqa: E731
    assert watch(simulation, source, min(step.setup.seconds, 12.0), view, True) == []


def test_our_projection_is_the_pages_and_a_visitor_who_turns_the_view_keeps_it(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(900, 640)
    opened = house()
    session = visit(page, opened, "autopilot=0&seed=3")
    settled_view(page)
    ring = ask(session, lambda s: np.array(s.simulation.place))
    host = opened.host
    assert isinstance(host, PrivateHost)
    (visitor,) = host.visitors.values()
    camera = visitor.client.camera
    box = page.evaluate(
        "(() => { const box = __viserMutable.canvas.getBoundingClientRect(); return [box.left, box.top, box.width, box.height]; })()"
    )
    pose = Pose(np.array(camera.position), np.array(camera.look_at), camera.fov)
    (ours,) = project(pose, (box[2], box[3]), ring[None])
    assert np.abs(np.array(world_to_px(page, ring)) - ours - box[:2]).max() < 1.0
    picture = visitor.view.picture(visitor.client)
    assert abs(picture.width - box[2]) < 2.0 and abs(picture.height - box[3]) < 2.0

    # The camera goes where the hand goes.
    def sent() -> Any:
        return np.array(camera.position)

    first = sent()
    session.post(lambda: session.simulation.positions.__setitem__(session.simulation.guided.joints.start, 2.0))
    until(page, lambda: np.linalg.norm(sent() - first) > 0.05, "following")
    assert not visitor.view.left_alone(visitor.client)
    settled_view(page)
    # The visitor turns the view, and keeps it.
    x, y = box[0] + 0.8 * box[2], box[1] + 0.1 * box[3]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 60, y + 20, steps=4)
    page.mouse.up()
    until(page, lambda: visitor.view.left_alone(visitor.client), "being left alone")
    view = settled_view(page)
    ask(session, lambda s: s.reset())
    run_on(page, session, 0.3)
    assert np.allclose(settled_view(page), view, atol=1e-6)
    page.keyboard.press("v")
    until(page, lambda: np.linalg.norm(sent() - first) < 0.05, "the first view")
    assert not visitor.view.left_alone(visitor.client)


def test_what_the_card_and_the_panels_cover_is_not_free() -> None:
    desk = free_picture((1440.0, 853.0), 1096.0, "desk")
    assert not desk.contains(100.0, 100.0) and desk.contains(400.0, 100.0) and desk.contains(100.0, 260.0)
    assert not desk.contains(400.0, 700.0) and not desk.contains(-1.0, 300.0)
    # On a projector the card is larger; on a phone it is as wide as the picture.
    assert not free_picture((1440.0, 853.0), 1096.0, "projector").contains(400.0, 100.0)
    phone = free_picture((390.0, 797.0), 390.0, "desk")
    assert not phone.contains(380.0, 100.0) and phone.contains(380.0, 130.0) and not phone.contains(200.0, 430.0)


def test_late_news_of_our_own_moves_is_no_move_of_the_visitor() -> None:
    simulation = Simulation(RunSettings())
    picture = next(pictures(False))
    one = Watched(picture, lambda: view_of(simulation), lambda: np.zeros((0, 3)))
    one.camera.position, one.camera.look_at = np.array([3.0, 3.0, 3.0]), np.zeros(3)
    before = one.camera.position, one.camera.look_at
    one.follow.first_view(simulation, 0.0)
    after = one.camera.position, one.camera.look_at
    # The browser says where it was before; then half of it; then where it is.
    for now, (place, aim) in enumerate((before, (after[0], before[1]), after), 1):
        one.camera.position, one.camera.look_at = place, aim
        one.follow.follow(simulation, float(now))
        assert not one.follow.left_alone
    one.camera.position = after[0] + np.array([0.0, 0.05, 0.0])
    one.follow.follow(simulation, 4.0)
    assert one.follow.left_alone
    place = one.camera.position
    simulation.positions[simulation.guided.joints.start] = 2.0
    simulation.step(None)
    one.follow.follow(simulation, 5.0)
    assert one.camera.position is place, "a view that the visitor chose is moved"
    one.follow.first_view(simulation, 6.0)
    assert not one.follow.left_alone and one.outside(framed_now(simulation)[0]) == []


def test_the_picture_uses_the_place_of_folded_plots(house: OpenHouse, page_at: PageAt) -> None:
    page = page_at(1000, 760)
    opened = house()
    session = visit(page, opened, "autopilot=0&profile=projector")
    assert isinstance(opened.host, PrivateHost)
    (visitor,) = opened.host.visitors.values()
    plots = page.locator("[data-floating-window]").first

    def as_on_the_page() -> bool:
        picture = visitor.view.picture(visitor.client)
        box = page.evaluate("__viserMutable.canvas.getBoundingClientRect().toJSON()")
        covered = box["bottom"] - plots.evaluate("(plots) => plots.getBoundingClientRect().top")
        seen, real = (picture.width, picture.height, picture.open.bottom), (box["width"], box["height"], box["height"] - covered)
        return bool(np.abs(np.subtract(seen, real)).max() < 1.5)

    # The title bar of a projector's page is taller.
    until(page, as_on_the_page, "the picture's real size")
    settled_view(page)
    points = ask(session, lambda s: framed_now(s.simulation)[0])
    before = max(world_to_px(page, point)[1] for point in points)
    away = np.linalg.norm(visitor.client.camera.position)
    plots.locator("[data-dock-minimize]").click()
    until(page, as_on_the_page, "the folded plots")
    until(page, lambda: np.linalg.norm(visitor.client.camera.position) < away - 0.1, "a nearer camera")
    settled_view(page)
    assert max(world_to_px(page, point)[1] for point in points) > before + 50.0
    assert not visitor.view.left_alone(visitor.client)
    screenshot(page, "folded-plots")
    plots.locator("[data-dock-minimize]").click()
    until(page, as_on_the_page, "the open plots")
    until(page, lambda: abs(np.linalg.norm(visitor.client.camera.position) - away) < 0.05, "the camera of before")
