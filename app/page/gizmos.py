"""The handles on the guided arm: its hand to move and turn, its elbow to swivel about the line from shoulder to wrist."""

import math
from typing import Final

import numpy as np
import pinocchio as pin
import viser

from app.session import Session
from controllers.kinematics import Array
from scenes.simulation import Simulation
from scenes.targets import HandTarget

ROOM: Final = 2.5
"""Half the edge of the box in which a hand can be wanted [m]; whatever is dragged beyond counts as its edge."""

NUDGE: Final = 0.02
"""Way of one key press [m]."""


class Gizmos:
    """Both handles of one session, drawn on the scene of whoever has the controls.

    A handle that is being dragged is left alone; a free one sits on its arm, so that it snaps back when it is let go.
    """

    def __init__(self, scene: viser.SceneApi, session: Session) -> None:
        self._session = session
        self._dragged: str | None = None
        self._hand = scene.add_transform_controls(
            "/gizmo/hand", scale=0.22, line_width=3.5, depth_test=False, disable_sliders=True
        )
        self._elbow = scene.add_transform_controls(
            "/gizmo/elbow",
            scale=0.26,
            line_width=3.5,
            depth_test=False,
            disable_sliders=True,
            disable_axes=True,
            active_axes=(False, True, True),
            opacity=0.9,
        )
        self._elbow_start: tuple[Array, Array, Array, Array] | None = None

        @self._hand.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            place, turn = checked_pose(event.target.position, event.target.wxyz)
            phase = event.phase
            session.post(lambda: self._hand_moved(place, turn, phase))

        @self._elbow.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            _, turn = checked_pose((0.0, 0.0, 0.0), event.target.wxyz)
            phase = event.phase
            session.post(lambda: self._elbow_turned(turn, phase))

    def _hand_moved(self, place: Array | None, turn: Array | None, phase: str) -> None:
        if phase == "end":
            self._let_go("hand")
        elif place is not None and turn is not None:
            self._dragged = "hand"
            self._session.hold(HandTarget(place, turn))

    def _elbow_turned(self, turn: Array | None, phase: str) -> None:
        session, simulation = self._session, self._session.simulation
        if phase == "end":
            self._let_go("elbow")
            return
        if turn is None:
            return
        if self._dragged != "elbow" or self._elbow_start is None:
            self._dragged = "elbow"
            kinematics, arm = simulation.kinematics, simulation.guided
            pose = kinematics.hand_pose(arm)
            frame, centre = swivel_frame(simulation)
            self._elbow_start = frame, centre, pose.translation.copy(), pose.rotation.copy()
            self._elbow_point = kinematics.joint_point(arm.elbow)
        frame, centre, hand, rotation = self._elbow_start
        # The handle turns about its own first axis, which is the line from shoulder to wrist.
        angle = pin.log3(turn.dot(frame.T)).dot(frame[:, 0])
        swung = pin.exp3(frame[:, 0] * angle).dot(self._elbow_point - centre)
        session.hold(HandTarget(hand, rotation, centre + swung))

    def _let_go(self, name: str) -> None:
        if self._dragged == name:
            self._dragged = None
            self._elbow_start = None
            self._session.hold(None)

    def show(self) -> None:
        """Put the handles that nobody drags where the arm is."""
        simulation = self._session.simulation
        if self._dragged != "hand":
            pose = simulation.kinematics.hand_pose(simulation.guided)
            _put(self._hand, pose.translation, pose.rotation)
        if self._dragged != "elbow":
            frame, _ = swivel_frame(simulation)
            _put(self._elbow, simulation.kinematics.joint_point(simulation.guided.elbow), frame)

    def forget_drag(self) -> None:
        """Behave as if every handle had been let go; for a reset in mid-drag."""
        self._dragged = None
        self._elbow_start = None

    def remove(self) -> None:
        """Take the handles out of the scene."""
        self._hand.remove()
        self._elbow.remove()


def swivel_frame(simulation: Simulation) -> tuple[Array, Array]:
    """Return a frame (3, 3) whose first axis runs from shoulder to wrist and whose other two lie on either side of
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


def checked_pose(position: object, wxyz: object) -> tuple[Array | None, Array | None]:
    """Return a place (3,) inside the room and a rotation (3, 3) of what a browser sent, None for either that is not one."""
    place, turn = np.asarray(position, float), np.asarray(wxyz, float)
    if place.shape != (3,) or not np.isfinite(place).all():
        return None, None
    if turn.shape != (4,) or not np.isfinite(turn).all() or not 0.5 < float(turn.dot(turn)) < 2.0:
        return np.clip(place, -ROOM, ROOM), None
    w, x, y, z = (turn / math.sqrt(float(turn.dot(turn)))).tolist()
    return np.clip(place, -ROOM, ROOM), pin.Quaternion(w, x, y, z).toRotationMatrix()


def _put(handle: viser.TransformControlsHandle, place: Array, rotation: Array) -> None:
    turn = pin.Quaternion(rotation)
    wxyz = (turn.w, turn.x, turn.y, turn.z)
    if np.abs(np.asarray(handle.position) - place).max() > 1e-5 or np.abs(np.asarray(handle.wxyz) - wxyz).max() > 1e-5:
        handle.position = place
        handle.wxyz = wxyz
