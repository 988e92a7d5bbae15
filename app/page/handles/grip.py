"""Something drawn on the stage that a mouse or a finger takes hold of and pulls across the view."""

from collections.abc import Callable, Iterable
from typing import Any

import viser

from app.session.actions import Action, Drag
from app.stage.poses import checked_point
from controllers.kinematics import Array

Node = viser.GlbHandle | viser.IcosphereHandle


class Grip:
    """Nodes of the stage of which one is pulled at a time.

    Args:
        nodes: what can be taken hold of.
        post: has an action done on the session's thread.
    """

    def __init__(self, nodes: Iterable[Node], post: Callable[[Action], None]) -> None:
        self._nodes = {node.name: node for node in nodes}
        self._taken: str | None = None

        async def pulled(event: viser.SceneNodeDragEvent[Any]) -> None:
            taken, to = checked_point(event.start_position), checked_point(event.end_position)
            post(Drag(event.target.name, event.phase, to, taken=taken))

        for node in self._nodes.values():
            node.on_drag(pulled)

    @property
    def dragged(self) -> bool:
        """Whether the visitor pulls at one of the nodes."""
        return self._taken is not None

    def drag(self, action: Drag) -> None:
        """Follow a pull at one of the nodes; nothing happens at a pull at anything else."""
        if action.handle not in self._nodes:
            return
        if action.phase == "end":
            if self._taken == action.handle:
                self._taken = None
                self._let_go()
            return
        if action.taken is None or action.place is None:
            return
        if action.phase == "start":
            self._taken = action.handle
            self._take(action.handle, action.taken)
        if self._taken == action.handle:
            self._pull(action.place)

    def _take(self, name: str, point: Array) -> None:
        """Take hold of a node at a point (3,), world [m]."""
        raise NotImplementedError

    def _pull(self, place: Array) -> None:
        """Pull what was taken to a place (3,), world [m]."""
        raise NotImplementedError

    def _let_go(self) -> None:
        """Leave what was taken where it is."""
        raise NotImplementedError

    def show(self) -> None:
        """Bring it up to date with the session."""

    def forget_drag(self) -> None:
        """Behave as if it had been let go."""
        self._taken = None

    def remove(self, nodes_stay: bool) -> None:
        """Make the nodes plain again. `nodes_stay`: whether they are still on the stage."""
        if nodes_stay:
            for node in self._nodes.values():
                node.remove_drag_callback()
