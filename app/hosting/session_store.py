"""What visitors who have gone left behind, by the id that each tab keeps."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import monotonic
from typing import Final

from app.lessons.session.lesson_session import LessonSession
from app.lessons.session.saved import SavedLesson
from app.session.session import Session
from app.settings import Settings

KEEP: Final = 600.0
"""How long a visitor may be away [s]."""

MOST_SESSIONS: Final = 8
"""Live sessions that are kept at once; the oldest makes room. Each holds the history of its run."""

MOST_RECORDS: Final = 300
"""Records that are kept at once; the oldest makes room."""

_TAB_ID: Final = re.compile(r"^[a-z0-9]{16,64}$")

_OF_THE_TAB: Final = ("resume", "window")
"""Parts of a query that describe the tab, and not what it shows."""


def tab_id(query: Mapping[str, str]) -> str | None:
    """Return the id that a tab keeps in its browser's storage; None if its query carries no valid one."""
    word = query.get("resume", "")
    return word if _TAB_ID.match(word) else None


def same_tab(query: Mapping[str, str], other: Mapping[str, str]) -> bool:
    """Return whether two queries come from the same tab with the same link."""
    return tab_id(query) is not None and tab_id(query) == tab_id(other) and _link_of(query) == _link_of(other)


def lesson_link(query: Mapping[str, str]) -> tuple[str, str]:
    """Return lesson and step of a link, as text."""
    return query.get("lesson", "")[:60], query.get("step", "")[:8]


def _link_of(query: Mapping[str, str]) -> dict[str, str]:
    return {key: value for key, value in query.items() if key not in _OF_THE_TAB}


@dataclass(frozen=True)
class VisitorRecord:
    """Settings and progress of a visitor, as plain data.

    Attributes:
        lessons: progress in the lessons; None if none was ever opened.
    """

    query: Mapping[str, str]
    settings: Settings
    lessons: SavedLesson | None


@dataclass(frozen=True)
class _Parked:
    link: dict[str, str]
    session: Session
    lessons: LessonSession
    since: float


class SessionStore:
    """Keeps a record of every visitor, and the live sessions of those who are away, under the tab's id. Belongs to the frame loop's thread.

    The same tab gets its live session back by the same link, and its record by any link. A visitor without a valid id leaves nothing.

    Args:
        keep_records: how long a record is kept [s]; a live session is kept for `KEEP`.
        clock: returns the time [s].
    """

    def __init__(self, keep_records: float = KEEP, clock: Callable[[], float] = monotonic) -> None:
        self._keep_records, self._clock = keep_records, clock
        self._records: dict[str, tuple[VisitorRecord, float]] = {}
        self._parked: dict[str, _Parked] = {}

    @property
    def parked(self) -> int:
        return len(self._parked)

    def save(self, record: VisitorRecord) -> None:
        """Keep a visitor's record instead of an earlier one."""
        tab = tab_id(record.query)
        if tab is not None:
            self._records.pop(tab, None)
            self._records[tab] = record, self._clock()
            self.tidy()

    def find(self, query: Mapping[str, str]) -> VisitorRecord | None:
        """Return the record of a visitor by the query of the new link; None if there is none."""
        self.tidy()
        found = self._records.get(tab_id(query) or "")
        return None if found is None else found[0]

    def park(self, query: Mapping[str, str], session: Session, lessons: LessonSession) -> None:
        """Keep a live session, which does not advance meanwhile; a session that cannot be claimed is closed."""
        tab = tab_id(query)
        if tab is None:
            session.close()
            return
        session.hold(None)
        self._close(tab)
        self._parked[tab] = _Parked(_link_of(query), session, lessons, self._clock())
        self.tidy()

    def claim(self, query: Mapping[str, str]) -> tuple[Session, LessonSession] | None:
        """Return the live session of a tab that is back by the same link, else None; by another link the session is closed."""
        self.tidy()
        tab = tab_id(query) or ""
        parked = self._parked.get(tab)
        if parked is None or parked.link != _link_of(query):
            self._close(tab)
            return None
        del self._parked[tab]
        return parked.session, parked.lessons

    def tidy(self) -> None:
        """Drop what is too old or too much."""
        now = self._clock()
        # Both are in order of age, the oldest first.
        for tab, (_, since) in list(self._records.items()):
            if now - since <= self._keep_records and len(self._records) <= MOST_RECORDS:
                break
            del self._records[tab]
        for tab, parked in list(self._parked.items()):
            if now - parked.since <= KEEP and len(self._parked) <= MOST_SESSIONS:
                break
            self._close(tab)

    def close(self) -> None:
        for tab in list(self._parked):
            self._close(tab)

    def _close(self, tab: str) -> None:
        parked = self._parked.pop(tab, None)
        if parked is not None:
            parked.session.close()
