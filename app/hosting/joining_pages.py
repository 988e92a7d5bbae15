"""Pages that join a visitor's private session."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Protocol

import viser

from app.hosting.admission import Pieces
from app.hosting.app_context import AppContext
from app.hosting.visitor import Visitor


@dataclass(frozen=True)
class Joining:
    """Makers of joining pages, one per feature; see `AppContext.given`."""

    makers: "tuple[Callable[[AppContext], JoiningPages], ...]" = ()


class JoiningPages(Protocol):
    """Joining pages of one host and feature. Frame loop's thread only."""

    def expects(self, query: Mapping[str, str]) -> bool:
        """True if a link leads to another visitor's session."""
        ...

    def build(self, client: viser.ClientHandle, visitors: Collection[Visitor]) -> Pieces:
        """Build an expected client's page in pieces. `visitors`: of this host."""
        ...

    def leave(self, client_id: int) -> None:
        """Close a disconnected client's page, if any."""
        ...

    def follow(self, visitors: Collection[Visitor]) -> None:
        """Update `Visitor.beside`, before every round of frames."""
        ...

    def words(self, visitors: Collection[Visitor]) -> Collection[str]:
        """Words of links to these visitors; see `app.settings.JOIN`."""
        ...

    def opened_elsewhere(self, word: str) -> None:
        """Note that this word's link leads to another host of this server."""
        ...
