"""Arrows and arcs on the hand, the ball, and the elbow."""

import math
from typing import Any, Final

import numpy as np
import pinocchio as pin
import viser

from app.page.handles.holder import Holder
from app.session.actions import Drag
from app.stage.stage_part import fresh, in_room, quaternion, rotation_of
from controllers.kinematics import Array
from scenes.first_task.wall import angles_of, turn_of
from scenes.targets import BallTarget, HandTarget, Target, WallTarget

AUTOPILOT_SIZE: Final = 0.6
"""Factor of the handles' size while the autopilot plays."""


class TransformHandle:
    """Transform controls; a subclass defines place and drags.

    Args:
        name: of the node under `/gizmo`, and of the handle in a `Drag`.
        size: length of the arrows [m].
        look: further arguments of viser's `add_transform_controls`.
    """

    def __init__(self, scene: viser.SceneApi, holder: Holder, name: str, size: float, **look: Any) -> None:
        self._holder, self._name, self._size = holder, name, size
        self.dragged = False
        self._handle = fresh(
            scene.add_transform_controls(
                f"/gizmo/{name}", scale=size, line_width=3.5, depth_test=False, disable_sliders=True, **look
            )
        )

        @self._handle.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            holder.post(
                Drag(name, event.phase, in_room(event.target.position), rotation_of(event.target.wxyz))
            )

    def drag(self, action: Drag) -> None:
        """Follows the rules of `app.page.handles.grips.Grip.drag`."""
        if action.handle != self._name or action.turn is None:
            return
        if action.phase == "start":
            target = self._target(action.place, action.turn)
            self.dragged = True
            self._holder.hold(target)
        elif self._holder.held is None:
            # A reset, or what leads the session, has ended the pull.
            self.dragged = False
        elif self.dragged and action.phase == "update":
            self._holder.hold(self._target(action.place, action.turn))
        elif self.dragged:
            self.dragged = False
            self._holder.hold(None)

    def show(self, visible: bool) -> None:
        """Update place and size, unless dragged: another size would end the drag."""
        if not self.dragged:
            self._handle.scale = self._size * (
                AUTOPILOT_SIZE if self._holder.settings.page.autopilot else 1.0
            )
            self._handle.position, rotation = self._seat()
            self._handle.wxyz = quaternion(rotation)
        self._handle.visible = visible

    def _seat(self) -> tuple[Array, Array]:
        """Place (3,) [m] and orientation (3, 3)."""
        raise NotImplementedError

    def _target(self, place: Array, turn: Array) -> Target:
        """`place`: (3,) [m]; `turn`: (3, 3)."""
        raise NotImplementedError

    def forget_drag(self) -> None:
        self.dragged = False

    def remove(self) -> None:
        self._handle.remove()


FARTHEST_SWING: Final = 0.35
"""Largest lead of a held key over the elbow [rad]."""


class HandHandle(TransformHandle):
    """Handle on the visitor's hand or on its desired place."""

    def __init__(self, scene: viser.SceneApi, holder: Holder) -> None:
        super().__init__(scene, holder, "hand", 0.22)

    def _target(self, place: Array, turn: Array) -> HandTarget:
        return HandTarget(place, turn if _turn_counts(self._holder) else None)

    def show(self, visible: bool) -> None:
        self._handle.disable_rotations = not _turn_counts(self._holder)
        super().show(visible)

    def _seat(self) -> tuple[Array, Array]:
        place, rotation = wanted_pose(self._holder)
        return place, rotation if _turn_counts(self._holder) else np.eye(3)


class ElbowHandle(TransformHandle):
    """Arc about the line from shoulder to wrist; the hand keeps its place."""

    def __init__(self, scene: viser.SceneApi, holder: Holder) -> None:
        arc = {"disable_axes": True, "active_axes": (False, True, True), "opacity": 0.9}
        super().__init__(scene, holder, "elbow", 0.26, **arc)
        self._start: tuple[Array, Array, Array, HandTarget] | None = None

    def _target(self, place: Array, turn: Array) -> HandTarget:
        del place
        if self._start is None or not self.dragged:
            frame, centre = swivel_frame(self._holder)
            self._start = frame, centre, _elbow(self._holder) - centre, _hand_kept(self._holder)
        frame, centre, out, hand = self._start
        # The handle turns about its first axis, the line from shoulder to wrist.
        angle = pin.log3(turn.dot(frame.T)).dot(frame[:, 0])
        return hand._replace(elbow=centre + pin.exp3(frame[:, 0] * angle).dot(out))

    def _seat(self) -> tuple[Array, Array]:
        return _elbow(self._holder), swivel_frame(self._holder)[0]


