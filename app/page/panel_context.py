"""What the panels of a visitor who operates a session are made from."""

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
    """The page of an operator while its panels are made.

    Attributes:
        client: of the operator.
        session: what is operated.
        view: what is seen of it.
        handlers: of the page's actions.
        controls: of the session's settings.
        gizmos: with which the visitor moves what they hold.
        keep: the folder “Keep and replay”; not visible while few things are shown.
        private: whether the session belongs to this visitor alone: not to a class or one of its groups.
        owners: True on the page of the person who started the server.
        instead: keys that mean something else on this page, which others watch.
        made: the panels made so far.
        links: each returns what a link to the frame says, in place of settings; None if it has nothing to say.
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
        """Panel of a class that was made before.

        Raises:
            LookupError: none is of this class; the feature that has it must stand below in `app.features`.
        """
        for panel in self.made:
            if isinstance(panel, kind):
                return panel
        raise LookupError(f"no {kind.__name__} was made before: its feature must stand below the one that asks for it")


PanelMaker = Callable[[PanelContext], PagePanel | None]
"""Makes a panel of a page; None if this page has no place for it."""
