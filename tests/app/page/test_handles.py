"""The handles of hand and elbow: dragged, turned, put into odd poses, left alone in mid-drag; the sliders of the master's joints."""

import numpy as np
import pytest

from app.settings import Settings
from scenes.targets import HandTarget, JointTarget
from tests.app.conftest import ELBOW, HAND, Arrive, OpenHouse
from tests.app.page.helpers import press, roundtrip
from tests.app.page.test_every_control import INF, NAN
from tests.tools.monkey.visitor import assert_sound


@pytest.mark.parametrize("name", [HAND, ELBOW])
def test_odd_poses_of_a_handle(house: OpenHouse, arrive: Arrive, name: str) -> None:
    opened = house()
    one, witness = arrive(opened), arrive(opened)
    one.visitor.move_gizmo(name, phase="start")
    one.wait(lambda s: not s.settings.page.autopilot)
    place, turn = (0.3, 0.0, 1.0), (0.5, 0.5, 0.5, 0.5)
    places = ((NAN, 0.0, 1.0), (0.3, INF, 1.0), (0.3, 0.0, -INF), (1e308, 0.0, 1.0), (1e8, -1e8, 1e8))
    turns = ((0.0, 0.0, 0.0, 0.0), (NAN, 0.0, 0.0, 1.0), (1e6, 0.0, 0.0, 1.0), (0.9, 0.9, 0.9, 0.9))
    both = ((-1e8, 1e8, -1e8), (0.9, 0.9, 0.9, 0.9)), ((0.0, 0.0, 0.92), (-1.0, 0.0, 0.0, 0.0))
    for position, wxyz in (*((one, turn) for one in places), *((place, one) for one in turns), *both):
        one.visitor.move_gizmo(name, position, wxyz)
        roundtrip(one)
        one.run_on(0.1)
        held = one.ask(lambda s: s.held)
        assert isinstance(held, HandTarget) and np.isfinite(held.position).all() and np.abs(held.position).max() <= 2.5
        assert held.rotation is not None and np.allclose(held.rotation @ held.rotation.T, np.eye(3))
    one.ask(assert_sound)
    assert one.session.held is not None
    one.visitor.move_gizmo(name, phase="end")
    one.wait(lambda s: s.held is None)
    witness.run_on(0.05)
    assert witness.session.settings == Settings() and witness.session.held is None


def test_a_reset_in_mid_drag_lets_go(house: OpenHouse, arrive: Arrive) -> None:
    one = arrive(house(), "autopilot=0")
    one.visitor.move_gizmo(HAND, phase="start")
    one.visitor.move_gizmo(HAND, (0.4, -0.1, 1.1))
    one.run_on(0.3)
    press(one, "reset")
    assert one.ask(lambda s: s.held is None)
    home = one.ask(lambda s: s.simulation.kinematics.hand_pose(s.simulation.guided).translation.copy())
    one.visitor.wait_for(lambda v: np.linalg.norm(np.array(v.mirror.nodes[HAND]["position"]) - home) < 1e-3)
    one.visitor.move_gizmo(HAND, (0.4, -0.1, 1.1))
    one.wait(lambda s: s.held is not None)


def test_a_slider_leads_the_master_and_the_slave_follows(house: OpenHouse, arrive: Arrive) -> None:
    guest = arrive(house(), "scene=master_slave&autopilot=0")
    session, visitor = guest.session, guest.visitor
    visitor.wait_for(lambda v: any(p.get("label") == "elbow" for p in v.mirror.gui.values()))
    master, slave = session.simulation.guided.joints, session.simulation.avoiding.joints
    before = session.simulation.positions.copy()
    wanted = float(np.degrees(before[master][3])) + 8.0
    for value in (float("nan"), 1e9, wanted):
        visitor.set_value("elbow", value)
    visitor.wait_for(lambda _: isinstance(session.held, JointTarget))
    visitor.wait_for(lambda _: abs(np.degrees(session.simulation.positions[master][3]) - wanted) < 0.5, 15.0)
    after = session.simulation.positions
    assert np.abs(np.delete(after[master] - before[master], 3)).max() < 0.02
    assert abs(after[slave][3] - before[slave][3]) > np.radians(4.0)
