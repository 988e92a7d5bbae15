"""Drawn arms: nested nodes stand where the links are, and only what moves is sent."""

from types import SimpleNamespace
from typing import get_args

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

from app.stage.arms import ArmView
from scenes.robots import RobotName, robot

NAMES: tuple[RobotName, ...] = get_args(RobotName)
BASE = pin.SE3(pin.exp3(np.array([0.4, -0.9, 0.3])), np.array([0.1, -0.2, 0.9]))


class Node(SimpleNamespace):
    @property
    def wxyz(self) -> tuple[float, ...]:
        return self.turns[-1]

    @wxyz.setter
    def wxyz(self, turn: tuple[float, ...]) -> None:
        self.turns.append(turn)

    def remove(self) -> None:
        self.removed = True


class Scene:
    """Stands for viser's scene; keeps every node that is added."""

    def __init__(self) -> None:
        self.nodes: dict[str, Node] = {}

    def add_glb(self, name: str, data: bytes, *, position=(0.0, 0.0, 0.0), wxyz=(1.0, 0.0, 0.0, 0.0), **options) -> Node:
        assert data[:4] == b"glTF"
        self.nodes[name] = Node(position=position, options=options, turns=[wxyz], removed=False, visible=True)
        return self.nodes[name]

    def pose(self, name: str) -> pin.SE3:
        """Where a node is in the world: its own pose after those of all its parents that exist."""
        pose, path = pin.SE3.Identity(), ""
        for step in name.strip("/").split("/"):
            path = f"{path}/{step}"
            if path in self.nodes:
                node = self.nodes[path]
                turn = np.array(node.wxyz, float)
                assert_allclose(turn @ turn, 1.0, atol=1e-12)
                pose = pose * pin.SE3(pin.Quaternion(*turn).toRotationMatrix(), np.array(node.position))
        return pose


def view(name: RobotName, palette: str = "orange") -> tuple[ArmView, Scene]:
    """A coarse arm, which is quick to build, and its scene."""
    scene = Scene()
    return ArmView(scene, "/arm", BASE, palette, False, name), scene  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize("name", NAMES)
def test_nodes_stand_where_the_links_are_and_a_joint_that_rests_costs_nothing(name: RobotName) -> None:
    """Every node, at postures all over the joints' range, against Pinocchio's joint poses."""
    (arm, scene), model = view(name), robot(name).model
    paths = ["/arm/base" + "".join(f"/{joint}" for joint in list(model.names)[1 : n + 1]) for n in range(model.njoints)]
    assert list(scene.nodes) == paths == [arm.link(joint) for joint in range(model.njoints)]
    data = model.createData()
    for q in np.random.default_rng(2).uniform(model.lowerPositionLimit, model.upperPositionLimit, (20, model.nq)):
        arm.show(q)
        pin.forwardKinematics(model, data, q)
        for joint, path in enumerate(paths):
            assert_allclose(scene.pose(path).homogeneous, (BASE * data.oMi[joint]).homogeneous, atol=1e-9)
        sent = [len(node.turns) for node in scene.nodes.values()]
        arm.show(q.copy())
        q[2] += 0.01
        arm.show(q)
        assert [len(node.turns) for node in scene.nodes.values()] == [n + (i == 3) for i, n in enumerate(sent)]


def test_the_robot_of_the_paper_is_the_default() -> None:
    scene = Scene()
    ArmView(scene, "/arm", BASE, "silver", False)  # pyright: ignore[reportArgumentType]
    assert list(scene.nodes) == list(view("lwr")[1].nodes) and len(scene.nodes) == 8


@pytest.mark.parametrize(("palette", "solid"), [("orange", True), ("ghost", False)])
def test_an_arm_is_hidden_and_removed_at_its_root_and_a_ghost_casts_no_shadow(palette: str, solid: bool) -> None:
    arm, scene = view("lwr", palette)
    assert all(node.options == {"cast_shadow": solid, "receive_shadow": solid} for node in scene.nodes.values())
    assert arm.visible
    arm.visible = False
    arm.remove()
    assert not arm.visible
    assert [path for path, node in scene.nodes.items() if node.removed or not node.visible] == ["/arm/base"]
    assert scene.nodes["/arm/base"].removed and not scene.nodes["/arm/base"].visible
