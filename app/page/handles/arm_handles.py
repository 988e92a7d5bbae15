"""The handles on an arm: its hand to move and turn, its elbow to swivel about the line from shoulder to wrist."""

import math
from collections.abc import Callable
from typing import Final

import numpy as np
import pinocchio as pin
import viser

from app.session.actions import Action, Drag
from app.session.session import Session
from app.stage.poses import checked_pose, fresh, put
from controllers.kinematics import Array
from scenes.simulation import Simulation
from scenes.targets import HandTarget

FARTHEST_SWING: Final = 0.35
"""A key held down pulls the elbow no further ahead of where it is [rad]."""


class HandHandle:
    """Sits on the hand that one moves, or, where a hand is drawn to its place, on the place.

    Args:
        scene: of the client that has the controls.
        session: with an arm that is yours.
        post: has an action done on the session's thread.
    """

    def __init__(self, scene: viser.SceneApi, session: Session, post: Callable[[Action], None]) -> None:
        self._session = session
        self._turns = True
        self.dragged = False
        """Whether the visitor is dragging it."""
        handle = scene.add_transform_controls("/gizmo/hand", scale=0.22, line_width=3.5, depth_test=False, disable_sliders=True)
        self._handle = fresh(handle)

        @self._handle.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            post(Drag("hand", event.phase, *checked_pose(event.target.position, event.target.wxyz)))

    def drag(self, action: Drag) -> None:
        """Follow a pull at it."""
        if action.handle != "hand":
            return
        if action.phase == "end":
            if self.dragged:
                self.dragged = False
                self._session.hold(None)
        elif action.place is not None and action.turn is not None:
            self.dragged = True
            self._session.hold(HandTarget(action.place, action.turn if self._turns else None))

    def show(self) -> None:
        """Put it where it belongs, unless it is being dragged."""
        simulation = self._session.simulation
        turns = not keeps_place(simulation) or simulation.settings.task == "pose"
        if turns != self._turns:
            self._turns = turns
            self._handle.disable_rotations = not turns
        if not self.dragged:
            place, rotation = wanted_pose(simulation)
            put(self._handle, place, rotation if turns else np.eye(3))

    def forget_drag(self) -> None:
        """Behave as if it had been let go."""
        self.dragged = False

    def remove(self) -> None:
        """Take it out of the scene."""
        self._handle.remove()


class ElbowHandle:
    """An arc about the line from shoulder to wrist; the hand stays where it is.

    Args:
        scene: of the client that has the controls.
        session: with an arm that is yours.
        post: has an action done on the session's thread.
    """

    def __init__(self, scene: viser.SceneApi, session: Session, post: Callable[[Action], None]) -> None:
        self._session = session
        self._start: tuple[Array, Array, Array, HandTarget] | None = None
        handle = scene.add_transform_controls(
            "/gizmo/elbow",
            scale=0.26,
            line_width=3.5,
            depth_test=False,
            disable_sliders=True,
            disable_axes=True,
            active_axes=(False, True, True),
            opacity=0.9,
        )
        self._handle = fresh(handle)

        @self._handle.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            post(Drag("elbow", event.phase, *checked_pose((0.0, 0.0, 0.0), event.target.wxyz)))

    @property
    def dragged(self) -> bool:
        """Whether the visitor is dragging it."""
        return self._start is not None

    def drag(self, action: Drag) -> None:
        """Follow a pull along the arc."""
        session, simulation, turn = self._session, self._session.simulation, action.turn
        if action.handle != "elbow":
            return
        if action.phase == "end":
            if self._start is not None:
                self._start = None
                session.hold(None)
            return
        if turn is None:
            return
        if self._start is None:
            frame, centre = swivel_frame(simulation)
            elbow = simulation.kinematics.joint_point(simulation.guided.elbow)
            place, rotation = wanted_pose(simulation)
            self._start = frame, centre, elbow - centre, HandTarget(place, rotation if _spare(simulation) else None)
        frame, centre, out, hand = self._start
        # The handle turns about its own first axis, which is the line from shoulder to wrist.
        angle = pin.log3(turn.dot(frame.T)).dot(frame[:, 0])
        session.hold(hand._replace(elbow=centre + pin.exp3(frame[:, 0] * angle).dot(out)))

    def swing(self, angle: float) -> None:
        """Have the elbow pulled on by an angle [rad], or, where it is not dragged, away from where it is; the hand stays where it is."""
        session, simulation = self._session, self._session.simulation
        frame, centre = swivel_frame(simulation)
        out = simulation.kinematics.joint_point(simulation.guided.elbow) - centre
        held = session.held if isinstance(session.held, HandTarget) else None
        ahead = 0.0
        if held is not None and held.elbow is not None:
            there = held.elbow - centre
            ahead = math.atan2(float(frame[:, 0].dot(np.cross(out, there))), float(out.dot(there)))
        if held is None:
            place, rotation = wanted_pose(simulation)
            held = HandTarget(place, rotation if _spare(simulation) else None)
        turned = min(max(ahead + angle, -FARTHEST_SWING), FARTHEST_SWING)
        session.hold(held._replace(elbow=centre + pin.exp3(frame[:, 0] * turned).dot(out)))

    def show(self) -> None:
        """Put it where the elbow is, unless it is being dragged."""
        simulation = self._session.simulation
        if self._start is None:
            frame, _ = swivel_frame(simulation)
            put(self._handle, simulation.kinematics.joint_point(simulation.guided.elbow), frame)

    def forget_drag(self) -> None:
        """Behave as if it had been let go."""
        self._start = None

    def remove(self) -> None:
        """Take it out of the scene."""
        self._handle.remove()


def keeps_place(simulation: Simulation) -> bool:
    """Return whether your arm is drawn to its place, so that it is the place that you move."""
    return simulation.guided is simulation.avoiding


def wanted_pose(simulation: Simulation) -> tuple[Array, Array]:
    """Return where your hand is wanted while it is not moved (3,) [m], and how it is to be turned (3, 3); copies."""
    pose = simulation.kinematics.hand_pose(simulation.guided)
    place, rotation = simulation.place, simulation.place_rotation
    if keeps_place(simulation) and place is not None and rotation is not None:
        return place.copy(), rotation.copy() if simulation.settings.task == "pose" else pose.rotation.copy()
    return pose.translation.copy(), pose.rotation.copy()


def _spare(simulation: Simulation) -> bool:
    """Return whether the elbow can move while the hand keeps its place and its turn."""
    joints = simulation.guided.joints
    return joints.stop - joints.start > 6 and (not keeps_place(simulation) or simulation.settings.task == "pose")


def swivel_frame(simulation: Simulation) -> tuple[Array, Array]:
    """Return a frame (3, 3) with the first axis from shoulder to wrist and the other two on either side of
    the elbow, and the elbow's foot on that line (3,) [m]; guided arm."""
    kinematics, arm = simulation.kinematics, simulation.guided
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
