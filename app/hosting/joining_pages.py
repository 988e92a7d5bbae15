"""Pages that join a visitor's private session; a feature makes them."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Protocol

import viser

from app.hosting.admission import Pieces
from app.hosting.app_context import AppContext
from app.hosting.visitor import Visitor


@dataclass(frozen=True)
class Joining:
    """Makers of a private host's joining pages, one per feature; see `AppContext.given`."""

    makers: "tuple[Callable[[AppContext], JoiningPages], ...]" = ()


class JoiningPages(Protocol):
    """Joining pages of one host and one feature. Belongs to the frame loop's thread."""

    def expects(self, query: Mapping[str, str]) -> bool:
        """True if a link leads to another visitor's session."""
        ...

    def build(self, client: viser.ClientHandle, visitors: Collection[Visitor]) -> Pieces:
        """Build the page of an expected client, piece by piece. `visitors`: all of this host."""
        ...

    def leave(self, client_id: int) -> None:
        """Close the page of a disconnected client, if any."""
        ...

    def follow(self, visitors: Collection[Visitor]) -> None:
        """Update `Visitor.beside`; called before every round of frames."""
        ...

    def words(self, visitors: Collection[Visitor]) -> Collection[str]:
        """Words of the links to this host's visitors; see `app.settings.JOIN`."""
        ...

    def opened_elsewhere(self, word: str) -> None:
        """Note that the link with this word leads to another host of this server."""
        ...
