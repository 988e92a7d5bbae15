"""Handles with arrows and arcs: on the hand to move and turn it, on the ball, and on the elbow to swivel it about the line from shoulder to
wrist."""

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
"""How much smaller they are while the autopilot plays."""


class TransformHandle:
    """Transform controls; a subclass says where they sit and what a drag of them means. One that is dragged is left alone; a free one sits
    on what it moves, so that it snaps back when it is let go.

    Args:
        name: of the node under `/gizmo`, and of the handle in a `Drag`.
        size: length of the arrows [m].
        look: further arguments of viser's `add_transform_controls`.
    """

    def __init__(self, scene: viser.SceneApi, holder: Holder, name: str, size: float, **look: Any) -> None:
        self._holder, self._name, self._size = holder, name, size
        self.dragged = False
        """Whether the visitor is dragging it."""
        self._handle = fresh(
            scene.add_transform_controls(
                f"/gizmo/{name}", scale=size, line_width=3.5, depth_test=False, disable_sliders=True, **look
            )
        )

        @self._handle.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            holder.post(Drag(name, event.phase, in_room(event.target.position), rotation_of(event.target.wxyz)))

    def drag(self, action: Drag) -> None:
        """Follow a pull at it; nothing happens at a pull at another handle, or after a reset until the pointer is released."""
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
        """Put it where it belongs, in the size that goes with who moves, unless it is being dragged: another size would end that."""
        if not self.dragged:
            self._handle.scale = self._size * (AUTOPILOT_SIZE if self._holder.settings.page.autopilot else 1.0)
            self._handle.position, rotation = self._seat()
            self._handle.wxyz = quaternion(rotation)
        self._handle.visible = visible

    def _seat(self) -> tuple[Array, Array]:
        """Place of the handle (3,) [m] and its orientation (3, 3)."""
        raise NotImplementedError

    def _target(self, place: Array, turn: Array) -> Target:
        """What is held with the handle at a place (3,) [m], turned (3, 3)."""
        raise NotImplementedError

    def forget_drag(self) -> None:
        """Behave as if it had been let go."""
        self.dragged = False

    def remove(self) -> None:
        """Take it out of the scene."""
        self._handle.remove()


FARTHEST_SWING: Final = 0.35
"""A key held down pulls the elbow no further ahead of where it is [rad]."""


class HandHandle(TransformHandle):
    """Sits on the hand that one moves, or, where a hand is drawn to its place, on the place."""

    def __init__(self, scene: viser.SceneApi, holder: Holder) -> None:
        super().__init__(scene, holder, "hand", 0.22)

    def _target(self, place: Array, turn: Array) -> HandTarget:
        return HandTarget(place, turn if _turn_counts(self._holder) else None)

    def show(self, visible: bool) -> None:
        """Offer turns where they count, and put it where it belongs, unless it is being dragged."""
        self._handle.disable_rotations = not _turn_counts(self._holder)
        super().show(visible)

    def _seat(self) -> tuple[Array, Array]:
        place, rotation = wanted_pose(self._holder)
        return place, rotation if _turn_counts(self._holder) else np.eye(3)


class ElbowHandle(TransformHandle):
    """An arc about the line from shoulder to wrist; the hand stays where it is."""

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
        # The handle turns about its own first axis, which is the line from shoulder to wrist.
        angle = pin.log3(turn.dot(frame.T)).dot(frame[:, 0])
        return hand._replace(elbow=centre + pin.exp3(frame[:, 0] * angle).dot(out))

    def _seat(self) -> tuple[Array, Array]:
        return _elbow(self._holder), swivel_frame(self._holder)[0]


def swing_elbow(holder: Holder, angle: float) -> None:
    """Pull the elbow on by an angle [rad], or, where it is not pulled, away from where it is; the hand stays where it is."""
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
    """True if your arm is drawn to its place, so that it is the place that you move."""
    return holder.arm is holder.simulation.avoiding


def _turn_counts(holder: Holder) -> bool:
    simulation = holder.simulation
    return not keeps_place(holder) or simulation.room.task(simulation.settings) == "pose"


def _elbow(holder: Holder) -> Array:
    return holder.simulation.kinematics.joint_point(holder.arm.elbow)


def wanted_pose(holder: Holder) -> tuple[Array, Array]:
    """Desired place of your hand while it is not moved (3,) [m], and its desired orientation (3, 3); copies."""
    simulation = holder.simulation
    pose = simulation.kinematics.hand_pose(holder.arm)
    keeper = simulation.keeper
    if keeps_place(holder) and keeper is not None:
        return keeper.place.copy(), (keeper.place_rotation if _turn_counts(holder) else pose.rotation).copy()
    return pose.translation.copy(), pose.rotation.copy()


def _hand_kept(holder: Holder) -> HandTarget:
    """Return the hand at its place, and turned as it is where the elbow can move all the same."""
    joints, (place, rotation) = holder.arm.joints, wanted_pose(holder)
    spare = joints.stop - joints.start > 6 and _turn_counts(holder)
    return HandTarget(place, rotation if spare else None)


def swivel_frame(holder: Holder) -> tuple[Array, Array]:
    """Return a frame (3, 3) with the first axis from shoulder to wrist and the other two on either side of
    the elbow, and the elbow's foot on that line (3,) [m]; of their arm."""
    kinematics, arm = holder.simulation.kinematics, holder.arm
    shoulder, elbow, wrist = (kinematics.joint_point(j) for j in (arm.shoulder, arm.elbow, arm.wrist))
    x = wrist - shoulder
    x /= np.linalg.norm(x)
    out = elbow - shoulder
    foot = shoulder + x * x.dot(out)
    y = elbow - foot
    length = float(np.linalg.norm(y))
    if length < 1e-6:
        # A straight arm has no swivel angle: any direction across the line will do.
        y = np.cross(x, np.eye(3)[int(np.argmin(np.abs(x)))])
        length = float(np.linalg.norm(y))
    y = y / length
    z = np.cross(x, y)
    # The handle's arc runs from its second to its third axis; half a right angle back, it is centred on the elbow.
    frame: Array = np.column_stack([x, (y - z) / math.sqrt(2.0), (y + z) / math.sqrt(2.0)]).astype(np.float64)
    return frame, foot


class BallHandle(TransformHandle):
    """The arrows on the ball."""

    def __init__(self, scene: viser.SceneApi, holder: Holder) -> None:
        super().__init__(scene, holder, "ball", 0.2, disable_rotations=True)

    def _target(self, place: Array, turn: Array) -> BallTarget:
        del turn
        return BallTarget(place)

    def _seat(self) -> tuple[Array, Array]:
        simulation = self._holder.simulation
        return simulation.positions[simulation.room.ball], np.eye(3)


class WallHandle(TransformHandle):
    """The arrows and arcs on the wall."""

    def __init__(self, scene: viser.SceneApi, holder: Holder) -> None:
        super().__init__(scene, holder, "wall", 0.26)

    def _target(self, place: Array, turn: Array) -> WallTarget:
        return WallTarget(place, angles_of(-turn[:, 0]))

    def _seat(self) -> tuple[Array, Array]:
        simulation = self._holder.simulation
        at = simulation.positions[simulation.room.wall]
        return at[:3], turn_of(at)
