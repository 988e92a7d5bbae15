"""Live sessions of absent visitors, by tab."""

from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass
from time import monotonic
from typing import Final

from app.hosting.visitor_record import VisitorRecord, link_of, tab_id
from app.session.session import Session
from app.settings import OPENED

AWAY: Final = 600.0
"""Time that a live session is kept [s]."""

MOST_SESSIONS: Final = 8
"""Most live sessions, each with its run's history; the oldest is closed first."""


@dataclass(frozen=True)
class _Parked:
    query: Mapping[str, str]
    session: Session
    since: float


class Parking:
    """Keeps live sessions in memory for tabs that reconnect with the same link. Frame loop's thread only.
    Only a feature keeps records (`app.feature.Feature.store`).
    """

    def __init__(self, clock: Callable[[], float] = monotonic) -> None:
        self._clock = clock
        self.parked: dict[str, _Parked] = {}

    @property
    def lasting(self) -> bool:
        return False

    @property
    def health(self) -> Mapping[str, object]:
        """Part of `/healthz`; network thread."""
        return {}

    @property
    def trouble(self) -> tuple[str, str] | None:
        """Title and English text of a warning for visitors."""
        return None

    def save(self, record: VisitorRecord) -> None: ...

    def recall(self, query: Mapping[str, str]) -> Generator[None, None, VisitorRecord | None]:
        """Record for a link's query; yields while it is read.

        Returns:
            None without a record, or if the live session is still here.
        """
        yield from ()
        return None

    def alone_has(self, query: Mapping[str, str]) -> bool:
        """True if no other process has the tab's state."""
        return tab_id(query) in self.parked

    def park(self, query: Mapping[str, str], session: Session) -> None:
        """Pause and keep a live session; close it without a valid id."""
        tab = tab_id(query)
        if tab is None:
            session.close()
            return
        session.hand.hold(None)
        self._close(tab)
        self.parked[tab] = _Parked(query, session, self._clock())
        self.tidy()

    def claim(self, query: Mapping[str, str]) -> Session | None:
        """Live session of a tab that is back by the same link; another link closes it."""
        self.tidy()
        tab = tab_id(query) or ""
        if not self.awaits(query):
            self._close(tab)
            return None
        return self.parked.pop(tab).session

    def awaits(self, query: Mapping[str, str]) -> bool:
        parked = self.parked.get(tab_id(query) or "")
        return parked is not None and link_of(parked.query) == link_of(query)

    def is_reload(self, query: Mapping[str, str]) -> bool:
        """True if the tab was reloaded, False if it only lost its connection."""
        parked = self.parked.get(tab_id(query) or "")
        return parked is not None and parked.query.get(OPENED) != query.get(OPENED)

    def tidy(self) -> None:
        now = self._clock()
        # The oldest first.
        for tab, parked in list(self.parked.items()):
            if now - parked.since <= AWAY and len(self.parked) <= MOST_SESSIONS:
                break
            self._close(tab)

    def close(self) -> None:
        for tab in list(self.parked):
            self._close(tab)

    def _close(self, tab: str) -> None:
        parked = self.parked.pop(tab, None)
        if parked is not None:
            parked.session.close()
