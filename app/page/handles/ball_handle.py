"""The handle on the ball: arrows to push it along the axes of the room, or the ball itself to pull across the view."""

from collections.abc import Callable

import viser

from app.page.handles.pull_ball import Grip
from app.session.actions import Action, Drag
from app.session.session import Session
from app.stage.poses import checked_point, fresh, put
from app.theme import BRAND
from controllers.kinematics import Array
from scenes.room import BALL_RADIUS
from scenes.targets import BallTarget


class BallHandle:
    """Takes the ball out of the autopilot's hands, and leaves it where it is let go.

    Args:
        scene: of the client that has the controls.
        session: with a ball.
        post: has an action done on the session's thread.
    """

    def __init__(self, scene: viser.SceneApi, session: Session, post: Callable[[Action], None]) -> None:
        self._session = session
        self._pushed = False
        arrows = scene.add_transform_controls(
            "/gizmo/ball", scale=0.2, line_width=3.5, depth_test=False, disable_sliders=True, disable_rotations=True
        )
        self._arrows = fresh(arrows)
        # Just around the ball, so that it is what the mouse meets.
        self._grip = Grip(scene, "/gizmo/grip", BALL_RADIUS + 0.002, BRAND, 0.0, post, self._pulled)

        @self._arrows.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            post(Drag("ball", event.phase, checked_point(event.target.position)))

    @property
    def dragged(self) -> bool:
        """Whether the visitor is dragging it."""
        return self._pushed or self._grip.held

    def _pulled(self, place: Array | None) -> None:
        self._session.hold(None if place is None else BallTarget(place))

    def drag(self, action: Drag) -> None:
        """Follow a pull at the arrows or at the ball."""
        self._grip.drag(action)
        if action.handle != "ball":
            return
        if action.phase == "end":
            if self._pushed:
                self._pushed = False
                self._session.hold(None)
        elif action.place is not None:
            self._pushed = True
            self._session.hold(BallTarget(action.place))

    def show(self) -> None:
        """Put both where the ball is."""
        simulation = self._session.simulation
        ball = simulation.positions[simulation.room.ball]
        self._grip.put(ball)
        if not self._pushed:
            put(self._arrows, ball)

    def forget_drag(self) -> None:
        """Behave as if it had been let go."""
        self._pushed = False
        self._grip.forget()

    def remove(self) -> None:
        """Take it out of the scene."""
        self._arrows.remove()
        self._grip.remove()
