"""The orange arm is taken hold of anywhere, and what was pulled is shown, recorded and replayed."""

import numpy as np
import pytest

from app.page.handles.arm_handles import swivel_frame
from app.session.session import Session
from controllers.kinematics import Array
from scenes.targets import HandTarget, LinkTarget
from tests.app.conftest import Arrive, Guest, OpenHouse
from tests.app.page.helpers import press
from tests.app.stage.conftest import change, comes, drawn, place, pull, visible

LINK = "/arms/{}/base" + "".join(f"/j{i}" for i in range(1, 6))
OFFSET = np.array([0.0, 0.05, 0.08])


@pytest.fixture
def guest(house: OpenHouse, arrive: Arrive) -> Guest:
    """A guest whose arms rest, without arrows."""
    return arrive(house(), "autopilot=0")


def point(s: Session) -> Array:
    """The point that is pulled, on the fifth link."""
    return s.simulation.kinematics.data.oMi[s.simulation.guided.joint(5)].act(OFFSET)


@pytest.mark.parametrize("scene", ["hold", "master_slave", "solo"])
def test_a_link_is_pulled(guest: Guest, scene: str) -> None:
    change(guest, scene=scene, speed=2.0)
    arm, link = ("arm" if scene == "solo" else "right"), LINK.format("arm" if scene == "solo" else "right")
    # Only the orange arm, and not its base; no arrows, and no mark before something is pulled.
    links = {f"/arms/{arm}/base" + "".join(f"/j{i}" for i in range(1, joint + 1)) for joint in range(1, 8)}
    guest.visitor.wait_for(lambda v: set(v.mirror.grabbable) == links)
    assert not any(name.startswith("/gizmo") for name in drawn(guest.visitor))
    assert not visible(guest, "/grip/point")
    start = guest.ask(point)
    frame, _ = guest.ask(lambda s: swivel_frame(s.simulation))
    # The way on which the elbow swivels, so that every hand lets it.
    goal = start + 0.05 * (frame[:, 2] - frame[:, 1]) / np.sqrt(2.0)
    pull(guest, link, "start", start, start)
    guest.wait(lambda s: isinstance(s.held, LinkTarget))
    held = guest.session.held
    assert isinstance(held, LinkTarget) and held.joint == 5
    assert np.allclose(held.offset, OFFSET, atol=1e-3)
    pull(guest, link, "update", start, goal)
    comes(guest, lambda s: float(np.linalg.norm(point(s) - goal)), 0.015)
    guest.visitor.wait_for(lambda _: visible(guest, "/grip/point") and visible(guest, "/grip/line"))
    guest.visitor.wait_for(lambda _: np.linalg.norm(place(guest, "/grip/point") - guest.ask(point)) < 2e-3)
    assert np.allclose(place(guest, "/grip/place"), goal)
    # Another one's end means nothing; its own lets go, and the arm stays where it came to.
    pull(guest, link.removesuffix("/j5"), "end", start, goal)
    guest.run_on(0.1)
    assert guest.session.held is not None
    pull(guest, link, "end", start, goal)
    guest.wait(lambda s: s.held is None)
    guest.visitor.wait_for(lambda _: not visible(guest, "/grip/point"))
    there = guest.ask(point)
    guest.run_on(1.0)
    assert np.linalg.norm(guest.ask(point) - there) < (0.05 if scene == "solo" else 0.01)
    # The arrow keys go on from there.
    press(guest, "up")
    guest.wait(lambda s: isinstance(s.held, HandTarget))


def test_odd_pulls_are_not_followed_and_a_change_lets_go(guest: Guest) -> None:
    link, far = LINK.format("right"), np.array([1e7, 0.0, 0.0])
    # An update without a start, and a start that is nowhere.
    pull(guest, link, "update", np.zeros(3), np.ones(3))
    pull(guest, link, "start", np.array([np.nan, 0.0, 0.0]), np.ones(3))
    guest.run_on(0.1)
    assert guest.session.held is None
    start = guest.ask(point)
    pull(guest, link, "start", start, start)
    pull(guest, link, "update", start, far)
    guest.run_on(1.0)
    held = guest.session.held
    assert isinstance(held, LinkTarget) and np.abs(held.position).max() <= 2.6
    assert np.isfinite(guest.ask(lambda s: s.simulation.positions.copy())).all()
    press(guest, "reset")
    assert guest.session.held is None
    pull(guest, link, "start", start, start)
    guest.wait(lambda s: s.held is not None)
    change(guest, guided="left")
    guest.visitor.wait_for(lambda v: v.mirror.grabbable and all(n.startswith("/arms/left/") for n in v.mirror.grabbable))
    assert guest.session.held is None


def test_a_pull_is_replayed_and_the_past_cannot_be_taken_hold_of(guest: Guest) -> None:
    link, start = LINK.format("right"), guest.ask(point)
    goal = start + np.array([0.0, 0.06, 0.08])
    pull(guest, link, "start", start, start)
    pull(guest, link, "update", start, goal)
    comes(guest, lambda s: float(np.linalg.norm(point(s) - goal)), 0.01)
    pull(guest, link, "end", start, goal)
    guest.wait(lambda s: s.held is None)
    guest.visitor.set_value("replay", "Watch")
    guest.wait(lambda s: s.player is not None and s.player.past is not None)
    guest.visitor.wait_for(lambda v: not v.mirror.grabbable)
    guest.visitor.wait_for(lambda _: visible(guest, "/grip/point"))
    assert np.allclose(place(guest, "/grip/place"), goal)
