"""Where the live session of a visitor who is away waits, under the id that each tab keeps."""

from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass
from time import monotonic
from typing import Final

from app.hosting.visitor_record import VisitorRecord, link_of, tab_id
from app.session.session import Session
from app.settings import OPENED

AWAY: Final = 600.0
"""How long a live session waits for its visitor [s]."""

MOST_SESSIONS: Final = 8
"""Live sessions that are kept at once; the oldest makes room. Each holds the history of its run."""


@dataclass(frozen=True)
class _Parked:
    query: Mapping[str, str]
    session: Session
    since: float


class Parking:
    """Keeps live sessions in memory, so that a tab that reconnects continues where it was. Belongs to the frame loop's thread.

    The same tab gets its session back by the same link. A visitor without a valid id leaves nothing. Records are not kept here;
    a feature may keep them (`app.feature.Feature.store`).

    Args:
        clock: returns the time [s].
    """

    def __init__(self, clock: Callable[[], float] = monotonic) -> None:
        self._clock = clock
        self.parked: dict[str, _Parked] = {}

    @property
    def lasting(self) -> bool:
        """True if records outlive the server."""
        return False

    @property
    def health(self) -> Mapping[str, object]:
        """What `/healthz` says of it; called on the network's thread."""
        return {}

    @property
    def trouble(self) -> tuple[str, str] | None:
        """Title and text, in English, of what visitors have to know now; None if all is well."""
        return None

    def save(self, record: VisitorRecord) -> None:
        """Keep a visitor's record in place of an earlier one."""

    def recall(self, query: Mapping[str, str]) -> Generator[None, None, VisitorRecord | None]:
        """Find the record of a visitor by the query of the new link; None if there is no record, or if the live session waits for this
        visitor.

        Yields while it is being read.
        """
        yield from ()
        return None

    def alone_has(self, query: Mapping[str, str]) -> bool:
        """True if what a tab comes back for is in this process, and nowhere else."""
        return tab_id(query) in self.parked

    def park(self, query: Mapping[str, str], session: Session) -> None:
        """Keep a live session, which does not advance meanwhile; a session that cannot be claimed is closed."""
        tab = tab_id(query)
        if tab is None:
            session.close()
            return
        session.hand.hold(None)
        self._close(tab)
        self.parked[tab] = _Parked(query, session, self._clock())
        self.tidy()

    def claim(self, query: Mapping[str, str]) -> Session | None:
        """Return the live session of a tab that is back by the same link, else None; by another link the session is closed."""
        self.tidy()
        tab = tab_id(query) or ""
        if not self.awaits(query):
            self._close(tab)
            return None
        return self.parked.pop(tab).session

    def awaits(self, query: Mapping[str, str]) -> bool:
        """True if a live session waits for this tab with this link."""
        parked = self.parked.get(tab_id(query) or "")
        return parked is not None and link_of(parked.query) == link_of(query)

    def is_reload(self, query: Mapping[str, str]) -> bool:
        """True if the tab of a live session has loaded its page again; False if only its connection was lost."""
        parked = self.parked.get(tab_id(query) or "")
        return parked is not None and parked.query.get(OPENED) != query.get(OPENED)

    def tidy(self) -> None:
        """Drop what is too old or too much."""
        now = self._clock()
        # In order of age, the oldest first.
        for tab, parked in list(self.parked.items()):
            if now - parked.since <= AWAY and len(self.parked) <= MOST_SESSIONS:
                break
            self._close(tab)

    def close(self) -> None:
        """Close every session."""
        for tab in list(self.parked):
            self._close(tab)

    def _close(self, tab: str) -> None:
        parked = self.parked.pop(tab, None)
        if parked is not None:
            parked.session.close()
