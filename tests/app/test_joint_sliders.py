"""The master's joints as sliders, operated as a browser would."""

import numpy as np

from app.settings import Settings
from scenes.targets import JointTarget
from tests.app.conftest import Arrive, OpenHouse


def test_a_slider_leads_the_master_and_the_slave_follows(house: OpenHouse, arrive: Arrive) -> None:
    guest = arrive(house(Settings()), "scene=master_slave&autopilot=0")
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
