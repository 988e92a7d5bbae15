"""Pages of people who join a visitor's private session instead of having one of their own; a feature makes them."""

from collections.abc import Collection, Mapping
from typing import Protocol

import viser

from app.hosting.admission import Pieces
from app.hosting.visitor import Visitor


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

    def receive(self, word: str) -> None:
        """Another worker has announced the word of a link, see `Announced`."""
        ...
