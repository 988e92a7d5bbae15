"""A feature's parts for a whole server, and for one visitor."""

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
        private: whether the session is this visitor's alone, not of a class or group.
        back: whether a live session was claimed from the store.
        new: whether the store has nothing of the visitor.
    """

    session: Session
    language: Language
    query: Mapping[str, str]
    private: bool
    back: bool
    new: bool


class VisitorPart:
    """A feature's part for one visitor, besides panels; a subclass overrides what it needs."""

    def open(self, record: VisitorRecord | None) -> tuple[str, ...]:
        """Open what the visitor's link or record asks for; return a message for every impossible part of the
        link."""
        del record
        return ()

    def notify(self) -> None:
        """Report problems with the feature's files, once the page is built, also again after `outdated`."""

    def add_to(self, client: viser.ClientHandle, view: View) -> None:
        """Add to the visitor's page, after its panels."""

    def show(self, frame: Frame) -> None:
        """Update what `add_to` has added."""

    @property
    def outdated(self) -> bool:
        """True if the page must be built again, for example after a file was read again."""
        return False

    def renew(self, language: Language) -> None:
        """Prepare for a page that is built again in `language`."""


class ServerPart:
    """A feature's part for a whole server; a subclass overrides what it needs."""

    def visit(self, visit: Visit) -> VisitorPart | None:
        del visit
        return None

    def prepare(self, language: Language) -> None:
        """Read or make what is slow the first time, in its own thread."""

    def close(self) -> None:
        """End threads and release files, after the server's end."""
