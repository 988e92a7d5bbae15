"""Drawn arms: nested frames, of which only the rotations change, with meshes."""

import math
from collections.abc import Callable
from functools import partial
from typing import Final, Literal

import numpy as np
import pinocchio as pin
import viser

from app.session.frame import Frame
from app.stage.stage_part import Quaternion, StagePart, fresh, quaternion
from app.web.viser_internals import turn
from controllers.kinematics import Array
from scenes.lwr.shells import SEEN_THROUGH
from scenes.robots.drawing import joint_frames, robot_glbs

SHAPE: Final = "shape"

WHOLE: Final = "whole"


class ArmView:
    """One robot's links: nested frames, each with a GLB node.

    The browser mounts a GLB node's children only once it is loaded; no link is a child of one, so all load at
    the same time.

    Args:
        name: of the root node, e.g. "/left".
        palette: of `scenes.lwr.shells`; translucent ones cast no shadow.
        fine: with every triangle; False without a graphics card.

    Raises:
        BadSetting: unknown robot, or a missing package.
    """

    def __init__(
        self, scene: viser.SceneApi, name: str, base: pin.SE3, palette: str, fine: bool, robot: str = "lwr"
    ) -> None:
        glbs, solid = robot_glbs(robot, palette, coarse=not fine), palette not in SEEN_THROUGH
        add_frame = partial(scene.add_frame, show_axes=False)
        add_shape = partial(scene.add_glb, cast_shadow=solid, receive_shadow=solid)
        path = f"{name}/base"
        self.root = fresh(
            add_frame(path, wxyz=quaternion(base.rotation), position=tuple(base.translation.tolist()))
        )
        self.links: list[viser.FrameHandle] = []
        """Frame of each joint, from the base on."""
        self._turns: list[tuple[Quaternion, Quaternion]] = []
        paths = [path]
        for joint in joint_frames(robot):
            path = f"{path}/{joint.name}"
            paths.append(path)
            self.links.append(fresh(add_frame(path, position=joint.position, wxyz=joint.rotation)))
            turned = pin.Quaternion(*joint.rotation) * pin.Quaternion(0.0, *joint.axis)
            self._turns.append((joint.rotation, (turned.w, turned.x, turned.y, turned.z)))
        # Its name gives the browser all links of the arm, see `contact_look.js`.
        add_frame(f"{path}/{WHOLE}")
        for path, glb in zip(paths, glbs, strict=True):
            add_shape(f"{path}/{SHAPE}", glb)
        self._angles = [math.nan] * len(self.links)

    def show(self, positions: Array) -> None:
        """Turn the joints to q (n,) [rad]."""
        for i, angle in enumerate(positions.tolist()):
            if angle != self._angles[i]:
                self._angles[i] = angle
                # Placement ∘ turn about the axis: both quaternions are known, only their shares change.
                (a, b, c, d), (e, f, g, h) = self._turns[i]
                u, v = math.cos(angle / 2.0), math.sin(angle / 2.0)
                turn(self.links[i], (u * a + v * e, u * b + v * f, u * c + v * g, u * d + v * h))

    def link(self, joint: int) -> str:
        """Name of the frame that turns with a joint, 0 for the base."""
        return (self.root, *self.links)[joint].name

    def remove(self) -> None:
        self.root.remove()


DIFFERENT: Final = 0.02
"""Least joint difference for a visible ghost [rad]."""

SAME: Final = 0.008
"""A ghost is hidden if all joints differ less [rad]."""


class TranslucentArms(StagePart):
    """Copies of arms, each made when first visible.

    Args:
        palette: bluish for the ghost, reddish for a desired posture ("wish").
        fine: see `ArmView`.
        posture: frame → joints q (nv,) [rad]; None without copies.
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        palette: Literal["ghost", "wish"],
        fine: bool,
        posture: Callable[[Frame], Array | None],
    ) -> None:
        self._scene, self._palette, self._fine, self._posture = scene, palette, fine, posture
        self._arms: dict[str, ArmView] = {}

    def show(self, frame: Frame) -> None:
        """Draw arms whose joints differ from the run's; nan differs from nothing."""
        positions, simulation, room = self._posture(frame), frame.simulation, frame.simulation.room
        if positions is None:
            self.remove()
            return
        for arm, base, made in zip(room.arms, room.rig.bases, room.robots, strict=True):
            q: Array = positions[arm.joints]
            away = float(np.abs(q - simulation.positions[arm.joints]).max())
            view = self._arms.get(arm.name)
            if view is None:
                if not away > DIFFERENT:
                    continue
                name = f"/{self._palette}/{arm.name}"
                view = ArmView(self._scene, name, base, self._palette, self._fine, made.key)
                self._arms[arm.name] = view
            view.root.visible = away > (SAME if view.root.visible else DIFFERENT)
            if view.root.visible:
                view.show(q)

    def remove(self) -> None:
        for view in self._arms.values():
            view.remove()
        self._arms.clear()


def ghost_posture(frame: Frame) -> Array | None:
    """Joints of a ghost's run in the same room."""
    ghost = frame.ghost
    return ghost.positions if ghost is not None and ghost.room is frame.simulation.room else None
