"""The camera on a page: it equals the server's, follows the hand, and keeps a turned view."""

import numpy as np
import pytest
from playwright.sync_api import Page

from app.hosting.visitor import Visitor
from app.page.camera_follow import CameraFollow
from app.session.session import Session
from app.stage.camera_view import Pose, framed_now, project
from tests.app.conftest import ask, visitor_of
from tests.app.page.by_hand import drag, run_on
from tests.app.page.shared_page import Shared, SharedPage
from tests.app.posted_call import post_call
from tests.browser import screenshot, settled_view, until, world_to_px
from tests.scenes.helpers import place_of

pytestmark = pytest.mark.thorough

SHARED = SharedPage(900, 640, "autopilot=0&seed=3")


def camera_of(visitor: Visitor) -> CameraFollow:
    return visitor.view.cameras[visitor.client.client_id]


def left_alone(visitor: Visitor) -> bool:
    """True if the visitor has moved the camera, so that it no longer follows."""
    return camera_of(visitor).left_alone


def visitor_at(shared: Shared) -> Visitor:
    return visitor_of(shared.opened)


def position(shared: Shared) -> np.ndarray:
    """Camera position that the page reports (3,) [m]."""
    return np.array(visitor_at(shared).client.camera.position)


def canvas_box(page: Page) -> dict[str, float]:
    return page.evaluate("__viserMutable.canvas.getBoundingClientRect().toJSON()")


def lift_hand(session: Session) -> None:
    """Turn the guided arm's first joint until the camera must follow the hand."""
    joint = session.simulation.guided.joints.start
    post_call(session, lambda: session.simulation.positions.__setitem__(joint, 2.0))


def test_the_server_knows_the_camera_and_the_picture_size_of_the_page(shared: Shared) -> None:
    page, visitor = shared.page, visitor_at(shared)
    settled_view(page)
    ring = ask(shared.session, lambda s: np.array(place_of(s.simulation)))
    box, camera = canvas_box(page), visitor.client.camera
    size, corner = (box["width"], box["height"]), (box["left"], box["top"])

    def camera_is_the_pages() -> bool:
        pose = Pose(np.array(camera.position), np.array(camera.look_at), camera.fov)
        (ours,) = project(pose, size, ring[None])
        return bool(np.abs(np.array(world_to_px(page, ring)) - ours - corner).max() < 1.0)

    def picture_is_the_pages() -> bool:
        picture = camera_of(visitor).picture.free()
        return bool(np.abs(np.subtract((picture.width, picture.height), size)).max() < 2.0)

    until(page, camera_is_the_pages, "the camera that the page has, on the server")
    until(page, picture_is_the_pages, "the size that the picture has, on the server")


def test_the_camera_follows_the_hand(shared: Shared) -> None:
    settled_view(shared.page)
    first = position(shared)
    lift_hand(shared.session)
    until(shared.page, lambda: np.linalg.norm(position(shared) - first) > 0.05, "following")
    assert not left_alone(visitor_at(shared))


def test_a_turned_view_is_kept_until_the_visitor_restores_the_first(shared: Shared) -> None:
    page, session, visitor = shared.page, shared.session, visitor_at(shared)
    settled_view(page)
    first, box = position(shared), canvas_box(page)
    x, y = box["left"] + 0.8 * box["width"], box["top"] + 0.1 * box["height"]
    drag(page, [(x, y), (x - 60, y + 20)])
    until(page, lambda: left_alone(visitor), "being left alone")
    view = settled_view(page)
    # Far enough to move a camera that follows.
    lift_hand(session)
    run_on(page, session, 0.3)
    assert np.allclose(settled_view(page), view, atol=1e-6)
    ask(session, lambda s: s.reset())
    run_on(page, session, 0.3)
    assert np.allclose(settled_view(page), view, atol=1e-6)
    page.keyboard.press("v")
    until(page, lambda: np.linalg.norm(position(shared) - first) < 0.05, "the first view")
    assert not left_alone(visitor)


def test_the_picture_uses_the_space_of_folded_plots(shared: Shared) -> None:
    """Also on a projector's page, which has a taller title bar."""
    page, session, visitor = shared.page, shared.session, visitor_at(shared)
    page.set_viewport_size({"width": 1000, "height": 760})
    ask(session, lambda s: s.change("profile", "projector"))
    plots = page.locator("[data-floating-window]").first

    def as_on_the_page() -> bool:
        picture, box = camera_of(visitor).picture.free(), canvas_box(page)
        covered = box["bottom"] - plots.evaluate("(plots) => plots.getBoundingClientRect().top")
        seen = picture.width, picture.height, picture.open.bottom
        return bool(
            np.abs(np.subtract(seen, (box["width"], box["height"], box["height"] - covered))).max() < 1.5
        )

    def away() -> float:
        return float(np.linalg.norm(position(shared)))

    until(page, as_on_the_page, "the picture's real size")
    settled_view(page)
    points = ask(session, lambda s: framed_now(s.simulation)[0])
    lowest, far = max(world_to_px(page, point)[1] for point in points), away()
    plots.locator("[data-dock-minimize]").click()
    until(page, as_on_the_page, "the folded plots")
    until(page, lambda: away() < far - 0.1, "a nearer camera")
    settled_view(page)
    assert max(world_to_px(page, point)[1] for point in points) > lowest + 50.0
    assert not left_alone(visitor)
    screenshot(page, "folded-plots")
    plots.locator("[data-dock-minimize]").click()
    until(page, as_on_the_page, "the open plots")
    until(page, lambda: abs(away() - far) < 0.05, "the camera of before")
