"""Parts of a feature."""

from collections.abc import Mapping
from dataclasses import dataclass

import viser

from app.hosting.visitor_record import VisitorRecord
from app.page.view import View
from app.session.frame import Frame
from app.session.session import Session
from app.settings import Language


@dataclass(frozen=True, eq=False)
class Visit:
    """A visitor's session before its page is built.

    Attributes:
        private: not of a class or group.
        back: a live session was claimed from the store.
        new: nothing in the store.
    """

    session: Session
    language: Language
    query: Mapping[str, str]
    private: bool
    back: bool
    new: bool


class VisitorPart:
    """A feature's part for one visitor, besides panels."""

    def open(self, record: VisitorRecord | None) -> tuple[str, ...]:
        """Open what link or record ask for; messages for impossible parts of the link."""
        del record
        return ()

    def notify(self) -> None:
        """Report problems with files, also after `outdated`."""

    def add_to(self, client: viser.ClientHandle, view: View) -> None:
        """Add to the page, after its panels."""

    def show(self, frame: Frame) -> None:
        """Update what `add_to` added."""

    @property
    def outdated(self) -> bool:
        """True if the page must be rebuilt."""
        return False

    def renew(self, language: Language) -> None:
        """Prepare for a rebuilt page in `language`."""


class ServerPart:
    """A feature's part for a server."""

    def visit(self, visit: Visit) -> VisitorPart | None:
        del visit
        return None

    def prepare(self, language: Language) -> None:
        """Read or make slow things, in its own thread."""

    def close(self) -> None:
        """End threads and release files, after the server's end."""
