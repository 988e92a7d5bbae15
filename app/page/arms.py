"""One drawn arm: nested nodes whose rotations alone change."""

import math

import pinocchio as pin
import viser

from controllers.kinematics import Array
from scenes.lwr.facts import JOINTS
from scenes.lwr.shells import link_glbs


class ArmView:
    """The links of one LWR as GLB nodes, each the child of the link before it.

    Args:
        scene: where to draw.
        name: of the root node, e.g. "/left".
        base: pose of the base.
        palette: of `scenes.lwr.shells`.
        fine: with every triangle, or for a browser without a graphics card.
    """

    def __init__(self, scene: viser.SceneApi, name: str, base: pin.SE3, palette: str, fine: bool) -> None:
        glbs = link_glbs(palette, coarse=not fine)
        turn = pin.Quaternion(base.rotation)
        self._root = scene.add_glb(
            f"{name}/base", glbs[0], wxyz=(turn.w, turn.x, turn.y, turn.z), position=tuple(base.translation.tolist())
        )
        self._links: list[viser.GlbHandle] = []
        path = f"{name}/base"
        for joint, glb in zip(JOINTS, glbs[1:], strict=True):
            path = f"{path}/{joint.name}"
            self._links.append(scene.add_glb(path, glb, position=(0.0, 0.0, joint.origin)))
        self._angles = [math.nan] * len(JOINTS)

    def show(self, positions: Array) -> None:
        """Turn the joints to q (7,) [rad]; a joint that has not moved costs nothing."""
        for i, (angle, joint) in enumerate(zip(positions.tolist(), JOINTS, strict=True)):
            if angle != self._angles[i]:
                self._angles[i] = angle
                s, (x, y, z) = math.sin(angle / 2.0), joint.axis
                self._links[i].wxyz = (math.cos(angle / 2.0), s * x, s * y, s * z)

    def remove(self) -> None:
        """Take the arm out of the scene."""
        self._root.remove()
