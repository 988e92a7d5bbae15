"""One drawn arm: nested nodes; only their rotations change."""

import math

import pinocchio as pin
import viser

from app.stage.poses import fresh
from app.web.viser_internals import turn
from controllers.kinematics import Array
from scenes.lwr.shells import SEEN_THROUGH
from scenes.robots.drawing import joint_frames, robot_glbs

Quaternion = tuple[float, float, float, float]
"""(w, x, y, z)"""


class ArmView:
    """The links of one robot as GLB nodes, each the child of the link before it.

    Args:
        scene: where to draw.
        name: of the root node, e.g. "/left".
        base: pose of the base.
        palette: of `scenes.lwr.shells`; what can be seen through casts no shadow.
        fine: with every triangle, or for a browser without a graphics card.
        robot: which make.

    Raises:
        BadSetting: there is no such robot, or what it needs is not installed.
    """

    def __init__(self, scene: viser.SceneApi, name: str, base: pin.SE3, palette: str, fine: bool, robot: str = "lwr") -> None:
        glbs, solid = robot_glbs(robot, palette, coarse=not fine), palette not in SEEN_THROUGH
        rotation = pin.Quaternion(base.rotation)
        path = f"{name}/base"
        root = scene.add_glb(
            path,
            glbs[0],
            wxyz=(rotation.w, rotation.x, rotation.y, rotation.z),
            position=tuple(base.translation.tolist()),
            cast_shadow=solid,
            receive_shadow=solid,
        )
        self._root = fresh(root)
        self.links: list[viser.GlbHandle] = []
        """The node that turns with each joint, from the base on."""
        self._paths = [path]
        self._turns: list[tuple[Quaternion, Quaternion]] = []
        for joint, glb in zip(joint_frames(robot), glbs[1:], strict=True):
            path = f"{path}/{joint.name}"
            self._paths.append(path)
            link = scene.add_glb(path, glb, position=joint.position, wxyz=joint.rotation, cast_shadow=solid, receive_shadow=solid)
            self.links.append(fresh(link))
            self._turns.append((joint.rotation, _product(joint.rotation, (0.0, *joint.axis))))
        self._angles = [math.nan] * len(self.links)

    def show(self, positions: Array) -> None:
        """Turn the joints to q (n,) [rad]; a joint that has not moved costs nothing."""
        for i, angle in enumerate(positions.tolist()):
            if angle != self._angles[i]:
                self._angles[i] = angle
                # Placement ∘ turn about the axis: both quaternions are known, only their shares change.
                (a, b, c, d), (e, f, g, h) = self._turns[i]
                u, v = math.cos(angle / 2.0), math.sin(angle / 2.0)
                turn(self.links[i], (u * a + v * e, u * b + v * f, u * c + v * g, u * d + v * h))

    def link(self, joint: int) -> str:
        """Return the name of the node that turns with a joint, 0 for the base; what hangs on it goes with it."""
        return self._paths[joint]

    @property
    def visible(self) -> bool:
        return self._root.visible

    @visible.setter
    def visible(self, visible: bool) -> None:
        self._root.visible = visible

    def remove(self) -> None:
        self._root.remove()


def _product(p: Quaternion, q: Quaternion) -> Quaternion:
    a, b, c, d = p
    e, f, g, h = q
    return (
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    )
