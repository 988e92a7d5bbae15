"""The camera on a page: it is the one that the server reckons with, follows the hand, and is left to a visitor who turns it."""

from typing import Any

import numpy as np
import pytest

from app.hosting.visitor import Visitor
from app.page.camera_follow import CameraFollow
from app.stage.camera_view import Pose, framed_now, project
from tests.app.conftest import OpenHouse, ask, visitor_of
from tests.app.page.by_hand import drag, run_on, visit
from tests.app.posted_call import post_call
from tests.browser import PageAt, screenshot, settled_view, until, world_to_px
from tests.scenes.helpers import place_of


def camera_of(visitor: Visitor) -> CameraFollow:
    return visitor.view.cameras[visitor.client.client_id]


def left_alone(visitor: Visitor) -> bool:
    """Whether the visitor has moved the camera, so that it does not follow."""
    return camera_of(visitor).left_alone


@pytest.mark.thorough
def test_our_projection_is_the_pages_a_view_that_is_turned_is_kept_and_folded_plots_leave_their_place(
    house: OpenHouse, page_at: PageAt
) -> None:
    page = page_at(900, 640)
    opened = house()
    session = visit(page, opened, "autopilot=0&seed=3")
    settled_view(page)
    ring = ask(session, lambda s: np.array(place_of(s.simulation)))
    visitor = visitor_of(opened)
    camera = visitor.client.camera
    box = page.evaluate(
        "(() => { const box = __viserMutable.canvas.getBoundingClientRect(); return [box.left, box.top, box.width, box.height]; })()"
    )

    def ours_is_the_pages() -> bool:
        pose = Pose(np.array(camera.position), np.array(camera.look_at), camera.fov)
        (ours,) = project(pose, (box[2], box[3]), ring[None])
        return bool(np.abs(np.array(world_to_px(page, ring)) - ours - box[:2]).max() < 1.0)

    def picture_is_the_pages() -> bool:
        picture = camera_of(visitor).picture.free()
        return abs(picture.width - box[2]) < 2.0 and abs(picture.height - box[3]) < 2.0

    until(page, ours_is_the_pages, "the camera that the page has, on the server")
    until(page, picture_is_the_pages, "the size that the picture has, on the server")

    # The camera goes where the hand goes.
    def sent() -> Any:
        return np.array(camera.position)

    first = sent()
    post_call(
        session, lambda: session.simulation.positions.__setitem__(session.simulation.guided.joints.start, 2.0)
    )
    until(page, lambda: np.linalg.norm(sent() - first) > 0.05, "following")
    assert not left_alone(visitor)
    settled_view(page)
    # The visitor turns the view, and keeps it.
    x, y = box[0] + 0.8 * box[2], box[1] + 0.1 * box[3]
    drag(page, [(x, y), (x - 60, y + 20)])
    until(page, lambda: left_alone(visitor), "being left alone")
    view = settled_view(page)
    ask(session, lambda s: s.reset())
    run_on(page, session, 0.3)
    assert np.allclose(settled_view(page), view, atol=1e-6)
    page.keyboard.press("v")
    until(page, lambda: np.linalg.norm(sent() - first) < 0.05, "the first view")
    assert not left_alone(visitor)

    # The picture uses the place of folded plots; the title bar of a projector's page is taller.
    page.set_viewport_size({"width": 1000, "height": 760})
    ask(session, lambda s: s.change("profile", "projector"))
    plots = page.locator("[data-floating-window]").first

    def as_on_the_page() -> bool:
        picture = camera_of(visitor).picture.free()
        box = page.evaluate("__viserMutable.canvas.getBoundingClientRect().toJSON()")
        covered = box["bottom"] - plots.evaluate("(plots) => plots.getBoundingClientRect().top")
        seen, real = (
            (picture.width, picture.height, picture.open.bottom),
            (box["width"], box["height"], box["height"] - covered),
        )
        return bool(np.abs(np.subtract(seen, real)).max() < 1.5)

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
    assert not left_alone(visitor)
    screenshot(page, "folded-plots")
    plots.locator("[data-dock-minimize]").click()
    until(page, as_on_the_page, "the open plots")
    until(
        page,
        lambda: abs(np.linalg.norm(visitor.client.camera.position) - away) < 0.05,
        "the camera of before",
    )
