"""Context of an operator's panels."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

import viser

from app.page.handles.gizmos import Gizmos
from app.page.panels import PagePanel
from app.page.panels.controls import Controls
from app.page.panels.hotkeys import Hotkey
from app.page.view import View
from app.session.action_handlers import ActionHandlers
from app.session.frame import Frame
from app.session.session import Session

P = TypeVar("P", bound=PagePanel)


@dataclass(frozen=True, eq=False)
class PanelContext:
    """Page of an operator while its panels are made.

    Attributes:
        keep: folder “Keep and replay”; hidden while few controls are shown.
        private: False for the session of a class or group.
        owners: True for the person who started the server.
        instead: keys with other meanings, because others watch.
        links: each returns a query in place of the settings', or None.
    """

    client: viser.ClientHandle
    session: Session
    view: View
    handlers: ActionHandlers
    controls: Controls
    gizmos: Gizmos
    keep: viser.GuiFolderHandle
    private: bool
    owners: bool = False
    instead: tuple[Hotkey[Any], ...] = ()
    made: list[PagePanel] = field(default_factory=list)
    links: list[Callable[[Frame], Mapping[str, str] | None]] = field(default_factory=list)

    def panel(self, kind: type[P]) -> P:
        """Raises `LookupError` if no such panel was made before; its feature must be below in
        `app.features`."""
        for panel in self.made:
            if isinstance(panel, kind):
                return panel
        raise LookupError(
            f"no {kind.__name__} was made before: its feature must stand below the one that asks for it"
        )


PanelMaker = Callable[[PanelContext], PagePanel | None]
"""Makes a panel; None if the page has no place for it."""
