"""The handle on the ball: arrows to push it along the axes of the room, or the ball itself to pull across the view."""

from collections.abc import Callable

import viser

from app.page.handles.pull_ball import Grip
from app.page.handles.transform_handle import TransformHandle
from app.session.actions import Action, Drag
from app.session.session import Session
from app.stage.poses import put
from app.theme import BRAND
from controllers.kinematics import Array
from scenes.room import BALL_RADIUS
from scenes.targets import BallTarget


class BallHandle(TransformHandle):
    """Takes the ball out of the autopilot's hands, and leaves it where it is let go."""

    def __init__(self, scene: viser.SceneApi, session: Session, post: Callable[[Action], None]) -> None:
        super().__init__(scene, session, post, "ball", scale=0.2, disable_rotations=True)
        # Just around the ball, so that it is what the mouse meets.
        self._grip = Grip(scene, "/gizmo/grip", BALL_RADIUS + 0.002, BRAND, 0.0, post, self._pulled)

    def drag(self, action: Drag) -> None:
        """Follow a pull at the arrows or at the ball."""
        self._grip.drag(action)
        super().drag(action)

    def _pulled(self, place: Array | None) -> None:
        self.dragged = place is not None
        self._session.hold(None if place is None else BallTarget(place))

    def _target(self, place: Array | None, turn: Array | None) -> BallTarget | None:
        del turn
        return None if place is None else BallTarget(place)

    def show(self) -> None:
        """Put both where the ball is."""
        simulation = self._session.simulation
        ball = simulation.positions[simulation.room.ball]
        self._grip.put(ball)
        if self._grip.held or not self.dragged:
            put(self._handle, ball)

    def forget_drag(self) -> None:
        """Behave as if it had been let go."""
        super().forget_drag()
        self._grip.forget()

    def remove(self) -> None:
        """Take it out of the scene."""
        super().remove()
        self._grip.remove()
