"""What visitors who have gone left behind, by the id that each tab keeps."""

from collections.abc import Callable, Generator, Mapping
from concurrent.futures import wait
from dataclasses import dataclass, replace
from time import monotonic, time
from typing import Final, NamedTuple

from app.hosting.record_writer import RecordWriter
from app.hosting.serve_options import ServeOptions
from app.hosting.visitor_record import VisitorRecord, link_of, tab_id
from app.i18n.speaking import N_
from app.session.session import Session
from app.settings import OPENED

AWAY: Final = 600.0
"""How long a live session waits for its visitor [s]."""

MOST_SESSIONS: Final = 8
"""Live sessions that are kept at once; the oldest makes room. Each holds the history of its run."""

MOST_RECORDS: Final = 300
"""Records that are kept in memory at once, where there is no file; the oldest makes room."""

LOOK: Final = 0.002
"""How long a frame waits at a time for a record that is being read [s]."""


_NOT_SAVED: Final = (
    N_("This cannot be saved now"),
    N_("The server's disk cannot be written. Go on; saving is tried again."),
)
_DAMAGED: Final = (
    N_("Earlier work may be missing"),
    N_("The server's file was damaged. What could be read of it is here, and what you do now is saved."),
)


class StoreState(NamedTuple):
    """What becomes of the records, in words that the network may see.

    Attributes:
        lasting: whether they outlive the server.
        problem: why they cannot be written now; "" if they can.
        set_aside: name of the damaged file that was set aside last; "" if there is none.
    """

    lasting: bool
    problem: str
    set_aside: str


@dataclass(frozen=True)
class _Parked:
    query: Mapping[str, str]
    session: Session
    since: float


class SessionStore:
    """Keeps a record of every visitor, and the live sessions of those who are away, under the tab's id. Belongs to the frame loop's thread.

    The same tab gets its live session back by the same link, and its record by any link. A visitor without a valid id leaves nothing.

    Args:
        keep: how long a record is kept [s]; a live session is kept for `AWAY`.
        clock: returns the time [s].
        file: where records outlive the server; None for memory alone.
    """

    def __init__(
        self, keep: float = ServeOptions.keep, clock: Callable[[], float] = monotonic, file: RecordWriter | None = None
    ) -> None:
        self.keep, self._clock, self._file = keep, clock, file
        self._records: dict[str, tuple[VisitorRecord, float]] = {}
        self._parked: dict[str, _Parked] = {}

    @property
    def lasting(self) -> bool:
        """Return whether records outlive the server."""
        return self._file is not None

    @property
    def state(self) -> StoreState:
        file = self._file
        return StoreState(False, "", "") if file is None else StoreState(True, file.problem, file.aside[0])

    @property
    def trouble(self) -> tuple[str, str] | None:
        """Return title and text, in English, of what visitors have to know now; None if all is well."""
        if self._file is None:
            return None
        lately = abs(time() - self._file.aside[1]) < AWAY
        return _NOT_SAVED if self._file.problem else _DAMAGED if lately else None

    def alone_has(self, query: Mapping[str, str]) -> bool:
        """Return whether what a tab comes back for is in this process, and nowhere else."""
        tab = tab_id(query)
        return self._file is None and (tab in self._records or tab in self._parked)

    def save(self, record: VisitorRecord) -> None:
        """Keep a visitor's record instead of an earlier one."""
        tab = tab_id(record.query)
        if tab is None:
            return
        if self._file is not None:
            self._file.put(tab, record)
            return
        self._records.pop(tab, None)
        self._records[tab] = record, self._clock()
        self.tidy()

    def save_named(self, name: str, record: VisitorRecord) -> None:
        """Keep a record of no tab, where records outlive the server. `name`: of the record, too short to be a tab's id."""
        if self._file is not None:
            self._file.put(name, record)

    def named(self, name: str) -> VisitorRecord | None:
        """Newest record of a name, see `save_named`; None if nothing was saved. Waits for the disk."""
        return None if self._file is None else self._file.ask(name).result()

    def recall(self, query: Mapping[str, str]) -> Generator[None, None, VisitorRecord | None]:
        """Find the record of a visitor by the query of the new link; None if there is none, or if the live session waits for this visitor.

        Yields while it is being read.
        """
        tab = tab_id(query) or ""
        parked = self._parked.get(tab)
        if parked is not None and link_of(parked.query) == link_of(query):
            return None
        if tab and self._file is not None:
            answer = self._file.ask(tab)
            while not wait((answer,), LOOK).done:
                yield
            return answer.result()
        self.tidy()
        found = self._records.get(tab)
        return None if found is None else found[0]

    def park(self, query: Mapping[str, str], session: Session) -> None:
        """Keep a live session, which does not advance meanwhile; a session that cannot be claimed is closed."""
        tab = tab_id(query)
        if tab is None:
            session.close()
            return
        session.hold(None)
        self._close(tab)
        self._parked[tab] = _Parked(query, session, self._clock())
        self.tidy()

    def claim(self, query: Mapping[str, str]) -> Session | None:
        """Return the live session of a tab that is back by the same link, else None; by another link the session is closed."""
        self.tidy()
        tab = tab_id(query) or ""
        parked = self._parked.get(tab)
        if parked is None or link_of(parked.query) != link_of(query):
            self._close(tab)
            return None
        del self._parked[tab]
        return parked.session

    def is_reload(self, query: Mapping[str, str]) -> bool:
        """True if the tab of a live session has loaded its page again; False if only its connection was lost."""
        parked = self._parked.get(tab_id(query) or "")
        return parked is not None and parked.query.get(OPENED) != query.get(OPENED)

    def tidy(self) -> None:
        """Drop what is too old or too much."""
        now = self._clock()
        # Both are in order of age, the oldest first.
        for tab, (_, since) in list(self._records.items()):
            if now - since <= self.keep and len(self._records) <= MOST_RECORDS:
                break
            del self._records[tab]
        if len(self._records) > MOST_SESSIONS:
            # Only the newest ones hold inputs of minutes.
            tab = list(self._records)[-MOST_SESSIONS - 1]
            record, since = self._records[tab]
            if record.state is not None:
                self._records[tab] = replace(record, state=None), since
        for tab, parked in list(self._parked.items()):
            if now - parked.since <= AWAY and len(self._parked) <= MOST_SESSIONS:
                break
            self._close(tab)

    def close(self) -> None:
        """Close every session, and write what is not written yet."""
        for tab in list(self._parked):
            self._close(tab)
        if self._file is not None:
            self._file.close()

    def _close(self, tab: str) -> None:
        parked = self._parked.pop(tab, None)
        if parked is not None:
            parked.session.close()
