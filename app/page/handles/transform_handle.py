"""What the handles with arrows and arcs have in common: viser's transform controls, and what a drag of them makes the session hold."""

from collections.abc import Callable
from typing import Any, Final

import viser

from app.session.actions import Action, Drag
from app.session.session import Session
from app.stage.poses import checked_pose, fresh
from controllers.kinematics import Array
from scenes.targets import Target

AUTOPILOT_SIZE: Final = 0.6
"""How much smaller they are while the autopilot plays."""


class TransformHandle:
    """Transform controls; a subclass says what a drag of them means.

    Args:
        name: of the node under `/gizmo`, and of the handle in a `Drag`.
        post: has an action done on the session's thread.
        size: length of the arrows [m].
        look: further arguments of viser's `add_transform_controls`.
    """

    def __init__(
        self, scene: viser.SceneApi, session: Session, post: Callable[[Action], None], name: str, size: float, **look: Any
    ) -> None:
        self._session, self._name, self._size = session, name, size
        self.dragged = False
        """Whether the visitor is dragging it."""
        self._handle = fresh(
            scene.add_transform_controls(
                f"/gizmo/{name}", scale=size, line_width=3.5, depth_test=False, disable_sliders=True, **look
            )
        )

        @self._handle.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            post(Drag(name, event.phase, *checked_pose(event.target.position, event.target.wxyz)))

    def drag(self, action: Drag) -> None:
        """Follow a pull at it; nothing happens at a pull at another handle."""
        if action.handle != self._name:
            return
        if action.phase != "end":
            target = self._target(action.place, action.turn)
            if target is not None:
                self.dragged = True
                self._session.hold(target)
        elif self.dragged:
            self.dragged = False
            self._session.hold(None)

    def show(self) -> None:
        """Take the size that goes with who moves, unless it is being dragged: another size would end that."""
        if not self.dragged:
            self._handle.scale = self._size * (AUTOPILOT_SIZE if self._session.settings.page.autopilot else 1.0)

    @property
    def visible(self) -> bool:
        return self._handle.visible

    @visible.setter
    def visible(self, visible: bool) -> None:
        self._handle.visible = visible

    def _target(self, place: Array | None, turn: Array | None) -> Target | None:
        """Return what is held with the handle at a place (3,) [m], turned (3, 3); None if that says nothing."""
        raise NotImplementedError

    def forget_drag(self) -> None:
        """Behave as if it had been let go."""
        self.dragged = False

    def remove(self) -> None:
        """Take it out of the scene."""
        self._handle.remove()
