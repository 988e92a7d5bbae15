"""What can be taken hold of on the stage: for each experiment its own handles."""

from collections.abc import Callable
from typing import Final

import viser

from app.lessons.session.lesson_session import LessonSession
from app.page.handles.arm_handles import ElbowHandle, HandHandle, swivel_frame
from app.page.handles.ball_handle import BallHandle
from app.page.handles.figure_handles import FigureHandles
from app.session.actions import Action, Drag
from app.session.frame import Frame
from app.session.session import Session
from controllers.kinematics import Array

__all__ = ["NUDGE", "SWING", "Gizmos", "swivel_frame"]

NUDGE: Final = 0.02
"""Way of one key press [m]."""

SWING: Final = 0.07
"""Angle of one key press [rad]."""


Handle = HandHandle | ElbowHandle | BallHandle | FigureHandles
"""A handle that is being dragged is left alone; a free one sits on what it moves, so that it snaps back when it is let go."""


class Gizmos:
    """All handles of one session, drawn on the scene of the client that has the controls.

    Args:
        lessons: an open one may move what the handles would.
        post: has an action done on the session's thread.
    """

    def __init__(self, scene: viser.SceneApi, session: Session, lessons: LessonSession, post: Callable[[Action], None]) -> None:
        self._scene, self._session, self._lessons, self._post = scene, session, lessons, post
        self._handles: tuple[Handle, ...] = ()
        self._made: tuple[object, ...] | None = None

    def show(self, frame: Frame) -> None:
        """Put the handles that are not dragged where the arm or the ball is; replace them if the experiment has changed."""
        session, run = self._session, self._session.settings.run
        # A replay cannot be taken hold of.
        offered = not frame.replayed and not self._lessons.hands_off
        figure = run.scene == "imitation" and session.settings.page.source == "figure"
        made = run.scene, run.path, id(session.simulation.room), run.guided, figure, offered
        if made != self._made:
            self._made = made
            if any(handle.dragged for handle in self._handles):
                # A handle that is no longer there cannot be dragged.
                session.hold(None)
            for handle in self._handles:
                handle.remove()
            self._handles = self._make(figure) if offered else ()
        for handle in self._handles:
            handle.show()

    def drag(self, action: Drag) -> None:
        """Follow a pull at a handle."""
        for handle in self._handles:
            handle.drag(action)

    def _make(self, figure: bool) -> tuple[Handle, ...]:
        run, of = self._session.settings.run, (self._scene, self._session, self._post)
        match run.scene:
            case "ball":
                return (BallHandle(*of),)
            case "solo" if run.path == "circle":
                return ()
            case "imitation":
                return (FigureHandles(*of),) if figure else ()
            case _:
                return HandHandle(*of), ElbowHandle(*of)

    def nudge(self, way: Array) -> None:
        """Move what is yours, a hand or the ball, by (3,) [m]; nothing happens where nothing is."""
        if self._handles:
            self._session.nudge(way)

    def swing(self, angle: float) -> None:
        """Swing the elbow of your arm by an angle [rad]; nothing happens where there is none to be swung."""
        for handle in self._handles:
            if isinstance(handle, ElbowHandle):
                handle.swing(angle)

    def forget_drag(self) -> None:
        """Behave as if every handle had been let go; for a reset in mid-drag."""
        for handle in self._handles:
            handle.forget_drag()
