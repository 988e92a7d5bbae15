"""The ball, taken hold of anywhere, or pushed by arrows along the axes of the room."""

from collections.abc import Callable

import numpy as np
import viser

from app.page.handles.grip import Grip
from app.page.handles.transform_handle import TransformHandle
from app.session.actions import Action
from app.session.session import Session
from app.stage.ball_view import BallView
from app.stage.poses import put
from controllers.kinematics import Array
from scenes.targets import BallTarget


class BallGrip(Grip):
    """Takes the ball out of the autopilot's hands, and leaves it where it is let go."""

    def __init__(self, view: BallView, session: Session, post: Callable[[Action], None]) -> None:
        super().__init__((view.ball,), post)
        self._session, self._ball, self._offset = session, view.ball, np.zeros(3)

    def _take(self, name: str, point: Array) -> None:
        # It was taken at its surface, and must not jump by its radius.
        self._offset = point - np.asarray(self._ball.position, float)

    def _pull(self, place: Array) -> None:
        self._session.hold(BallTarget(place - self._offset))

    def _let_go(self) -> None:
        self._session.hold(None)


class BallHandle(TransformHandle):
    """The arrows on the ball."""

    def __init__(self, scene: viser.SceneApi, session: Session, post: Callable[[Action], None]) -> None:
        super().__init__(scene, session, post, "ball", 0.2, disable_rotations=True)

    def _target(self, place: Array | None, turn: Array | None) -> BallTarget | None:
        del turn
        return None if place is None else BallTarget(place)

    def show(self) -> None:
        """Put it where the ball is, unless it is being dragged."""
        super().show()
        simulation = self._session.simulation
        if not self.dragged:
            put(self._handle, simulation.positions[simulation.room.ball])
