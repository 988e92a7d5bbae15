"""Drawn arms: nested nodes stand where the links are, and only what moves is sent."""

from dataclasses import dataclass, field
from typing import get_args

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

from app.stage.arms import ArmView
from scenes.robots import RobotName, robot

NAMES: tuple[RobotName, ...] = get_args(RobotName)
BASE = pin.SE3(pin.exp3(np.array([0.4, -0.9, 0.3])), np.array([0.1, -0.2, 0.9]))


@dataclass
class Node:
    """A node of a scene that only remembers."""

    name: str
    position: tuple[float, ...]
    options: dict[str, object]
    turns: list[tuple[float, ...]] = field(default_factory=list)
    removed: bool = False
    visible: bool = True

    @property
    def wxyz(self) -> tuple[float, ...]:
        """How it is turned now."""
        return self.turns[-1]

    @wxyz.setter
    def wxyz(self, turn: tuple[float, ...]) -> None:
        self.turns.append(turn)

    def remove(self) -> None:
        """Remember that it was removed."""
        self.removed = True


class Scene:
    """Stands for viser's scene; keeps every node that is added."""

    def __init__(self) -> None:
        self.nodes: dict[str, Node] = {}

    def add_glb(self, name: str, data: bytes, *, position=(0.0, 0.0, 0.0), wxyz=(1.0, 0.0, 0.0, 0.0), **options) -> Node:
        """Add a node, with real GLB data only."""
        assert data[:4] == b"glTF"
        self.nodes[name] = Node(name, position, options, [wxyz])
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


def view(scene: Scene, name: RobotName, palette: str = "orange") -> ArmView:
    """A coarse arm, which is quick to build."""
    return ArmView(scene, "/arm", BASE, palette, False, name)  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize("name", NAMES)
def test_nodes_stand_where_the_links_are(name: RobotName) -> None:
    """Every node, at postures all over the joints' range, against Pinocchio's joint poses."""
    scene, model = Scene(), robot(name).model
    arm = view(scene, name)
    paths = ["/arm/base" + "".join(f"/{joint}" for joint in list(model.names)[1 : n + 1]) for n in range(model.njoints)]
    assert list(scene.nodes) == paths
    data = model.createData()
    for q in np.random.default_rng(2).uniform(model.lowerPositionLimit, model.upperPositionLimit, (20, model.nq)):
        arm.show(q)
        pin.forwardKinematics(model, data, q)
        for joint, path in enumerate(paths):
            assert_allclose(scene.pose(path).homogeneous, (BASE * data.oMi[joint]).homogeneous, atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_a_joint_that_rests_costs_nothing(name: RobotName) -> None:
    scene = Scene()
    arm, q = view(scene, name), np.linspace(-0.5, -0.2, robot(name).model.nq)
    arm.show(q)
    sent = {path: len(node.turns) for path, node in scene.nodes.items()}
    arm.show(q.copy())
    assert sent == {path: len(node.turns) for path, node in scene.nodes.items()}
    q[2] += 0.01
    arm.show(q)
    more = [path for path, node in scene.nodes.items() if len(node.turns) > sent[path]]
    assert more == [list(scene.nodes)[3]]


def test_the_paper_s_robot_is_the_default() -> None:
    scene, told = Scene(), Scene()
    ArmView(scene, "/arm", BASE, "silver", False)  # pyright: ignore[reportArgumentType]
    view(told, "lwr", "silver")
    assert list(scene.nodes) == list(told.nodes) and len(scene.nodes) == 8


@pytest.mark.parametrize(("palette", "solid"), [("orange", True), ("ghost", False)])
def test_a_ghost_casts_no_shadow(palette: str, solid: bool) -> None:
    scene = Scene()
    view(scene, "lwr", palette)
    assert all(node.options == {"cast_shadow": solid, "receive_shadow": solid} for node in scene.nodes.values())


def test_an_arm_is_removed_at_its_root() -> None:
    scene = Scene()
    view(scene, "lwr").remove()
    assert [path for path, node in scene.nodes.items() if node.removed] == ["/arm/base"]


def test_an_arm_is_hidden_at_its_root_and_names_its_links() -> None:
    scene = Scene()
    arm = view(scene, "ur5")
    assert [arm.link(joint) for joint in range(7)] == list(scene.nodes)
    assert arm.visible
    arm.visible = False
    assert not arm.visible
    assert [path for path, node in scene.nodes.items() if not node.visible] == ["/arm/base"]