def swing_elbow(holder: Holder, angle: float) -> None:
    """Pull the elbow further by an angle [rad]; the hand keeps its place."""
    frame, centre = swivel_frame(holder)
    out = _elbow(holder) - centre
    held = holder.held if isinstance(holder.held, HandTarget) else None
    ahead = 0.0
    if held is not None and held.elbow is not None:
        there = held.elbow - centre
        ahead = math.atan2(float(frame[:, 0].dot(np.cross(out, there))), float(out.dot(there)))
    turned = min(max(ahead + angle, -FARTHEST_SWING), FARTHEST_SWING)
    holder.hold((held or _hand_kept(holder))._replace(elbow=centre + pin.exp3(frame[:, 0] * turned).dot(out)))


def keeps_place(holder: Holder) -> bool:
    """True if the visitor moves the arm's desired place."""
    return holder.arm is holder.simulation.avoiding


def _turn_counts(holder: Holder) -> bool:
    simulation = holder.simulation
    return not keeps_place(holder) or simulation.room.task(simulation.settings) == "pose"


def _elbow(holder: Holder) -> Array:
    return holder.simulation.kinematics.joint_point(holder.arm.elbow)


def wanted_pose(holder: Holder) -> tuple[Array, Array]:
    """Copies of the hand's desired place (3,) [m] and orientation (3, 3)."""
    simulation = holder.simulation
    pose = simulation.kinematics.hand_pose(holder.arm)
    keeper = simulation.keeper
    if keeps_place(holder) and keeper is not None:
        return keeper.place.copy(), (keeper.place_rotation if _turn_counts(holder) else pose.rotation).copy()
    return pose.translation.copy(), pose.rotation.copy()


def _hand_kept(holder: Holder) -> HandTarget:
    joints, (place, rotation) = holder.arm.joints, wanted_pose(holder)
    spare = joints.stop - joints.start > 6 and _turn_counts(holder)
    return HandTarget(place, rotation if spare else None)


def swivel_frame(holder: Holder) -> tuple[Array, Array]:
    """Frame (3, 3), the first axis from shoulder to wrist, the others on both sides of the elbow; and the
    elbow's foot on that line (3,) [m]."""
    kinematics, arm = holder.simulation.kinematics, holder.arm
    shoulder, elbow, wrist = (kinematics.joint_point(j) for j in (arm.shoulder, arm.elbow, arm.wrist))
    x = wrist - shoulder
    x /= np.linalg.norm(x)
    out = elbow - shoulder
    foot = shoulder + x * x.dot(out)
    y = elbow - foot
    length = float(np.linalg.norm(y))
    if length < 1e-6:
        # A straight arm has no swivel angle: any direction across the line serves.
        y = np.cross(x, np.eye(3)[int(np.argmin(np.abs(x)))])
        length = float(np.linalg.norm(y))
    y = y / length
    z = np.cross(x, y)
    # The handle's arc runs from its second to its third axis; turned back by half a right angle, it is
    # centred on the elbow.
    frame: Array = np.column_stack([x, (y - z) / math.sqrt(2.0), (y + z) / math.sqrt(2.0)]).astype(np.float64)
    return frame, foot


class BallHandle(TransformHandle):
    def __init__(self, scene: viser.SceneApi, holder: Holder) -> None:
        super().__init__(scene, holder, "ball", 0.2, disable_rotations=True)

    def _target(self, place: Array, turn: Array) -> BallTarget:
        del turn
        return BallTarget(place)

    def _seat(self) -> tuple[Array, Array]:
        simulation = self._holder.simulation
        return simulation.positions[simulation.room.ball], np.eye(3)


class WallHandle(TransformHandle):
    """Arrows and arcs on the wall."""

    def __init__(self, scene: viser.SceneApi, holder: Holder) -> None:
        super().__init__(scene, holder, "wall", 0.26)

    def _target(self, place: Array, turn: Array) -> WallTarget:
        return WallTarget(place, angles_of(-turn[:, 0]))

    def _seat(self) -> tuple[Array, Array]:
        simulation = self._holder.simulation
        at = simulation.positions[simulation.room.wall]
        return at[:3], turn_of(at)
