"""Whether the pointer rests on the visitor's hand or ball, as the page's `hand_hover.js` says it by a hidden box."""

from collections.abc import Callable
from typing import Any

import viser

from app.session.actions import Action, Hover
from app.text.html_element import element
from app.web.viser_internals import uuid_of


class HandHover:
    """Names the node to the page's script, and passes on what the script says.

    Args:
        post: has an action done on the session's thread.
    """

    def __init__(self, gui: viser.GuiApi, post: Callable[[Action], None]) -> None:
        box = gui.add_checkbox("", False, visible=False)
        self._id = uuid_of(box)
        self._mark = gui.add_html("", order=-1.0)
        self._node: str | None = None

        @box.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            if event.client_id is not None:
                post(Hover(event.target.value))

    def show(self, node: str) -> None:
        """Watch a node of the scene; "" for none."""
        if node == self._node:
            return
        self._node = node
        self._mark.content = element("i", hidden="", data_duet_hover=node, data_box=self._id)
