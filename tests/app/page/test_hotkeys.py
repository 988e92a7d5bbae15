"""Every hotkey does what the table of keys says."""

import numpy as np
import pinocchio as pin
import pytest

from app.bench.headless_client import CAMERA
from app.page.handles.gizmos import NUDGE, SWING, swivel_frame
from app.page.panels.hotkeys import HOTKEYS
from scenes.targets import HandTarget
from tests.app.conftest import Arrive, OpenHouse
from tests.app.page.helpers import SPECS, press


def test_every_hotkey_does_what_the_table_says(house: OpenHouse, arrive: Arrive) -> None:
    opened = house()
    one = arrive(opened)
    session, done = one.session, set[str]()

    def hit(action: str) -> None:
        done.add(action)
        press(one, action)

    hit("pause")
    assert session.paused
    steps = session.simulation.steps
    hit("step")
    one.wait(lambda s: s.simulation.steps == steps + 1)
    assert session.paused
    hit("slower")
    assert session.settings.page.speed == 0.5
    hit("faster")
    assert session.settings.page.speed == 1.0
    hit("law")
    assert session.settings.run.law.law == "unprotected"
    hit("law")
    assert session.settings.run.law.law == "smooth_priority"
    hit("autopilot")
    assert not session.settings.page.autopilot
    hit("autopilot")
    assert session.settings.page.autopilot
    (client,) = opened.server.get_clients().values()
    seen_from = tuple(client.camera.position)
    one.visitor.send(CAMERA | {"position": [0.0, 9.0, 9.0]})
    one.visitor.wait_for(lambda _: client.camera.position[1] == 9.0)
    cameras = one.visitor.received.messages["SetCameraPositionMessage"]
    hit("view")
    one.visitor.wait_for(lambda v: v.received.messages["SetCameraPositionMessage"] == cameras + 1)
    assert np.allclose(client.camera.position, seen_from)

    # Seen from in front of the torso, to the right is +y, away is −x (the view is turned by a little).
    place = one.ask(lambda s: s.simulation.kinematics.hand_pose(s.simulation.guided).translation.copy())
    ways = {"left": (0, -1, 0), "right": (0, 1, 0), "up": (0, 0, 1), "down": (0, 0, -1), "away": (-1, 0, 0), "near": (1, 0, 0)}
    for action, way in ways.items():
        hit(action)
        assert isinstance(session.held, HandTarget) and not session.settings.page.autopilot
        step = session.held.position - place
        assert np.linalg.norm(step) == pytest.approx(NUDGE, rel=1e-6)
        assert step @ np.array(way) > 0.9 * NUDGE, action
        assert way[2] or abs(step[2]) < 1e-9
        place = session.held.position.copy()
    elbow = one.ask(lambda s: s.simulation.kinematics.joint_point(s.simulation.guided.elbow))
    frame, foot = one.ask(lambda s: swivel_frame(s.simulation))
    for action, angle in (("elbow_up", SWING), ("elbow_down", 0.0), ("elbow_down", -SWING)):
        hit(action)
        assert isinstance(session.held, HandTarget) and session.held.elbow is not None
        assert np.allclose(session.held.elbow, foot + pin.exp3(frame[:, 0] * angle) @ (elbow - foot)), action
        assert np.allclose(session.held.position, place), "the hand stays where it was wanted"
    one.run_on(0.0)
    hit("reset")
    assert one.ask(lambda s: (s.simulation.steps, s.simulation.history.count, s.held)) == (0, 0, None)
    assert session.paused
    hit("pause")
    one.run_on(0.1)
    hit("ghost")
    assert session.settings.page.ghost == "frozen" and session.ghost is not None
    hit("ghost")
    assert session.settings.page.ghost == "off" and session.ghost is None
    for scene in SPECS["scene"].choices:
        hit(scene)
        assert session.simulation.settings.scene == scene
        one.run_on(0.05)
    assert done == {hotkey.name for hotkey in HOTKEYS}


def test_the_hotkeys_differ_from_each_other() -> None:
    assert len({(h.key, h.modifier) for h in HOTKEYS}) == len({h.shown for h in HOTKEYS}) == len(HOTKEYS)
    assert len({h.name for h in HOTKEYS}) == len({h.text for h in HOTKEYS}) == len(HOTKEYS)
