"""What can be taken hold of on the stage: for each experiment its own handles."""

from collections.abc import Callable
from typing import Final, Protocol

import viser

from app.page.handles.arm_handles import ElbowHandle, HandHandle, swivel_frame
from app.page.handles.ball_handle import BallHandle
from app.page.handles.figure_handles import FigureHandles
from app.session.actions import Action, Drag
from app.session.session import Session
from controllers.kinematics import Array

__all__ = ["NUDGE", "SWING", "Gizmos", "swivel_frame"]

NUDGE: Final = 0.02
"""Way of one key press [m]."""

SWING: Final = 0.07
"""Angle of one key press [rad]."""


class Handle(Protocol):
    """Something that can be taken hold of.

    A handle that is being dragged is left alone; a free one sits on what it moves, so that it snaps back when it is let go.
    """

    @property
    def dragged(self) -> bool: ...

    def drag(self, action: Drag) -> None:
        """Follow a pull at it; nothing happens at a pull at another handle."""
        ...

    def show(self) -> None:
        """Put it where what it moves is."""
        ...

    def forget_drag(self) -> None:
        """Behave as if it had been let go."""
        ...

    def remove(self) -> None:
        """Take it out of the scene."""
        ...


class Gizmos:
    """All handles of one session, drawn on the scene of the client that has the controls.

    Args:
        scene: where to draw.
        session: what is operated.
        post: has an action done on the session's thread.
    """

    def __init__(self, scene: viser.SceneApi, session: Session, post: Callable[[Action], None]) -> None:
        self._scene, self._session, self._post = scene, session, post
        self._handles: tuple[Handle, ...] = ()
        self._made: tuple[object, ...] | None = None
        self._offered = True
        self._make()

    def _make(self) -> None:
        settings = self._session.settings
        figure = settings.run.scene == "imitation" and settings.page.source == "figure"
        made = (
            settings.run.scene,
            settings.run.path,
            id(self._session.simulation.room),
            settings.run.guided,
            figure,
            self._offered,
        )
        if made == self._made:
            return
        self._made = made
        if any(handle.dragged for handle in self._handles):
            # A handle that is no longer there cannot be dragged.
            self._session.hold(None)
        self.remove()
        scene, session, post = self._scene, self._session, self._post
        match settings.run.scene:
            case _ if not self._offered:
                self._handles = ()
            case "ball":
                self._handles = (BallHandle(scene, session, post),)
            case "solo" if settings.run.path == "circle":
                self._handles = ()
            case "imitation":
                self._handles = (FigureHandles(scene, session, post),) if figure else ()
            case _:
                self._handles = (HandHandle(scene, session, post), ElbowHandle(scene, session, post))

    def offer(self, offered: bool) -> None:
        """Show the handles, or none while the visitor cannot move anything."""
        self._offered = offered

    def show(self) -> None:
        """Put the handles that are not dragged where the arm or the ball is; replace them if the experiment has changed."""
        self._make()
        for handle in self._handles:
            handle.show()

    def drag(self, action: Drag) -> None:
        """Follow a pull at a handle."""
        for handle in self._handles:
            handle.drag(action)

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

    def remove(self) -> None:
        """Take the handles out of the scene."""
        for handle in self._handles:
            handle.remove()
        self._handles = ()
