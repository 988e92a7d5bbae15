"""A ball that is pulled across the view with the mouse."""

from collections.abc import Callable

import numpy as np
import viser

from app.session.actions import Action, Drag
from app.stage.poses import checked_point, put
from controllers.kinematics import Array


class Grip:
    """Stays where it is put; the page draws an arrow from where it was taken to the mouse.

    Args:
        name: of the node.
        radius: [m].
        color, opacity: how it looks.
        post: has an action done on the session's thread.
        pulled: called by `drag` with the place (3,) [m] that the mouse pulls its middle to, and with None when it is let go.
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        name: str,
        radius: float,
        color: tuple[int, int, int],
        opacity: float | None,
        post: Callable[[Action], None],
        pulled: Callable[[Array | None], None],
    ) -> None:
        self._ball = scene.add_icosphere(
            name, radius=radius, subdivisions=3, color=color, opacity=opacity, cast_shadow=False, receive_shadow=False
        )
        self._name, self._pulled = name, pulled
        self._offset: Array | None = None

        @self._ball.on_drag
        async def _(event: viser.SceneNodeDragEvent[viser.IcosphereHandle]) -> None:
            taken, to, phase = checked_point(event.start_position), checked_point(event.end_position), event.phase
            post(Drag(name, phase, to, taken=taken))

    @property
    def held(self) -> bool:
        """Whether the mouse pulls at it."""
        return self._offset is not None

    def drag(self, action: Drag) -> None:
        """Follow a pull at it; nothing happens at a pull at another handle."""
        taken, to = action.taken, action.place
        if action.handle != self._name:
            return
        if action.phase == "end":
            if self._offset is not None:
                self._offset = None
                self._pulled(None)
            return
        if taken is None or to is None:
            return
        if action.phase == "start":
            # It was taken at its surface, and must not jump by its radius.
            self._offset = taken - np.asarray(self._ball.position, float)
        if self._offset is not None:
            self._pulled(to - self._offset)

    def forget(self) -> None:
        """Behave as if it had been let go."""
        self._offset = None

    def put(self, place: Array) -> None:
        """Move it to a place (3,) [m]."""
        put(self._ball, place)

    def remove(self) -> None:
        """Take it out of the scene."""
        self._ball.remove()
