"""A guest with arms at rest at first, and readers of the guest's 3-D view."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from app.session.session import Session
from controllers.kinematics import Array
from scenes.experiments import EXPERIMENTS
from tests.app.conftest import Arrive, Guest, OpenHouse
from tests.blocking_client import BlockingClient

SCENES = tuple(EXPERIMENTS)
BALL_ARROWS = "/gizmo/ball"
TURN = (1.0, 0.0, 0.0, 0.0)


@pytest.fixture
def one(house: OpenHouse, arrive: Arrive) -> Iterator[Guest]:
    """A guest with arms at rest at first."""
    yield arrive(house(), "autopilot=0&gizmo=1")


def change(guest: Guest, **settings: Any) -> None:
    """Change settings, and wait until the page shows them. A paused run may send only one frame."""
    guest.ask(lambda s: [s.change(key, value) for key, value in settings.items()])
    settle(guest)


def settle(guest: Guest) -> None:
    """Wait until the page shows the present state; the background is the last message."""
    for theme in ("dark", "light"):
        before = guest.visitor.received.messages["BackgroundImageMessage"]
        guest.ask(lambda s, theme=theme: s.change("theme", theme))
        guest.visitor.wait_for(
            lambda v, before=before: v.received.messages["BackgroundImageMessage"] > before
        )


def drawn(visitor: BlockingClient) -> set[str]:
    """Names of all nodes that draw something."""
    return {
        name
        for name, node in list(visitor.mirror.nodes.items())
        if node.get("type") not in (None, "FrameMessage")
    }


def place(guest: Guest, node: str) -> Array:
    """Position of a node in its parent; nan while it does not exist."""
    shown = guest.visitor.mirror.nodes.get(node)
    return np.full(3, np.nan) if shown is None else np.array(shown["position"], float)


def visible(guest: Guest, node: str) -> bool:
    shown = guest.visitor.mirror.nodes.get(node)
    return shown is not None and bool(shown.get("visible", True))


def pause_when(guest: Guest, true: Callable[[Session], object]) -> None:
    """Pause the run in the first frame for which `true` holds."""

    def look(s: Session) -> bool:
        if not s.paused and true(s):
            s.control.toggle_pause()
        return s.paused

    guest.wait(lambda _: guest.ask(look))


def comes(guest: Guest, distance: Any, limit: float) -> None:
    for _ in range(200):
        if guest.ask(distance) < limit:
            return
        guest.run_on(0.1)
    pytest.fail(f"it is still {guest.ask(distance):.4f} away")


def hand(s: Session) -> Array:
    return s.simulation.kinematics.hand_pose(s.simulation.guided).translation.copy()


def home(s: Session) -> Array:
    assert s.simulation.keeper is not None
    return s.simulation.keeper.home.copy()


def ball(s: Session) -> Array:
    assert s.simulation.room.ball is not None
    return s.simulation.positions[s.simulation.room.ball].copy()


def pull(guest: Guest, node: str, phase: str, taken: Array, to: Array) -> None:
    """One step of a node's drag across the view."""
    guest.visitor.wait_for(lambda visitor: node in visitor.mirror.grabbable)
    guest.visitor.pull(node, phase, taken.tolist(), to.tolist())


def drag(guest: Guest, node: str, to: Array, turn: Sequence[float] = TURN) -> None:
    w, x, y, z = turn
    guest.visitor.move_gizmo(node, phase="start")
    guest.visitor.move_gizmo(node, tuple(to.tolist()), (w, x, y, z))


def drawn_pose(guest: Guest, name: str) -> pin.SE3:
    pose, path = pin.SE3.Identity(), ""
    for part in name.strip("/").split("/"):
        path += f"/{part}"
        node = guest.visitor.mirror.nodes[path]
        w, x, y, z = node["wxyz"]
        pose = pose * pin.SE3(
            pin.Quaternion(w, x, y, z).toRotationMatrix(), np.array(node["position"], float)
        )
    return pose
