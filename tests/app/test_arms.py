"""Drawn arms: nested nodes stand where the links are, and only what moves is sent."""

from typing import get_args

import numpy as np
import pinocchio as pin
import pytest

from app.stage.arms import ArmView
from scenes.robots import RobotName, robot
from tests.app.conftest import Arrive, OpenHouse
from tests.app.stage.conftest import drawn_pose

BASE = pin.SE3(pin.exp3(np.array([0.4, -0.9, 0.3])), np.array([0.1, -0.2, 0.9]))


@pytest.mark.parametrize("name", get_args(RobotName))
def test_nodes_stand_where_the_links_are_and_a_joint_that_rests_is_not_sent(
    house: OpenHouse, arrive: Arrive, name: RobotName
) -> None:
    opened, model, is_default = house(), robot(name).model, name == "lwr"
    guest = arrive(opened, "autopilot=0")
    guest.ask(lambda s: s.toggle_pause())
    visitor, scene = guest.visitor, opened.server.scene
    arm = ArmView(scene, "/arm", BASE, "ghost", False) if is_default else ArmView(scene, "/arm", BASE, "orange", False, name)
    paths = ["/arm/base" + "".join(f"/{joint}" for joint in list(model.names)[1 : n + 1]) for n in range(model.njoints)]
    assert paths == [arm.link(joint) for joint in range(model.njoints)]
    visitor.wait_for(lambda v: set(paths) <= set(v.mirror.nodes))
    # A ghost casts no shadow.
    assert all(visitor.mirror.nodes[path]["cast_shadow"] is not is_default for path in paths)
    assert all(visitor.mirror.nodes[path]["receive_shadow"] is not is_default for path in paths)
    data = model.createData()

    def stands() -> bool:
        drawn = [drawn_pose(guest, path).homogeneous for path in paths]
        return np.allclose(drawn, [(BASE * pose).homogeneous for pose in data.oMi], atol=1e-6)

    for q in np.random.default_rng(2).uniform(model.lowerPositionLimit, model.upperPositionLimit, (5, model.nq)):
        for shift in (0.0, 0.01):
            q[2] += shift
            before = visitor.received.messages["SetOrientationMessage"]
            arm.show(q.copy())
            pin.forwardKinematics(model, data, q)
            visitor.wait_for(lambda _: stands())
        assert visitor.received.messages["SetOrientationMessage"] == before + 1
    arm.visible = False
    visitor.wait_for(lambda v: not v.mirror.nodes["/arm/base"].get("visible", True))
    arm.remove()
    visitor.wait_for(lambda v: not [node for node in v.mirror.nodes if node.startswith("/arm/")])
