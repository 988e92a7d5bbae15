"""Handles of one visitor."""

from collections.abc import Callable
from typing import Final, Literal

import numpy as np
import viser

from app.page.handles.grips import ArmGrip, BallGrip, FigureGrip, Grip, WallGrip
from app.page.handles.holder import Holder
from app.page.handles.transform_handles import (
    BallHandle,
    ElbowHandle,
    HandHandle,
    TransformHandle,
    WallHandle,
    swing_elbow,
)
from app.session.action_handlers import ActionHandlers
from app.session.actions import Drag, Hover, Nudge, SwingElbow
from app.session.frame import Frame
from app.session.visitor_hand import VisitorHand
from app.stage.arms import ArmView
from app.stage.ball_view import BallView
from app.stage.person_figure import FigureView
from app.stage.stage import Yours
from app.stage.wall_view import WallView
from app.text.templates import element
from app.web.control_events import on_entry
from app.web.viser_internals import uuid_of
from controllers.kinematics import Array

NUDGE: Final = 0.02
"""Step of one key press [m]."""

SWING: Final = 0.07
"""Angle of one key press [rad]."""


class Gizmos:
    """Grip and handles on one client's scene. The hand or the ball shows its arrows if `hand_hover.js`
    reports the pointer over it.

    Args:
        yours, wall: return what can be held, or None.
        hands_off: True while a part of the session moves what the visitor would.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        holder: Holder,
        yours: Callable[[], Yours | None],
        hands_off: Callable[[], bool],
        handlers: ActionHandlers,
        wall: Callable[[], WallView | None] = lambda: None,
    ) -> None:
        self._wall = wall
        self._wall_grip: WallGrip | None = None
        self._client, self._holder, self._yours, self._hands_off = client, holder, yours, hands_off
        self._grip: Grip | None = None
        self._gripped: object = None
        self._handles: tuple[TransformHandle, ...] = ()
        self._made: tuple[object, ...] | None = None
        self._arrows: Literal["all", "hand", "none"] = "none"
        self._hovered = False
        box = client.gui.add_checkbox("", False, visible=False)
        self._hover_box = uuid_of(on_entry(box, lambda on: holder.post(Hover(on))))
        self._watched = client.gui.add_html("", order=-1.0)
        handlers.add(Drag, self._drag)
        handlers.add(Hover, self._hover)
        handlers.add(SwingElbow, self._swing_elbow)

    def show(self, frame: Frame) -> None:
        """Update the undragged handles; replace them after a change of experiment."""
        holder, run = self._holder, self._holder.settings.run
        # A replay cannot be moved, nor a hand that draws a circle.
        offered = not (frame.replayed or self._hands_off() or run.draws_circle)
        yours = self._yours() if offered else None
        dragged = any(each.dragged for each in self._pulled_at)
        if not dragged:
            # Arrows shown or hidden by hovering must not end a pull that has just begun.
            self._arrows = "all" if holder.settings.page.gizmo else "hand" if self._hovered else "none"
        made = id(holder.simulation.room), run.scene, run.guided, offered, self._arrows
        if yours is not self._gripped or made != self._made:
            if dragged:
                # What was removed cannot be dragged.
                holder.hold(None)
            if yours is not self._gripped:
                self._take_up(yours)
            self._made = made
            for handle in self._handles:
                handle.remove()
            self._handles = self._make() if yours is not None else ()
            if self._wall_grip is not None:
                # Nothing else turns it.
                self._handles += (WallHandle(self._client.scene, holder),)
        if self._grip is not None:
            self._grip.show()
        # Arrows shown by hovering would only hide a pull.
        visible = self._arrows == "all" or self._grip is None or not self._grip.dragged
        for handle in self._handles:
            handle.show(visible)

    @property
    def _pulled_at(self) -> tuple[Grip | TransformHandle, ...]:
        return tuple(each for each in (self._grip, self._wall_grip, *self._handles) if each is not None)

    def _take_up(self, yours: Yours | None) -> None:
        if self._grip is not None:
            self._grip.remove(nodes_stay=self._gripped is self._yours())
        if self._wall_grip is not None:
            self._wall_grip.remove(nodes_stay=self._gripped is self._yours())
        wall = self._wall() if yours is not None else None
        self._wall_grip = None if wall is None else WallGrip(wall, self._holder)
        self._gripped, node = yours, ""
        match yours:
            case ArmView():
                self._grip, node = ArmGrip(yours, self._holder), yours.links[-1].name
            case BallView():
                self._grip, node = BallGrip(yours, self._holder), yours.ball.name
            case FigureView() if isinstance(self._holder, VisitorHand):
                self._grip = FigureGrip(yours, self._holder)
            case _:
                self._grip = None
        # The node at which the arrows appear.
        self._watched.content = element("i", hidden="", data_duet_hover=node, data_box=self._hover_box)

    def _make(self) -> tuple[TransformHandle, ...]:
        of = self._client.scene, self._holder
        match self._gripped, self._arrows:
            case (_, "none") | (FigureView(), _):
                return ()
            case BallView(), _:
                return (BallHandle(*of),)
            case _, "hand":
                return (HandHandle(*of),)
            case _:
                return HandHandle(*of), ElbowHandle(*of)

    def _drag(self, action: Drag) -> None:
        for each in self._pulled_at:
            each.drag(action)

    def _hover(self, action: Hover) -> None:
        self._hovered = action.on

    def _swing_elbow(self, action: SwingElbow) -> None:
        if isinstance(self._grip, ArmGrip):
            swing_elbow(self._holder, action.sign * SWING)

    def nudge(self, action: Nudge) -> None:
        """Move the hand or the ball by one step. The page adds this handler, as its keys may have other
        meanings."""
        if self._grip is not None:
            self._holder.nudge(_in_view(self._client.camera, action))

    def forget_drag(self) -> None:
        for each in self._pulled_at:
            each.forget_drag()


def _in_view(camera: viser.CameraHandle, nudge: Nudge) -> Array:
    """Displacement (3,) in the world [m]: across the view, up, and away along the floor."""
    forward = np.asarray(camera.look_at, float) - np.asarray(camera.position, float)
    forward[2] = 0.0
    length = float(np.linalg.norm(forward))
    forward = forward / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    across = np.array([forward[1], -forward[0], 0.0])
    return NUDGE * (nudge.right * across + nudge.up * np.array([0.0, 0.0, 1.0]) + nudge.away * forward)
