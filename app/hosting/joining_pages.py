"""Pages of people who join a visitor's private session instead of having one of their own; a feature makes them."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Protocol

import viser

from app.hosting.admission import Pieces
from app.hosting.app_context import AppContext
from app.hosting.visitor import Visitor


@dataclass(frozen=True)
class Joining:
    """What makes the pages of a private host, one of each feature that has such pages; see `AppContext.given`."""

    makers: "tuple[Callable[[AppContext], JoiningPages], ...]" = ()


class JoiningPages(Protocol):
    """All such pages of one host and one feature. Belongs to the frame loop's thread."""

    def expects(self, query: Mapping[str, str]) -> bool:
        """True if a link leads to another visitor's session."""
        ...

    def build(self, client: viser.ClientHandle, visitors: Collection[Visitor]) -> Pieces:
        """Build the page of a client that is expected, piece by piece.

        Args:
            visitors: all of this host.
        """
        ...

    def leave(self, client_id: int) -> None:
        """Close the page of a client that has disconnected; nothing happens if it has none here."""
        ...

    def follow(self, visitors: Collection[Visitor]) -> None:
        """Add every page to `Visitor.beside` of its visitor, who may have gone or come back; called before every round of frames."""
        ...

    def words(self, visitors: Collection[Visitor]) -> Collection[str]:
        """Words of the links that lead to visitors of this host, see `app.settings.JOIN`."""
        ...

    def opened_elsewhere(self, word: str) -> None:
        """The link of a word leads to a visitor of another host of this server."""
        ...
