"""What a feature keeps for a whole server, and what it does for one visitor of it."""

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
    """A visitor's session while its page is not built yet.

    Attributes:
        session: of the visitor.
        language: of the page.
        query: of the visitor's link.
        private: whether the session belongs to this visitor alone: not to a class or one of its groups.
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
    """What a feature does for one visitor, besides its panels; a subclass overrides what it needs."""

    def open(self, record: VisitorRecord | None) -> tuple[str, ...]:
        """Open what the visitor's link or record asks for; a message for every part of the link that is not possible."""
        del record
        return ()

    def notify(self) -> None:
        """Say what is wrong with the feature's files, once the page is built, or built again after `outdated`."""

    def add_to(self, client: viser.ClientHandle, view: View) -> None:
        """Add to the visitor's page, after its panels."""

    def show(self, frame: Frame) -> None:
        """Update what `add_to` has added."""

    @property
    def outdated(self) -> bool:
        """True if the page must be built again, such as after a file was read again."""
        return False

    def renew(self, language: Language) -> None:
        """Prepare for a page that is built again. `language`: of that page."""


class ServerPart:
    """What a feature keeps for a whole server; a subclass overrides what it needs."""

    def visit(self, visit: Visit) -> VisitorPart | None:
        """Part of a visitor who comes; None if the feature does nothing for this one."""
        del visit
        return None

    def prepare(self, language: Language) -> None:
        """Read or make what is slow the first time, in a thread of its own."""

    def close(self) -> None:
        """End threads and release files; the server has ended."""
